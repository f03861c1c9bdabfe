// The mean of the samples of each pixel so far, with one more.
#version 330 core

uniform sampler2D drawn;
uniform sampler2D before;       // the mean of the samples before it
uniform float weight;           // 1 / the number of samples, this one included

in vec2 ndc;

out vec4 radiance;

void main() {
    vec2 uv = 0.5 * ndc + 0.5;
    vec4 sample_ = textureLod(drawn, uv, 0.0);
    radiance = weight < 1.0 ? mix(textureLod(before, uv, 0.0), sample_, weight) : sample_;
}
