// The picture from maps, the one by integration in its place, or the absolute difference of both; linear.
#version 330 core

uniform sampler2D drawn;        // from maps; alpha is the coverage
uniform sampler2D integrated;   // objects alone, multiplied by their coverage, at any resolution
uniform bool difference;
uniform float amplified;        // by how much a difference is

in vec2 ndc;

out vec4 radiance;

void main() {
    vec2 uv = 0.5 * ndc + 0.5;
    vec4 ours = textureLod(drawn, uv, 0.0);
    vec4 theirs = textureLod(integrated, uv, 0.0);
    bool object = ours.a > 0.5 && theirs.a > 0.0;
    vec3 reflected = theirs.rgb / max(theirs.a, 1e-6);
    if (difference)
        radiance = vec4(object ? amplified * abs(ours.rgb - reflected) : vec3(0.0), ours.a);
    else
        radiance = object ? vec4(reflected, ours.a) : ours;
}
