#include <algorithm>
#include <cmath>

#include "shrm/angular/caps.hpp"
#include "shrm/hierarchical/hierarchical.hpp"
#include "shrm/hierarchical/walk.hpp"

namespace shrm::hierarchical {
namespace {

// Smallest factor on the size of the finest nodes: the one for views at the horizon.
inline constexpr double least = 0.1;

template <int channels_>
struct IsotropicKernel {
    static constexpr int channels = channels_;

    const float *envelope, *ratio;
    float envelope_intervals, light_intervals, azimuth_intervals;
    int row, plane;     // of the ratio, for one view and channel
    int next_envelope;  // from one channel's to the next; 0 if they share it
    bool whole_lobe;
    float above, below;
    Directions x = {}, y = {}, normal = {};
    Directions center = {};  // of the lobe
    Numbers reach = {};      // of its cap, as half a chord
    Numbers finest = {};
    Numbers view_x = {}, view_z = {};
    Ints from[groups] = {};  // where the ratio of a target's view begins
    Numbers along_view = {};

    struct Value {
        Floats u[groups][channels];
        Floats height[groups];  // N.L
        Floats s2[groups];      // half the chord from the lobe's center, squared
    };
    SHRM_INLINE Value at(const Pyramid::Node& node) const {
        Value value;
        for (int k = 0; k < groups; ++k) {
            value.s2[k] = 0.25f * center.chord2(k, node);
            const Floats height = normal.along(k, node);
            value.height[k] = height;
            of_group(k, x.along(k, node), y.along(k, node), height, value.u[k]);
        }
        return value;
    }
    // For lights at (lx, ly, height) in the frames of a group.
    SHRM_INLINE void of_group(int k, const Floats& lx, const Floats& ly, const Floats& height,
                              Floats (&u)[channels]) const {
        using namespace angular;
        const Floats zero = {}, one = zero + 1.0f, tiny = zero + 1e-30f;
        const Floats z = height > zero ? (height < one ? height : one) : zero;
        const Floats hx = lx + view_x[k], hz = z + view_z[k], across = hx * hx + ly * ly;
        const Floats tangent = root(across) / (hz + root(across + hz * hz) + tiny);  // of theta_h / 2
        const Floats place = envelope_intervals * (tangent < one ? tangent : one);
        const Ints at = truncated(place);
        const auto enveloped = [&](const float* of) {
            return only(height > zero, mixed(gather(of, at), gather(of + 1, at), place - floats_of(at)));
        };
        Floats e = enveloped(envelope);

        // A root of nearly 1 may round to more than 1.
        const Floats light = light_intervals * root(larger(one - root(z), zero));
        const Floats azimuth =
            azimuth_intervals * (0.5f - 0.5f * lx / (magnitude(lx) + magnitude(ly) + tiny));
        const Ints light_cell = truncated(light), azimuth_cell = truncated(azimuth);
        const Floats along_light = light - floats_of(light_cell),
                     along_azimuth = azimuth - floats_of(azimuth_cell);
        const Ints cell = from[k] + light_cell * row + azimuth_cell;
        const auto in_slice = [&](const float* slice) {
            const Floats low = mixed(gather(slice, cell), gather(slice + 1, cell), along_azimuth);
            const Floats high =
                mixed(gather(slice + row, cell), gather(slice + row + 1, cell), along_azimuth);
            return mixed(low, high, along_light);
        };
        for (int c = 0; c < channels; ++c) {
            const float* slice = ratio + c * plane;
            if (c > 0 && next_envelope > 0) e = enveloped(envelope + c * next_envelope);
            u[c] = e * mixed(in_slice(slice), in_slice(slice + channels * plane), along_view[k]);
        }
        if (!whole_lobe) between_heights(u);
    }
    SHRM_INLINE void between_heights(Floats (&u)[channels]) const {
        const Floats zero = {};
        Floats mean = u[0];
        for (int c = 1; c < channels; ++c) mean += u[c];
        mean *= 1.0f / channels;
        mean = mean > zero ? mean : zero;
        const Floats core = mean / (above + mean + 1e-30f), m = mean * core;
        const Floats share = core * (below / (below + m));
        for (int c = 0; c < channels; ++c) u[c] *= share;
    }
    SHRM_INLINE bool reaches(const Value& value, float radius) const {  // above the horizon
        Ints found = {};
        for (const Floats& height : value.height) found |= height > -radius;
        return any(found);
    }
    SHRM_INLINE bool hides(const Value& value, float radius) const {
        Ints found = {};
        for (int k = 0; k < groups; ++k) {
            const Floats chord = reach[k] + 0.5f * radius;
            found |= (value.s2[k] < chord * chord) & (finest[k] < radius);
        }
        return any(found);
    }
};

template <int channels>
Effort isotropic(const Pyramid& pyramid, const angular::IsotropicTable& table, const Heights& heights,
                 const Descent& descent, std::span<const glm::dvec3> normals,
                 std::span<const glm::dvec3> views, std::span<float> out) {
    const int row = table.azimuth_intervals + 2, plane = row * (table.light_intervals + 2);
    const int nodes = table.envelope_intervals + 2;
    const int next_envelope = static_cast<int>(table.envelope.size()) > nodes ? nodes : 0;
    const IsotropicKernel<channels> lobe{table.envelope.data(),
                                         table.ratio.data(),
                                         static_cast<float>(table.envelope_intervals),
                                         static_cast<float>(table.light_intervals),
                                         static_cast<float>(table.azimuth_intervals),
                                         row,
                                         plane,
                                         next_envelope,
                                         heights.above == 0 && !std::isfinite(heights.below),
                                         static_cast<float>(heights.above),
                                         static_cast<float>(std::min(heights.below, 1e30))};
    return integrate(
        pyramid, descent, lobe, normals.size(),
        [&](auto& kernel, int k, std::size_t target) {
            const angular::LocalFrame frame(normals[target], views[target]);
            const angular::ViewPlace place(frame.cos_v, table.view_intervals);
            const angular::Visit visit(frame, place, table.caps);
            kernel.x.set(k, frame.x);
            kernel.y.set(k, frame.y);
            kernel.normal.set(k, frame.n);
            kernel.center.set(k, visit.axis);
            kernel.reach.set(k, std::sin(0.5 * visit.outer));
            // A turn of H out of the plane of N and V turns L by 2 cos(theta_v) of it about the mirror
            // direction; `finest` is for 45 degrees.
            kernel.finest.set(k, descent.finest * std::clamp(std::sqrt(2.) * frame.cos_v, least, 1.));
            kernel.view_x.set(k, std::sqrt(std::max(0.0, 1 - frame.cos_v * frame.cos_v)));
            kernel.view_z.set(k, frame.cos_v);
            kernel.from[k / lanes][k % lanes] = place.from * channels * plane;
            kernel.along_view.set(k, place.t);
        },
        out);
}

}  // namespace

Effort integrate_isotropic(const Pyramid& pyramid, const angular::IsotropicTable& table,
                           const Heights& heights, const Descent& descent,
                           std::span<const glm::dvec3> normals, std::span<const glm::dvec3> views,
                           std::span<float> out) {
    const auto run = table.channels == 1 ? isotropic<1> : isotropic<3>;
    return run(pyramid, table, heights, descent, normals, views, out);
}

}  // namespace shrm::hierarchical
