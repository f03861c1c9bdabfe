// A lat-long picture, each texel times its solid angle, and that beside it: sums of both, over any texels,
// give the mean radiance. A plain mip-map would make much of the rows beside the poles, which are hardly
// there.
#version 330 core

const float pi = 3.14159265358979;

uniform sampler2D picture;

out vec4 weighted;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    float weight = sin(pi * gl_FragCoord.y / float(textureSize(picture, 0).y));
    weighted = vec4(weight * texelFetch(picture, at, 0).rgb, weight);
}
