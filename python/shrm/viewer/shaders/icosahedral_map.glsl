// A near viewer, by Cabral's twelve maps: those of the three vertices of an icosahedron around the view, blended
// with the barycentric weights of the spherical triangle.
uniform vec3 vertices[12];
uniform ivec3 faces[20];
uniform mat3 coordinates[20];  // of a direction along the three corners of each face

float solid_angle(vec3 a, vec3 b, vec3 c) {
    return 2.0 * atan(dot(a, cross(b, c)), 1.0 + dot(a, b) + dot(b, c) + dot(c, a));
}

vec3 reflected(vec3 c, vec3 v, vec3 towards_eye) {
    int face = 0;
    float inside = -4.0;
    for (int i = 0; i < 20; ++i) {
        vec3 along = coordinates[i] * towards_eye;
        float least = min(along.x, min(along.y, along.z));
        if (least > inside) {
            inside = least;
            face = i;
        }
    }
    ivec3 corner = faces[face];
    vec3 x = vertices[corner.x], y = vertices[corner.y], z = vertices[corner.z];
    vec3 share = max(vec3(solid_angle(towards_eye, y, z), solid_angle(x, towards_eye, z),
                          solid_angle(x, y, towards_eye)), 0.0);
    share /= share.x + share.y + share.z;
    find_place(c, 12);
    vec3 least = vec3(clamped ? 0.0 : -3e38);
    return share.x * max(map_at(corner.x), least) + share.y * max(map_at(corner.y), least) +
           share.z * max(map_at(corner.z), least);
}
