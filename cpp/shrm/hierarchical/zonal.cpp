#include <algorithm>
#include <cmath>

#include "shrm/hierarchical/hierarchical.hpp"
#include "shrm/hierarchical/walk.hpp"

namespace shrm::hierarchical {
namespace {

// All in s = sin(theta_i / 2) = |C - L| / 2, by which an angle less moves a direction half of it at most.
template <int channels_>
struct ZonalKernel {
    static constexpr int channels = channels_;

    const float* table;
    int intervals, row;  // of a profile; values in a row
    float finest;
    Directions axis = {};
    Ints from[groups] = {};          // where the row of a target begins
    Numbers along = {};              // and how far it is to the next
    Numbers inner = {}, outer = {};  // where it could hide
    Numbers first = {}, last = {};   // where it is

    struct Value {
        Floats u[groups][channels];
        Floats s[groups];
    };
    SHRM_INLINE Value at(const Pyramid::Node& node) const {
        Value value;
        for (int k = 0; k < groups; ++k) {
            const Floats s = 0.5f * root(axis.chord2(k, node));
            value.s[k] = s;
            const Floats place = static_cast<float>(intervals) * (s < 1.0f ? s : Floats{} + 1.0f);
            const Ints cell = truncated(place);
            const Floats t = place - floats_of(cell);
            for (int c = 0; c < channels; ++c) {
                const float* low = table + c * (intervals + 2);
                const float* high = low + row;
                const Ints at = from[k] + cell;
                const Floats a = mixed(gather(low, at), gather(low + 1, at), t);
                const Floats b = mixed(gather(high, at), gather(high + 1, at), t);
                value.u[k][c] = mixed(a, b, along[k]);
            }
        }
        return value;
    }
    SHRM_INLINE bool reaches(const Value& value, float radius) const {
        return within(value, first, last, radius);
    }
    SHRM_INLINE bool hides(const Value& value, float radius) const {
        return radius > finest && within(value, inner, outer, radius);
    }
    SHRM_INLINE static bool within(const Value& value, const Numbers& low, const Numbers& high,
                                   float radius) {
        const float reach = 0.5f * radius;
        Ints found = {};
        for (int k = 0; k < groups; ++k)
            found |= (value.s[k] > low[k] - reach) & (value.s[k] < high[k] + reach);
        return any(found);
    }
};

template <int channels>
Effort zonal(const Pyramid& pyramid, const angular::ZonalProfiles& profiles,
             std::span<const angular::Band> supports, const Descent& descent,
             std::span<const glm::dvec3> axes, std::span<const double> theta_o, std::span<float> out) {
    const int row = channels * (profiles.intervals + 2);
    const ZonalKernel<channels> lobe{profiles.values.data(), profiles.intervals, row,
                                     static_cast<float>(descent.finest)};
    return integrate(
        pyramid, descent, lobe, axes.size(),
        [&](auto& kernel, int k, std::size_t target) {
            kernel.axis.set(k, axes[target]);
            const double place = theta_o[target] / pi * (profiles.rows - 1);
            const int from = std::clamp(static_cast<int>(place), 0, profiles.rows - 2);
            kernel.from[k / lanes][k % lanes] = from * row;
            kernel.along.set(k, place - from);
            const auto of_both = [&](std::span<const angular::Band> bands, Numbers& low, Numbers& high) {
                const angular::Band &a = bands[size(from)], &b = bands[size(from) + 1];
                low.set(k, std::sin(0.5 * std::min(a.inner, b.inner)));
                high.set(k, std::sin(0.5 * std::max(a.outer, b.outer)));
            };
            of_both(profiles.bands, kernel.inner, kernel.outer);
            of_both(supports, kernel.first, kernel.last);
        },
        out);
}

}  // namespace

Effort integrate_zonal(const Pyramid& pyramid, const angular::ZonalProfiles& profiles,
                       std::span<const angular::Band> supports, const Descent& descent,
                       std::span<const glm::dvec3> axes, std::span<const double> theta_o,
                       std::span<float> out) {
    const auto run = profiles.channels == 1 ? zonal<1> : zonal<3>;
    return run(pyramid, profiles, supports, descent, axes, theta_o, out);
}

}  // namespace shrm::hierarchical
