#include <cmath>
#include <vector>

#include "shrm/angular/profile.hpp"
#include "shrm/hierarchical/hierarchical.hpp"
#include "shrm/hierarchical/walk.hpp"

namespace shrm::hierarchical {
namespace {

template <bool held, int channels_>
struct RadialKernel {
    static constexpr int channels = channels_;

    const angular::Cubics<held>* profile;
    float g;
    float support, outer, finest;  // radians
    Directions center = {};        // g C, so that the variable is 1 + |g C - g L|^2

    struct Value {
        Floats u[groups][channels];
        Floats place[groups];  // the profile's variable
    };
    SHRM_INLINE Value at(const Pyramid::Node& node) const {
        Value value;
        for (int k = 0; k < groups; ++k) {
            value.place[k] = 1.0f + center.chord2(k, node, g);
            for (int c = 0; c < channels; ++c) value.u[k][c] = profile[c].anywhere(value.place[k]);
        }
        return value;
    }
    SHRM_INLINE bool reaches(const Value& value, float radius) const {
        return within(value, support + radius);
    }
    SHRM_INLINE bool hides(const Value& value, float radius) const {
        return radius > finest && within(value, outer + radius);
    }

    // Chords are no longer than their angles: what has a greater variable lies beyond `angle` of a center.
    SHRM_INLINE bool within(const Value& value, float angle) const {
        const float chord = g * angle, beyond = 1.0f + chord * chord;
        Ints found = {};
        for (const Floats& place : value.place) found |= place < beyond;
        return any(found);
    }
};

template <bool held, int channels>
Effort radial(const Pyramid& pyramid, const angular::RadialProfile& profile, double outer,
              const Descent& descent, std::span<const glm::dvec3> centers, std::span<float> out) {
    std::vector<angular::Cubics<held>> cubics;
    for (int c = 0; c < channels; ++c) cubics.emplace_back(profile, c);
    const double g = 0.5 * std::sqrt(profile.scale);
    const RadialKernel<held, channels> lobe{cubics.data(), static_cast<float>(g),
                                            static_cast<float>(profile.support), static_cast<float>(outer),
                                            static_cast<float>(descent.finest)};
    return integrate(
        pyramid, descent, lobe, centers.size(),
        [&](auto& kernel, int k, std::size_t target) { kernel.center.set(k, g * centers[target]); }, out);
}

}  // namespace

Effort integrate_radial(const Pyramid& pyramid, const angular::RadialProfile& profile, double outer,
                        const Descent& descent, std::span<const glm::dvec3> centers, std::span<float> out) {
    const bool held = profile.segments == angular::held_segments, one = profile.channels == 1;
    const auto run =
        held ? (one ? radial<true, 1> : radial<true, 3>) : (one ? radial<false, 1> : radial<false, 3>);
    return run(pyramid, profile, outer, descent, centers, out);
}

}  // namespace shrm::hierarchical
