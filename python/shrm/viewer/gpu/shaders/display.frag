// From linear radiance to the screen, as shrm.render.tonemap: exposure, a clip at white, the sRGB curve.
#version 330 core

uniform sampler2D drawn;
uniform float gain;             // 2^exposure

in vec2 ndc;

out vec4 pixel;

void main() {
    vec3 x = clamp(gain * textureLod(drawn, 0.5 * ndc + 0.5, 0.0).rgb, 0.0, 1.0);
    vec3 curve = 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055;
    pixel = vec4(mix(curve, 12.92 * x, lessThanEqual(x, vec3(0.0031308))), 1.0);
}
