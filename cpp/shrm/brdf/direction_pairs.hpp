// Pairs of directions as numpy holds them, in memory of any strides.
#pragma once

#include <cstddef>

namespace shrm {

// n unit vectors: component c of the k-th at first[k row + c component].
struct StridedVectors {
    const double* first;
    std::ptrdiff_t row, component;
};

// n pairs L, V in the frame of the normal.
struct DirectionPairs {
    StridedVectors wi, wo;
    std::size_t count;
};

}  // namespace shrm
