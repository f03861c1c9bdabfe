// C, the direction that a reflection map is looked up in: R, N, T or the center of the lobe.
const int REFLECTION = 0, NORMAL = 1, TANGENT = 2, LOBE = 3;

uniform int center;
uniform sampler2D gamma;  // between C and N, by theta_v over [0, pi/2]

// C = cos(gamma) N - sin(gamma) (V - (N.V) N) / |V - (N.V) N|. Interpolated normals can turn away from the eye:
// the reflection is used as it is, about the lobe and the normal V is brought back to the horizon.
vec3 central_direction(vec3 n, vec3 t, inout vec3 v) {
    float cosine = dot(n, v);
    if (center == REFLECTION) return 2.0 * cosine * n - v;
    if (center == TANGENT) return t;
    vec3 across = v - cosine * n;
    float sine = length(across);
    across = sine > 1e-6 ? across / sine : vec3(0.0);
    if (cosine < 0.0) {
        v = across;
        sine = 1.0;
        cosine = 0.0;
    }
    if (center == NORMAL) return n;
    int last = textureSize(gamma, 0).x - 1;
    float place = atan(sine, cosine) * 2.0 / pi * float(last);
    int from = min(int(place), last - 1);
    float angle = mix(texelFetch(gamma, ivec2(from, 0), 0).r, texelFetch(gamma, ivec2(from + 1, 0), 0).r,
                      place - float(from));
    return cos(angle) * n - sin(angle) * across;
}
