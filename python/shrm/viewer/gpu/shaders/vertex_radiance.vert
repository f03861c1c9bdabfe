// A mesh's vertices, as they are in the world, with the radiance that each sends to the eye.
#version 330 core

uniform mat4 clip_from_world;

in vec3 position;
in vec2 uv;
in vec3 radiance;

out vec3 light;
out vec2 texture_at;

void main() {
    light = radiance;
    texture_at = uv;
    gl_Position = clip_from_world * vec4(position, 1.0);
}
