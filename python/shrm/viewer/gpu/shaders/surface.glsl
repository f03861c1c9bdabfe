// The eye and its rays, and what a pixel shows of a surface.
const float pi = 3.14159265358979;

uniform bool orthographic;
uniform vec3 eye;      // world
uniform vec3 forward;  // from the eye into the picture

uniform bool clamped;  // whether negative radiance of a lobe is set to zero

struct Surface {
    vec3 normal;       // unit, on the side that is seen
    vec3 towards_eye;  // unit
    vec2 uv;
    vec3 tangent;      // of any length; zero: around the object's axis
};

vec3 ray_through(vec3 point) {
    return orthographic ? forward : normalize(point - eye);
}
