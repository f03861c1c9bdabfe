// The environment behind the objects, a lat-long picture as core.hpp has it, seamless across its edge and poles.
#version 330 core

const float pi = 3.14159265358979;

uniform sampler2D environment;
uniform vec3 poles[2];         // mean radiance of the first and the last row
uniform mat3 light_from_world;
uniform vec3 forward;
uniform vec3 right;            // as far as the right edge of the picture; 0 if orthographic
uniform vec3 up;
uniform vec2 shift;            // of the picture's points on the screen

in vec2 ndc;

out vec4 radiance;

void main() {
    vec2 at = ndc - shift;
    vec3 d = light_from_world * normalize(forward + at.x * right + at.y * up);
    vec2 size = vec2(textureSize(environment, 0));
    float row = atan(length(d.xy), d.z) / pi * size.y;  // OpenGL's acos is good to three digits only
    vec2 uv = vec2(0.5 - atan(d.y, d.x) / (2.0 * pi), clamp(row, 0.5, size.y - 0.5) / size.y);
    vec3 light = textureLod(environment, uv, 0.0).rgb;
    // From the centers of the first row to the pole is half a texel; the pole itself is the row's mean.
    float beyond = max(0.5 - row, row - (size.y - 0.5));
    if (beyond > 0.0) light = mix(light, poles[row < 1.0 ? 0 : 1], 2.0 * beyond);
    radiance = vec4(light, 0.0);
}
