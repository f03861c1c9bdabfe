// A near viewer [RH02 section 7.5]: the sum of B_pq(C) Y_pq(V) [RH02 eq. 7] for each pixel, or, for lobes about
// the tangent, of B_p0(C) Y_p0(C.V) [RH02 eq. 6].
uniform sampler2DArray maps;  // layer face * maps + z, faces with a border of `border` texels in their own plane
uniform int P;
uniform bool zonal;
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

// f_pq by recurrence over p from f_qq, with the Condon-Shortley phase and without its sin^q.
float next_degree(int p, int q, float z, float f, float before) {
    float pp = float(p * p), qq = float(q * q), below = float((p - 1) * (p - 1));
    float a = sqrt((4.0 * pp - 1.0) / (pp - qq));
    float b = p - 1 > q ? a * sqrt((below - qq) / (4.0 * below - 1.0)) : 0.0;
    return a * z * f - b * before;
}

vec3 reflected(vec3 c, vec3 v) {
    find_place(c, zonal ? P + 1 : (P + 1) * (P + 1));
    vec3 sum = vec3(0.0);
    if (zonal) {
        float z = dot(c, v), f = sqrt(1.0 / (4.0 * pi)), before = 0.0;
        for (int p = 0; p <= P; ++p) {
            sum += f * map_at(p);
            float next = next_degree(p + 1, 0, z, f, before);
            before = f;
            f = next;
        }
        return sum;
    }
    float start = sqrt(1.0 / (4.0 * pi));
    vec2 power = vec2(1.0, 0.0);  // (x + iy)^q
    for (int q = 0; q <= P; ++q) {
        float f = start, before = 0.0;
        for (int p = q; p <= P; ++p) {
            int index = p * (p + 1);
            if (q == 0)
                sum += f * map_at(index);
            else
                sum += sqrt(2.0) * f * (power.x * map_at(index + q) + power.y * map_at(index - q));
            float next = next_degree(p + 1, q, v.z, f, before);
            before = f;
            f = next;
        }
        start *= -sqrt(float(2 * q + 3) / float(2 * q + 2));
        power = vec2(power.x * v.x - power.y * v.y, power.x * v.y + power.y * v.x);
    }
    return sum;
}
