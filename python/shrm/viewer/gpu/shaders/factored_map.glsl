// A near viewer [RH02 section 7.5]: the sum of B_pq(C) Y_pq(V) [RH02 eq. 7] for each pixel, or, for lobes about
// the tangent, of B_p0(C) Y_p0(C.V) [RH02 eq. 6].
uniform int P;
uniform bool zonal;

// f_pq by recurrence over p from f_qq, with the Condon-Shortley phase and without its sin^q.
float next_degree(int p, int q, float z, float f, float before) {
    float pp = float(p * p), qq = float(q * q), below = float((p - 1) * (p - 1));
    float a = sqrt((4.0 * pp - 1.0) / (pp - qq));
    float b = p - 1 > q ? a * sqrt((below - qq) / (4.0 * below - 1.0)) : 0.0;
    return a * z * f - b * before;
}

vec3 reflected(vec3 c, vec3 v, vec3 towards_eye) {
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
