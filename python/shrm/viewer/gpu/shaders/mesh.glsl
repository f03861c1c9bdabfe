// What is seen at a pixel of a mesh.
in vec3 at;
in vec3 smooth_normal;
in vec2 texture_at;
#ifdef TANGENTS
in vec3 tangent_at;
#endif

// The side that is seen is the face's, not that of the interpolated normal, which may tip over at silhouettes.
bool find_surface(out Surface surface) {
    vec3 towards_eye = -ray_through(at);
    vec3 face = normalize(cross(dFdx(at), dFdy(at)));
    if (dot(face, towards_eye) < 0.0) face = -face;
    vec3 n = dot(smooth_normal, smooth_normal) > 0.0 ? normalize(smooth_normal) : face;
    surface.normal = dot(n, face) < 0.0 ? -n : n;
    surface.towards_eye = towards_eye;
    surface.uv = texture_at;
#ifdef TANGENTS
    surface.tangent = tangent_at;
#else
    surface.tangent = vec3(0.0);
#endif
    return true;
}
