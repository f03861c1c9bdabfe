// What is seen at a pixel of an exact sphere.
uniform vec4 sphere;  // center, radius
uniform mat4 clip_from_world;

in vec3 at;  // on the far side of its box

bool find_surface(out Surface surface) {
    vec3 ray = ray_through(at);
    vec3 offset = at - sphere.xyz;
    float to_middle = -dot(offset, ray);
    vec3 across = offset + to_middle * ray;
    float half_chord = sphere.w * sphere.w - dot(across, across);
    if (half_chord <= 0.0) return false;
    half_chord = sqrt(half_chord);
    // From where the ray begins, the eye or the plane across it, to the middle of the chord.
    float middle = orthographic ? dot(at + to_middle * ray - eye, forward) : dot(sphere.xyz - eye, ray);
    if (middle + half_chord <= 0.0) return false;
    bool inside = middle - half_chord <= 0.0;
    vec3 outward = (across + (inside ? half_chord : -half_chord) * ray) / sphere.w;
    surface.normal = inside ? -outward : outward;
    surface.towards_eye = -ray;
    surface.uv = vec2(0.5 + atan(outward.y, outward.x) / (2.0 * pi),
                      1.0 - atan(length(outward.xy), outward.z) / pi);
    surface.tangent = vec3(0.0);
    vec4 clip = clip_from_world * vec4(sphere.xyz + sphere.w * outward, 1.0);
    gl_FragDepth = 0.5 + 0.5 * clip.z / clip.w;
    return true;
}
