// A lat-long environment as core.hpp has it, its first row about +z: radiance times solid angle, and solid
// angle.
const float pi = 3.14159265358979;

uniform sampler2D environment;
uniform int most_columns;  // of a constant some compilers make as many look-ups for every texel

// The mean over about `extent` radians round a direction. Columns are narrower than rows by the sine:
// beside the poles, several are taken along the row.
vec3 light_within(vec3 d, float extent) {
    vec2 size = vec2(textureSize(environment, 0));
    float sine = length(d.xy), level = max(0.0, log2(extent * size.y / pi));
    float u = 0.5 - atan(d.y, d.x) / (2.0 * pi), v = atan(sine, d.z) / pi;
    float half_row = 0.5 / max(1.0, size.y / exp2(level));
    v = clamp(v, half_row, 1.0 - half_row);
    float wide = min(extent / (2.0 * pi * max(sine, 1e-6)), 1.0);  // of the row
    int count = clamp(int(ceil(wide * size.x / exp2(level))), 1, most_columns);
    vec4 sum = vec4(0.0);
    for (int k = 0; k < count; ++k)
        sum += textureLod(environment, vec2(u + wide * ((float(k) + 0.5) / float(count) - 0.5), v), level);
    return sum.rgb / sum.a;
}
