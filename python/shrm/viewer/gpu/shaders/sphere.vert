// The box about a sphere: what is seen within it is found for each pixel, exactly.
uniform mat4 clip_from_world;
uniform vec4 sphere;  // center, radius

in vec3 position;  // corners of a cube of side 2

out vec3 at;  // world

void main() {
    at = sphere.xyz + sphere.w * position;
    gl_Position = clip_from_world * vec4(at, 1.0);
    gl_Position.z = 0.0;  // the box is not cut by near and far planes: each pixel has its own depth
}
