// What a texel of a layer knows of itself.
uniform float radius;   // of the disc, in texels
uniform float largest;  // that the target's texels hold

flat in int layer;

out vec4 radiance;

// In radii from the center of the face; x to the right, y downwards.
vec2 place(float side) {
    return (gl_FragCoord.xy - 0.5 * side) / radius;
}

// A number that is too large for the target would be infinite there, and spread.
void store(vec3 light) {
    radiance = vec4(clamp(light, -largest, largest), 1.0);
}
