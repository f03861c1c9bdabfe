// Pairs of directions eight at a time. For .cpp files only, as vectors.hpp.
#pragma once

#include <algorithm>

#include "shrm/brdf/direction_pairs.hpp"
#include "shrm/simd/packs.hpp"

namespace shrm {

inline constexpr std::size_t pair_lanes = 8;

// Vectors first to first + 7; those past the end repeat the last.
SHRM_INLINE d8vec3 load(const StridedVectors& vectors, std::size_t count, std::size_t first) {
    double components[3][pair_lanes];
    for (std::size_t lane = 0; lane < pair_lanes; ++lane) {
        const double* from =
            vectors.first + static_cast<std::ptrdiff_t>(std::min(first + lane, count - 1)) * vectors.row;
        for (int c = 0; c < 3; ++c) components[c][lane] = from[c * vectors.component];
    }
    return {load(components[0]), load(components[1]), load(components[2])};
}

// Calls body(first, lanes) for every eight pairs, the last of them perhaps fewer.
template <class Body>
void each_eight(std::size_t count, const Body& body) {
    const std::ptrdiff_t blocks = static_cast<std::ptrdiff_t>((count + pair_lanes - 1) / pair_lanes);
#pragma omp parallel for schedule(static) if (blocks > 64)
    for (std::ptrdiff_t block = 0; block < blocks; ++block) {
        const std::size_t first = static_cast<std::size_t>(block) * pair_lanes;
        body(first, std::min(pair_lanes, count - first));
    }
}

}  // namespace shrm
