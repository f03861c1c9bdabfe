#include "shrm/reflection/explicit_maps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "shrm/core.hpp"
#include "shrm/reflection/view_map.hpp"
#include "shrm/sh/view_harmonics.hpp"
#include "shrm/simd/shuffles.hpp"
#include "shrm/simd/vectors.hpp"

namespace shrm {
namespace {

// Y_pq(V) = polar(p, |q|) azimuth(q) over a grid of views.
struct GridOfViews {
    int T, P;
    std::vector<float> polar;    // (a, p (p+1) + |q|)
    std::vector<float> azimuth;  // (b, P + q)

    GridOfViews(int T_, int P_)
        : T(T_), P(P_), polar(size(T_) * basis_size(P_)), azimuth(size(T_ * (2 * P_ + 1))) {
        const LegendreRecurrence& recurrence = view_recurrence();
        for (int a = 0; a < T; ++a) {
            const double theta = (a + 0.5) * pi / T, x = std::cos(theta);
            for (int q = 0; q <= P; ++q) {
                double f = recurrence.start(q) * power(std::sin(theta), q), previous = 0;
                for (int p = q; p <= P; ++p) {
                    polar[size(a) * basis_size(P) + lm(p, q)] = static_cast<float>(f);
                    const auto [up, back] = recurrence.steps(q)[p - q];
                    const double next = up * x * f - back * previous;
                    previous = f;
                    f = next;
                }
            }
        }
        for (int b = 0; b < T; ++b) {
            const double phi = pi - 2 * pi * (b + 0.5) / T;
            for (int q = -P; q <= P; ++q)
                azimuth[size(b * (2 * P + 1) + P + q)] = static_cast<float>(
                    q == 0 ? 1 : std::numbers::sqrt2 * (q > 0 ? std::cos(q * phi) : std::sin(-q * phi)));
        }
    }
};

constexpr int largest_orders = 2 * largest_P + 1;

// One vector of texels in all maps of the set; `stride` floats from map to map, `count` texels of the vector.
SHRM_KERNEL inline void texels_at_views(const GridOfViews& views, const float* ring, int W, int count,
                                        float* pixels, std::size_t stride) {
    const int P = views.P, orders = 2 * P + 1;
    for (int a = 0; a < views.T; ++a) {
        const float* polar = &views.polar[size(a) * basis_size(P)];
        Floats of_order[largest_orders][3];
        for (int q = -P; q <= P; ++q) {
            Floats sum[3] = {};
            for (int p = std::abs(q); p <= P; ++p)
                unrolled<3>([&](auto c) {
                    sum[c] += polar[lm(p, std::abs(q))] * load(ring + (lm(p, q) * 3 + size(c)) * size(W));
                });
            unrolled<3>([&](auto c) { of_order[P + q][c] = sum[c]; });
        }
        for (int b = 0; b < views.T; ++b) {
            const float* azimuth = &views.azimuth[size(b * orders)];
            Floats sum[3] = {};
            for (int q = 0; q < orders; ++q)
                unrolled<3>([&](auto c) { sum[c] += azimuth[q] * of_order[q][c]; });
            float* to = pixels + size(a * views.T + b) * stride;
            std::array<float, 3 * lanes> whole;
            float* at = count == lanes ? to : whole.data();
            store_interleaved(at, sum[0], sum[1], sum[2]);
            if (count < lanes) std::copy_n(whole.data(), 3 * count, to);
        }
    }
}

}  // namespace

void explicit_maps(const ReflectionMapView& map, int T, std::span<float> pixels) {
    const GridOfViews views(T, map.P);
    const ShownTexels shown(map);
    const std::size_t planes = size(map.maps()) * 3, width = size(map.W);
    const std::size_t stride = size(shown.rows) * size(shown.columns) * 3;
#pragma omp parallel
    {
        std::vector<float> last(planes * lanes);  // the last texels of a row, that do not fill a vector
#pragma omp for schedule(static)
        for (int i = 0; i < shown.rows; ++i) {
            const float* ring = &map.rings[size(shown.row(i)) * planes * width] + shown.border;
            float* to = &pixels[size(i * shown.columns) * 3];
            int j = 0;
            for (; j + lanes <= shown.columns; j += lanes)
                texels_at_views(views, ring + j, map.W, lanes, to + 3 * j, stride);
            if (j == shown.columns) continue;
            const int count = shown.columns - j;
            for (std::size_t z = 0; z < planes; ++z)
                std::copy_n(ring + z * width + j, count, &last[z * lanes]);
            texels_at_views(views, last.data(), lanes, count, to + 3 * j, stride);
        }
    }
}

}  // namespace shrm
