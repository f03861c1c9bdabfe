#include "shrm/reflection/view_map.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

#include "shrm/core.hpp"
#include "shrm/pictures/layouts.hpp"
#include "shrm/sh/view_harmonics.hpp"
#include "shrm/simd/half.hpp"
#include "shrm/simd/shuffles.hpp"
#include "shrm/simd/vectors.hpp"

namespace shrm {
namespace {

glm::dvec3 texel_direction(const ReflectionMapView& map, int row, int column) {
    if (map.layout == MapLayout::latlong)
        return LatLong(map.H, map.W, 0).ray(column + 0.5, row + 0.5).direction;
    return cube_texel_direction(map.W - 2 * cube_border, row, column);
}

// Y_pq(V), one for each map; or, if zonal, Y_p0(C.V), one for each map and texel of a row.
struct Weights {
    const float* values;
    std::ptrdiff_t stride;  // from map to map if zonal
};

// The sum of weight times map over the maps, for a vector of texels.
#if defined(__AVX512F__)
// Two vectors of eight stand for one of sixteen: where memory is the limit they are no slower, and maps need
// not begin where lines of the cache do, nor sixteen halves be converted at once, which costs some processors
// (Zen 4) a third more.
class Sum {
    __m256 low_ = _mm256_setzero_ps(), high_ = _mm256_setzero_ps();

    static __m256 eight(const float* from) { return _mm256_loadu_ps(from); }
    static __m256 eight(const Half* from) {
        return _mm256_cvtph_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from)));
    }

  public:
    struct Weight {
        __m256 low, high;
    };
    static Weight weight(float of_all) { return {_mm256_set1_ps(of_all), _mm256_set1_ps(of_all)}; }
    static Weight weights(const float* of_each) { return {eight(of_each), eight(of_each + 8)}; }

    template <class Stored>
    void add(const Weight& w, const Stored* map) {
        low_ = _mm256_fmadd_ps(w.low, eight(map), low_);
        high_ = _mm256_fmadd_ps(w.high, eight(map + 8), high_);
    }
    Floats value() const { return Floats(_mm512_insertf32x8(_mm512_castps256_ps512(low_), high_, 1)); }
};
#else
class Sum {
    Floats total_ = {};

  public:
    using Weight = Floats;
    static Weight weight(float of_all) { return Floats{} + of_all; }
    static Weight weights(const float* of_each) { return load(of_each); }

    template <class Stored>
    void add(const Weight& w, const Stored* map) {
        total_ += w * load(map);
    }
    Floats value() const { return total_; }
};
#endif

// V vectors of texels. The maps of a ring lie one after the other, so that they are streamed once, in the
// order of memory.
template <int V, bool Zonal, class Stored>
SHRM_KERNEL inline void view_texels(const Stored* ring, int pitch, int maps, Weights weights, float* pixels) {
    Sum sums[3][V];
    for (int z = 0; z < maps; ++z) {
        Sum::Weight w[V];
        unrolled<V>([&](auto v) {
            if constexpr (Zonal)
                w[v] = Sum::weights(weights.values + z * weights.stride + v * lanes);
            else
                w[v] = Sum::weight(weights.values[z]);
        });
        unrolled<3>([&](auto c) {
            const Stored* map = ring + (std::ptrdiff_t(z) * 3 + c) * pitch;
            unrolled<V>([&](auto v) { sums[c][v].add(w[v], map + v * lanes); });
        });
    }
    unrolled<V>([&](auto v) {
        float* to = pixels + 3 * v * lanes;
        const Floats r = sums[0][v].value(), g = sums[1][v].value(), b = sums[2][v].value();
        store_interleaved(to, r, g, b);
    });
}

// One row of the sum over the maps [RH02] eq. 12: a product of functions of C and of V as in eq. 4.
template <bool Zonal, class Stored>
void view_row(const Stored* ring, int pitch, int maps, int columns, Weights weights, float* pixels) {
    int j = 0;
    const auto from = [&](int column) {
        return Weights{weights.values + (Zonal ? column : 0), weights.stride};
    };
    for (; j + 4 * lanes <= columns; j += 4 * lanes)
        view_texels<4, Zonal>(ring + j, pitch, maps, from(j), pixels + 3 * j);
    for (; j + lanes <= columns; j += lanes)
        view_texels<1, Zonal>(ring + j, pitch, maps, from(j), pixels + 3 * j);
    if (j < columns && columns >= lanes) {  // the last texels once more, with some before them
        j = columns - lanes;
        view_texels<1, Zonal>(ring + j, pitch, maps, from(j), pixels + 3 * j);
        return;
    }
    for (; j < columns; ++j)
        for (int c = 0; c < 3; ++c) {
            float sum = 0;
            for (int z = 0; z < maps; ++z)
                sum += weights.values[Zonal ? z * weights.stride + j : z] *
                       float_from(ring[(std::ptrdiff_t(z) * 3 + c) * pitch + j]);
            pixels[3 * j + c] = sum;
        }
}

template <class Stored>
void view_map(const ReflectionMapView& map, std::span<const Stored> rings, const glm::dvec3& view,
              std::span<float> pixels) {
    const ShownTexels shown(map);
    const std::size_t ring = size(map.maps()) * 3 * size(map.pitch);
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
                view_row<false>(from, map.pitch, map.maps(), shown.columns, {of_view, 0}, to);
                continue;
            }
            for (int j = 0; j < shown.columns; ++j) {
                double zonal[largest_P + 1];
                zonal_harmonics(map.P, glm::dot(texel_direction(map, row, j + shown.border), view), zonal);
                for (int p = 0; p <= map.P; ++p)
                    of_texels[size(p * shown.columns + j)] = static_cast<float>(zonal[p]);
            }
            view_row<true>(from, map.pitch, map.maps(), shown.columns, {of_texels.data(), shown.columns}, to);
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

void to_half(std::span<const float> rings, int W, std::uint16_t* halves, int pitch) {
    const auto rows = static_cast<std::ptrdiff_t>(rings.size()) / W;
    const int whole = W / lanes * lanes;
#pragma omp parallel for schedule(static)
    for (std::ptrdiff_t row = 0; row < rows; ++row) {
        const float* from = &rings[std::size_t(row * W)];
        std::uint16_t* to = halves + row * pitch;
        for (int j = 0; j < whole; j += lanes) store(to + j, load(from + j));
        for (int j = whole; j < W; ++j) to[j] = half_from(from[j]);
    }
}

float largest_magnitude(std::span<const float> rings) {
    const auto n = static_cast<std::ptrdiff_t>(rings.size()), whole = n / lanes * lanes;
    float largest = 0;
#pragma omp parallel reduction(max : largest)
    {
        Floats most = {};
#pragma omp for schedule(static)
        for (std::ptrdiff_t i = 0; i < whole; i += lanes) {
            most = larger(magnitude(load(&rings[std::size_t(i)])), most);  // NaN never is
        }
        for (int i = 0; i < lanes; ++i) largest = std::max(largest, most[i]);
    }
    for (std::ptrdiff_t i = whole; i < n; ++i) largest = std::max(largest, std::abs(rings[std::size_t(i)]));
    return largest;
}

}  // namespace shrm
