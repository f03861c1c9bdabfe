// A mesh's vertices, as they are in the world; TANGENTS is defined where they have tangents.
uniform mat4 clip_from_world;

in vec3 position;
in vec3 normal;
in vec2 uv;
#ifdef TANGENTS
in vec3 tangent;
#endif

out vec3 at;  // world
out vec3 smooth_normal;
out vec2 texture_at;
#ifdef TANGENTS
out vec3 tangent_at;
#endif

void main() {
    at = position;
    smooth_normal = normal;
    texture_at = uv;
#ifdef TANGENTS
    tangent_at = tangent;
#endif
    gl_Position = clip_from_world * vec4(position, 1.0);
}
