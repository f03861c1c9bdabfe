// Packs of a fixed number of lanes, whatever the instruction set: eight numbers, or four floats. For .cpp
// files only, as vectors.hpp.
#pragma once

#include <cmath>

#include "shrm/simd/vectors.hpp"

namespace shrm {

typedef double d8 __attribute__((vector_size(8 * sizeof(double))));
typedef float f8 __attribute__((vector_size(8 * sizeof(float))));
typedef int i8 __attribute__((vector_size(8 * sizeof(int))));
typedef float f4 __attribute__((vector_size(4 * sizeof(float))));
typedef double UnalignedD8 __attribute__((vector_size(8 * sizeof(double)), aligned(sizeof(double))));
typedef float UnalignedF4 __attribute__((vector_size(4 * sizeof(float)), aligned(sizeof(float))));

struct d8vec3 {
    d8 x, y, z;
};

SHRM_INLINE d8 load(const double* from) {
    return *reinterpret_cast<const UnalignedD8*>(from);
}

SHRM_INLINE f4 load_four(const float* from) {
    return *reinterpret_cast<const UnalignedF4*>(from);
}

// The first `count` lanes, and zeros.
SHRM_INLINE d8 load_first(const double* from, int count) {
    if (count >= 8) return load(from);
    d8 v{};
    for (int i = 0; i < count; ++i) v[i] = from[i];
    return v;
}

SHRM_INLINE void store(double* to, d8 v) {
    *reinterpret_cast<UnalignedD8*>(to) = v;
}

SHRM_INLINE void store_first(double* to, d8 v, int count) {
    if (count >= 8) return store(to, v);
    for (int i = 0; i < count; ++i) to[i] = v[i];
}

SHRM_INLINE d8 square_root(d8 v) {
    double values[8];
    store(values, v);
    for (double& value : values) value = std::sqrt(value);
    return load(values);
}

SHRM_INLINE d8 dot(const d8vec3& a, const d8vec3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

SHRM_INLINE d8 length(d8 x, d8 y) {
    return square_root(x * x + y * y);
}

}  // namespace shrm
