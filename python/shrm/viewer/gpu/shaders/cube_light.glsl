// A cube map; its axes are OpenGL's with +Z front (the world's +x), +X right (-y) and +Y up (+z).
uniform samplerCube environment;

// The mean over about `extent` radians round a direction: a face's texels are 2 / its edge wide in the
// middle.
vec3 light_within(vec3 d, float extent) {
    float level = max(0.0, log2(0.5 * extent * float(textureSize(environment, 0).x)));
    return textureLod(environment, vec3(-d.y, d.z, d.x), level).rgb;
}
