#include <algorithm>
#include <cmath>
#include <vector>

#include "shrm/angular/angular.hpp"
#include "shrm/angular/queries.hpp"
#include "shrm/angular/sums.hpp"
#include "shrm/angular/texels.hpp"

namespace shrm::angular {
namespace {

// weight[j] += share u(theta_j), with sin^2(theta_j / 2) = ring + span azimuth[j].
SHRM_INLINE void add_profile(float* __restrict weight, const float* __restrict azimuth, int n, float ring,
                             float span, float share, const float* __restrict u, float intervals) {
    for (int j = 0; j < n; ++j) {
        const float x = intervals * std::sqrt(ring + span * azimuth[j]);
        const int k = static_cast<int>(x);
        const float t = x - static_cast<float>(k);
        weight[j] += share * (u[k] + t * (u[k + 1] - u[k]));
    }
}

struct Scratch {
    Reach reach;
    std::vector<float> azimuth;  // sin^2((phi - phi_C)/2), [k][row_length]
    std::vector<float> profile;  // at one theta_o
    std::vector<float> weight;   // [3][W]
};

void zonal_query(const Nodes& nodes, const Planes& planes, const ZonalProfiles& profiles,
                 const glm::dvec3& axis, const Band& band, Scratch& s, float* out) {
    const Center center(axis);
    along_columns(nodes, -0.5 * std::cos(center.phi), -0.5 * std::sin(center.phi), 0.5, s.azimuth);
    for (float& a : s.azimuth) a = a > 0 ? a : 0;
    s.reach.find(nodes, center, band);
    const std::size_t stride = size(round_up(nodes.W, most_lanes));
    s.weight.resize(3 * stride);
    const float* w[3];
    for (int c = 0; c < 3; ++c) w[c] = s.weight.data() + (c < profiles.channels ? size(c) : 0) * stride;
    Sum sum;
    for (int i = s.reach.first; i < s.reach.last; ++i) {
        const Arcs arcs = s.reach.columns(nodes, i);
        for (int part = 0; part < arcs.count; ++part) {
            const int begin = arcs.arc[part].begin, n = arcs.arc[part].end - begin;
            for (int c = 0; c < profiles.channels; ++c) {
                float* weight = s.weight.data() + size(c) * stride;
                std::fill_n(weight, n, 0.0f);
                for (int a = 0; a < nodes.k; ++a) {
                    const std::size_t node = size(i * nodes.k + a);
                    for (int b = 0; b < nodes.k; ++b)
                        add_profile(weight, s.azimuth.data() + b * row_length(nodes.W) + begin, n,
                                    static_cast<float>(center.ring(nodes, node)),
                                    static_cast<float>(center.span(nodes, node)),
                                    static_cast<float>(nodes.row_share[node] * nodes.column_share[size(b)]),
                                    s.profile.data() + c * (profiles.intervals + 2),
                                    static_cast<float>(profiles.intervals));
                }
            }
            const float* light[3] = {planes.at(0, i, begin), planes.at(1, i, begin), planes.at(2, i, begin)};
            accumulate(w, light, n, sum);
        }
    }
    sum.write(out);
}

}  // namespace

void integrate_zonal(const Picture& picture, const ZonalProfiles& profiles, std::span<const glm::dvec3> axes,
                     std::span<const double> theta_o, std::span<float> out) {
    const Nodes nodes(picture);
    const Planes planes(picture);
    const std::size_t length = size(profiles.channels * (profiles.intervals + 2));
    for_each_query<Scratch>(axes.size(), [&](std::size_t q, Scratch& s) {
        const double place = theta_o[q] / pi * (profiles.rows - 1);
        const int from = std::clamp(static_cast<int>(place), 0, profiles.rows - 2);
        mix_rows(profiles.values.data(), length, from, static_cast<float>(place - from), s.profile);
        const Band& low = profiles.bands[size(from)];
        const Band& high = profiles.bands[size(from) + 1];
        const Band band = {std::min(low.inner, high.inner), std::max(low.outer, high.outer)};
        zonal_query(nodes, planes, profiles, axes[q], band, s, &out[3 * q]);
    });
}

}  // namespace shrm::angular
