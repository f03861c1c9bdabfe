// A shrunk map, a level of the mip-map, filtered with a kernel in texture space [KVHS00 section 5.2, steps
// 6, 8]. Beyond the border the outermost texels go on.
uniform sampler2DArray light;
uniform sampler2D kernel;
uniform int level;

void main() {
    ivec2 last = textureSize(light, level).xy - 1, size = textureSize(kernel, 0);
    ivec2 corner = ivec2(gl_FragCoord.xy) - size / 2;
    vec3 sum = vec3(0.0);
    for (int row = 0; row < size.y; ++row)
        for (int column = 0; column < size.x; ++column) {
            ivec2 at = clamp(corner + ivec2(column, row), ivec2(0), last);
            vec3 seen = texelFetch(light, ivec3(at, layer), level).rgb;
            sum += texelFetch(kernel, ivec2(column, row), 0).rgb * seen;
        }
    store(sum);
}
