// Dual-paraboloid maps, for any viewer: both faces show what is about z = 0, and are blended across it.
uniform sampler2DArray maps;
uniform int border;
uniform sampler2D factors;  // one row, over theta_v from 0 to pi/2

vec3 factor_at(vec3 c, vec3 v) {
    float theta_v = atan(length(c - v), length(c + v)) * (center == NORMAL ? 2.0 : 1.0);
    int last = textureSize(factors, 0).x - 1;
    float at = min(theta_v / (0.5 * pi), 1.0) * float(last);
    int low = min(int(at), last - 1);
    return mix(texelFetch(factors, ivec2(low, 0), 0).rgb, texelFetch(factors, ivec2(low + 1, 0), 0).rgb,
               at - float(low));
}

vec3 on_layer(vec3 c, int face, float radius, float side) {
    return textureLod(maps, vec3(0.5 + on_face(c, face) * radius / side, float(face)), 0.0).rgb;
}

vec3 blended(vec3 c) {
    float side = float(textureSize(maps, 0).x), radius = 0.5 * side - float(border);
    float rim = 1.0 + 0.5 * float(border) / radius;  // half of the border is used
    float band = (rim * rim - 1.0) / (rim * rim + 1.0);
    float upper = clamp(0.5 + 0.5 * c.z / band, 0.0, 1.0);
    if (upper == 1.0) return on_layer(c, 0, radius, side);
    if (upper == 0.0) return on_layer(c, 1, radius, side);
    return mix(on_layer(c, 1, radius, side), on_layer(c, 0, radius, side), upper);
}

vec3 reflected(vec3 c, vec3 v, vec3 towards_eye) {
    return factor_at(c, v) * blended(c);
}
