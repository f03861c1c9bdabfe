// Maps of one lobe, cubes all of them, where each face has a border of texels in its own plane: linear
// look-ups meet at the faces' edges.
uniform sampler2DArray maps;  // layer face * count + z
uniform int border;

vec3 place;  // in a face, and the layer of its first map

// Where C lies: OpenGL's faces +X -X +Y -Y +Z -Z, s to the right, t downwards.
void find_place(vec3 c, int count) {
    vec3 d = vec3(-c.y, c.z, c.x), a = abs(d);
    int face;
    vec2 st;
    if (a.x >= a.y && a.x >= a.z) {
        face = d.x > 0.0 ? 0 : 1;
        st = vec2(d.x > 0.0 ? -d.z : d.z, -d.y) / a.x;
    } else if (a.y >= a.z) {
        face = d.y > 0.0 ? 2 : 3;
        st = vec2(d.x, d.y > 0.0 ? d.z : -d.z) / a.y;
    } else {
        face = d.z > 0.0 ? 4 : 5;
        st = vec2(d.z > 0.0 ? d.x : -d.x, -d.y) / a.z;
    }
    float side = float(textureSize(maps, 0).x);
    place = vec3(((0.5 * st + 0.5) * (side - 2.0 * float(border)) + float(border)) / side,
                 float(face * count));
}

vec3 map_at(int z) {
    return texture(maps, vec3(place.xy, place.z + float(z))).rgb;
}
