// Dual-paraboloid maps [HS98], one face to a layer, with the axes of shrm.environment.layouts and rows that run
// downwards. A border continues each face beyond its disc.

float sign_of(int face) {
    return face == 0 ? 1.0 : -1.0;
}

// Where a direction falls in a face: from its center, in radii of the disc.
vec2 on_face(vec3 d, int face) {
    float s = sign_of(face);
    return vec2(-d.y, s * d.x) / (1.0 + s * d.z);
}

// Where a place in a face looks, with z towards its own axis; the other way round also mirrors the second
// face.
vec3 from_face(vec2 at) {
    float square = dot(at, at);
    return vec3(2.0 * at.y, -2.0 * at.x, 1.0 - square) / (1.0 + square);
}

vec3 of_world(vec3 d, int face) {
    float s = sign_of(face);
    return vec3(s * d.x, d.y, s * d.z);
}
