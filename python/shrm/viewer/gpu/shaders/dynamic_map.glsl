// A distant viewer [RH02 section 7.5]: one reflection map for the view, an ordinary cube map. Its axes are
// OpenGL's with +Z front (the world's +x), +X right (-y) and +Y up (+z).
uniform samplerCube reflection_map;

vec3 reflected(vec3 c, vec3 v, vec3 towards_eye) {
    return texture(reflection_map, vec3(-c.y, c.z, c.x)).rgb;
}
