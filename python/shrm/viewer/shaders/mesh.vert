// A mesh's vertices, as they are in the world.
#version 330 core

uniform mat4 clip_from_world;

in vec3 position;
in vec3 normal;
in vec2 uv;

out vec3 at;  // world
out vec3 smooth_normal;
out vec2 texture_at;

void main() {
    at = position;
    smooth_normal = normal;
    texture_at = uv;
    gl_Position = clip_from_world * vec4(position, 1.0);
}
