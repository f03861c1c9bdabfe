// Radiance between the vertices of a face: linear, and 1 for its coverage.
#version 330 core

uniform sampler2D picture;  // multiplies it

in vec3 light;
in vec2 texture_at;

out vec4 radiance;

void main() {
    radiance = vec4(light * texture(picture, texture_at).rgb, 1.0);
}
