// Reflected light of one lobe of an object: linear radiance, and 1 for its coverage if it is the first.
uniform bool distant;
uniform bool first_lobe;
uniform vec3 axis;  // tangents run around it where the surface has none
uniform sampler2D picture;  // multiplies the reflected light [RH02 section 3]

out vec4 radiance;

vec3 tangent_around(vec3 n) {
    vec3 t = cross(axis, n);
    if (dot(t, t) > 1e-12) return normalize(t);
    vec3 a = abs(n);  // where N is the axis itself, any tangent
    vec3 least = a.x <= a.y && a.x <= a.z ? vec3(1, 0, 0) : a.y <= a.z ? vec3(0, 1, 0) : vec3(0, 0, 1);
    return normalize(cross(least, n));
}

vec3 orthogonalised(vec3 t, vec3 n) {
    t -= dot(t, n) * n;
    return dot(t, t) > 1e-12 ? normalize(t) : tangent_around(n);
}

void main() {
    Surface surface;
    if (!find_surface(surface)) discard;
    vec3 n = surface.normal, towards_eye = distant ? -forward : surface.towards_eye, v = towards_eye;
    vec3 c = central_direction(n, orthogonalised(surface.tangent, n), v);
    vec3 light = reflected(c, v, towards_eye);
    if (clamped) light = max(light, 0.0);
    radiance = vec4(light * texture(picture, surface.uv).rgb, first_lobe ? 1.0 : 0.0);
}
