// A near viewer, by the layers of a prefiltered map [KVHS00 section 4], in the shares that its class gives them.
const int SLICED = 0, FACTORED = 1, TWELVE_VIEWS = 2;

uniform int shares;
uniform int layers;
uniform float largest;      // angle between C and V: of the last slice, of the last factor
uniform sampler2D factors;  // a row for each layer
uniform vec3 vertices[12];
uniform ivec3 faces[20];
uniform mat3 coordinates[20];  // of a direction along the three corners of each face

float solid_angle(vec3 a, vec3 b, vec3 c) {
    return 2.0 * atan(dot(a, cross(b, c)), 1.0 + dot(a, b) + dot(b, c) + dot(c, a));
}

// Those of the three vertices of the icosahedron around the view, with barycentric weights of the triangle.
vec3 of_twelve_views(vec3 towards_eye) {
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
    return share.x * map_at(corner.x) + share.y * map_at(corner.y) + share.z * map_at(corner.z);
}

vec3 reflected(vec3 c, vec3 v, vec3 towards_eye) {
    find_place(c, layers);
    if (shares == TWELVE_VIEWS) return of_twelve_views(towards_eye);
    float theta_o = 2.0 * atan(length(c - v), length(c + v));
    int last = (shares == SLICED ? layers : textureSize(factors, 0).x) - 1;
    float at = min(theta_o / largest, 1.0) * float(last);
    int low = clamp(int(at), 0, max(last - 1, 0));
    float t = at - float(low);
    if (shares == SLICED) return mix(map_at(low), map_at(min(low + 1, last)), t);
    vec3 sum = vec3(0.0);
    for (int k = 0; k < layers; ++k)
        sum += mix(texelFetch(factors, ivec2(low, k), 0).rgb,
                   texelFetch(factors, ivec2(min(low + 1, last), k), 0).rgb, t) * map_at(k);
    return sum;
}
