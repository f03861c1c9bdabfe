// A lobe about each texel's direction as a sum over taps, each the mean of the light over its solid angle:
// filtered importance sampling (Krivanek and Colbert, GPU Gems 3, chapter 20).
uniform sampler2DArray light;
uniform sampler2D taps;  // a row of directions about +z and log2 of the root of solid angles, one of weights
uniform int count;
uniform float last_level;

void main() {
    float side = float(textureSize(light, 0).x);
    vec3 c = from_face(place(side));
    // The smallest turn from z to c: it has no seam on a face, and is the mirrored one on the other.
    vec3 x = vec3(1.0 - c.x * c.x / (1.0 + c.z), -c.x * c.y / (1.0 + c.z), -c.x);
    vec3 y = vec3(x.y, 1.0 - c.y * c.y / (1.0 + c.z), -c.y);
    vec3 sum = vec3(0.0);
    for (int k = 0; k < count; ++k) {
        vec4 tap = texelFetch(taps, ivec2(k, 0), 0);
        vec3 d = of_world(tap.x * x + tap.y * y + tap.z * c, layer);
        int face = d.z >= 0.0 ? 0 : 1;
        // The root of a texel's solid angle is (1 + |z|) / radius.
        float level = clamp(tap.w + log2(radius / (1.0 + abs(d.z))), 0.0, last_level);
        vec2 at = 0.5 + on_face(d, face) * radius / side;
        sum += texelFetch(taps, ivec2(k, 1), 0).rgb * textureLod(light, vec3(at, float(face)), level).rgb;
    }
    store(sum);
}
