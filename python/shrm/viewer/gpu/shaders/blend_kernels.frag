// Maps S and L, enlarged and blended by d^2 [KVHS00 section 5.2, steps 10 and 11]; in one pass S alone.
uniform sampler2DArray small;
uniform sampler2DArray large;
uniform bool two_passes;
uniform float side;

void main() {
    vec3 at = vec3(gl_FragCoord.xy / side, float(layer));
    vec3 light = textureLod(small, at, 0.0).rgb;
    if (two_passes) {
        vec2 d = place(side);
        light = mix(light, textureLod(large, at, 0.0).rgb, min(dot(d, d), 1.0));
    }
    store(light);
}
