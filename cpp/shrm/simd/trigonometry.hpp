// Functions of eight angles at once. For .cpp files only, as vectors.hpp.
#pragma once

#include "shrm/core.hpp"
#include "shrm/simd/packs.hpp"

namespace shrm {

// cos and sin of angles in [0, pi], to a few units of the last digit: Taylor's series at a quarter of the
// angle, doubled twice.
SHRM_INLINE void cosine_and_sine(d8 angle, d8& cosine, d8& sine) {
    const d8 x = 0.25 * angle, y = x * x;
    d8 c = 1 + d8{}, s = c;  // of the series to x^17, by Horner's rule
#pragma GCC unroll 8
    for (int n = 16; n > 0; n -= 2) {
        c = 1 - 1.0 / (n * (n - 1)) * y * c;
        s = 1 - 1.0 / (n * (n + 1)) * y * s;
    }
    s *= x;
    for (int doubling = 0; doubling < 2; ++doubling) {
        const d8 twice = 2 * s * c;
        c = 1 - 2 * s * s;
        s = twice;
    }
    cosine = c;
    sine = s;
}

// atan2(y, x) in [-pi, pi], to 1e-12; 0 at the origin.
SHRM_INLINE d8 arc_tangent(d8 y, d8 x) {
    const d8 zero{}, a = y < 0 ? -y : y, b = x < 0 ? -x : x;
    const d8 longer = a > b ? a : b, shorter = a > b ? b : a;
    const d8 t = longer > 0 ? shorter / longer : zero;  // at most 1, and its half angle's tangent sqrt2 - 1
    const d8 half = t / (1 + square_root(1 + t * t)), square = half * half;
    d8 series = zero;
#pragma GCC unroll 15
    for (int n = 29; n > 0; n -= 2) series = 1.0 / n - square * series;
    d8 angle = 2 * half * series;
    angle = a > b ? pi / 2 - angle : angle;
    angle = x < 0 ? pi - angle : angle;
    return y < 0 ? -angle : angle;
}

}  // namespace shrm
