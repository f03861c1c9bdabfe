#include "shrm/view_map.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

#include "shrm/core.hpp"
#include "shrm/half.hpp"
#include "shrm/layouts.hpp"
#include "shrm/simd.hpp"
#include "shrm/view_harmonics.hpp"

namespace shrm {
namespace {

glm::dvec3 texel_direction(const ReflectionMapView& map, int row, int column) {
    if (map.layout == MapLayout::latlong)
        return LatLong(map.H, map.W, 0).ray(column + 0.5, row + 0.5).direction;
    const int N = map.W - 2 * cube_border;
    const auto centred = [N](int i) { return (2 * (i - cube_border) + 1.0) / N - 1; };
    return glm::normalize(cube_direction(row / map.W, centred(column), centred(row % map.W)));
}

// Y_pq(V), one for each map; or, if zonal, Y_p0(C.V), one for each map and texel of a row.
struct Weights {
    const float* values;
    std::ptrdiff_t stride;  // from map to map if zonal
};

// How far ahead of the sums a ring is fetched: texels that are left out at a cube's edges break the steps by
// which a processor would foresee what comes.
constexpr int prefetched_bytes = 4096;

// V vectors of texels: the sum over the maps of weight times map. The maps of a ring lie one after the other,
// so that they are streamed once.
template <int V, bool Zonal, class Stored>
SHRM_KERNEL inline void view_texels(const Stored* ring, int W, int maps, Weights weights, float* pixels) {
    Floats sums[3][V] = {};
    for (int z = 0; z < maps; ++z) {
        const auto* ahead =
            reinterpret_cast<const char*>(ring + std::ptrdiff_t(z) * 3 * W) + prefetched_bytes;
        for (int line = 0; line < 3 * V * lanes * int(sizeof(Stored)) / 64; ++line)
            __builtin_prefetch(ahead + 64 * line);
        unrolled<V>([&](auto v) {
            Floats w;
            if constexpr (Zonal)
                w = load(weights.values + z * weights.stride + v * lanes);
            else
                w = Floats{} + weights.values[z];
            unrolled<3>(
                [&](auto c) { sums[c][v] += w * load(ring + (std::ptrdiff_t(z) * 3 + c) * W + v * lanes); });
        });
    }
    unrolled<V>([&](auto v) {
        float* to = pixels + 3 * v * lanes;
        store(to, interleaved<0>(sums[0][v], sums[1][v], sums[2][v]));
        store(to + lanes, interleaved<1>(sums[0][v], sums[1][v], sums[2][v]));
        store(to + 2 * lanes, interleaved<2>(sums[0][v], sums[1][v], sums[2][v]));
    });
}

// One row of the sum over the maps [RH02] eq. 12: a product of functions of C and of V as in eq. 4.
template <bool Zonal, class Stored>
void view_row(const Stored* ring, int W, int maps, int columns, Weights weights, float* pixels) {
    int j = 0;
    const auto from = [&] { return Weights{weights.values + (Zonal ? j : 0), weights.stride}; };
    for (; j + 4 * lanes <= columns; j += 4 * lanes)
        view_texels<4, Zonal>(ring + j, W, maps, from(), pixels + 3 * j);
    for (; j + lanes <= columns; j += lanes) view_texels<1, Zonal>(ring + j, W, maps, from(), pixels + 3 * j);
    for (; j < columns; ++j)
        for (int c = 0; c < 3; ++c) {
            float sum = 0;
            for (int z = 0; z < maps; ++z)
                sum += weights.values[Zonal ? z * weights.stride + j : z] *
                       float_from(ring[(std::ptrdiff_t(z) * 3 + c) * W + j]);
            pixels[3 * j + c] = sum;
        }
}

template <class Stored>
void view_map(const ReflectionMapView& map, std::span<const Stored> rings, const glm::dvec3& view,
              std::span<float> pixels) {
    const ShownTexels shown(map);
    const std::size_t ring = size(map.maps()) * 3 * size(map.W);
    double Y[basis_size(largest_P)];
    float of_view[basis_size(largest_P)];
    real_harmonics(map.P, view, Y);
    for (std::size_t z = 0; z < basis_size(map.P); ++z) of_view[z] = static_cast<float>(Y[z]);
    const bool by_texel = map.zonal && map.P > 0;  // Y_00 is the same for all
#pragma omp parallel
    {
        std::vector<float> of_texels(by_texel ? size(map.maps()) * size(shown.columns) : 0);
#pragma omp for schedule(static)
        for (int i = 0; i < shown.rows; ++i) {
            const int row = shown.row(i);
            const Stored* from = &rings[size(row) * ring] + shown.border;
            float* to = &pixels[size(i) * size(shown.columns) * 3];
            if (!by_texel) {
                view_row<false>(from, map.W, map.maps(), shown.columns, {of_view, 0}, to);
                continue;
            }
            for (int j = 0; j < shown.columns; ++j) {
                double zonal[largest_P + 1];
                zonal_harmonics(map.P, glm::dot(texel_direction(map, row, j + shown.border), view), zonal);
                for (int p = 0; p <= map.P; ++p)
                    of_texels[size(p * shown.columns + j)] = static_cast<float>(zonal[p]);
            }
            view_row<true>(from, map.W, map.maps(), shown.columns, {of_texels.data(), shown.columns}, to);
        }
    }
}

}  // namespace

void view_map(const ReflectionMapView& map, const glm::dvec3& view, std::span<float> pixels) {
    if (map.halves.empty())
        view_map(map, map.rings, view, pixels);
    else
        view_map(map, map.halves, view, pixels);
}

void to_half(std::span<const float> rings, std::span<std::uint16_t> halves) {
    const auto n = static_cast<std::ptrdiff_t>(rings.size()), whole = n / lanes * lanes;
#pragma omp parallel for schedule(static)
    for (std::ptrdiff_t i = 0; i < whole; i += lanes)
        store(&halves[std::size_t(i)], load(&rings[std::size_t(i)]));
    for (std::ptrdiff_t i = whole; i < n; ++i) halves[std::size_t(i)] = half_from(rings[std::size_t(i)]);
}

float largest_magnitude(std::span<const float> rings) {
    const auto n = static_cast<std::ptrdiff_t>(rings.size()), whole = n / lanes * lanes;
    float largest = 0;
#pragma omp parallel reduction(max : largest)
    {
        Floats most = {};
#pragma omp for schedule(static)
        for (std::ptrdiff_t i = 0; i < whole; i += lanes) {
            const Floats v = load(&rings[std::size_t(i)]), magnitude = v < 0 ? -v : v;
            most = magnitude > most ? magnitude : most;  // NaN never is
        }
        for (int i = 0; i < lanes; ++i) largest = std::max(largest, most[i]);
    }
    for (std::ptrdiff_t i = whole; i < n; ++i) largest = std::max(largest, std::abs(rings[std::size_t(i)]));
    return largest;
}

}  // namespace shrm
