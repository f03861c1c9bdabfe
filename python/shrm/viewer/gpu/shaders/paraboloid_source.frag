// A paraboloid's texel as the mean of the environment over it: samples x samples places, each of which
// takes the light within its part.
uniform float side;
uniform mat3 light_from_world;
uniform int samples;  // to a side

void main() {
    vec3 sum = vec3(0.0);
    for (int row = 0; row < samples; ++row)
        for (int column = 0; column < samples; ++column) {
            vec2 offset = (vec2(column, row) + 0.5) / float(samples) - 0.5;
            vec3 d = from_face(place(side) + offset / radius);
            // An edge of a texel is (1 + z) / radius radians there.
            sum += light_within(light_from_world * of_world(d, layer), (1.0 + d.z) / (radius * float(samples)));
        }
    store(sum / float(samples * samples));
}
