// Lanes of the instruction set that the core is built for, and sums in them. Private to angular.
#pragma once

#include <cmath>
#include <cstring>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

#include "shrm/angular/angular.hpp"

#define SHRM_INLINE inline __attribute__((always_inline))

namespace shrm::angular {

#if defined(__AVX512F__)
inline constexpr int width = 16;
#elif defined(__AVX2__)
inline constexpr int width = 8;
#else
inline constexpr int width = 4;
#endif
static_assert(lanes % width == 0);

typedef float Lanes __attribute__((vector_size(width * sizeof(float))));
typedef int Ints __attribute__((vector_size(width * sizeof(int))));

SHRM_INLINE Lanes load(const float* p) {
    Lanes v;
    std::memcpy(&v, p, sizeof v);
    return v;
}

SHRM_INLINE void store(float* p, const Lanes& v) {
    std::memcpy(p, &v, sizeof v);
}

// A load that several products share, kept in a register: the compiler would repeat it for each of them.
SHRM_INLINE Lanes load_once(const float* p) {
    Lanes v = load(p);
#if defined(__x86_64__)
    asm("" : "+v"(v));
#endif
    return v;
}

// A value in all lanes, hidden from the compiler, which would otherwise compute once what the lanes share.
SHRM_INLINE Lanes splat(float value) {
    Lanes v = Lanes{} + value;
#if defined(__x86_64__)
    asm("" : "+v"(v));
#endif
    return v;
}

// 1 / sqrt(v) to 3e-7, for v > 0 that is not subnormal.
SHRM_INLINE Lanes inverse_root(const Lanes& v) {
#if defined(__AVX512F__)
    // 14 bits, then a step of Newton's: less than a third of the time of a root and a division
    // (masked by all lanes: g++ 12 warns of the plain one's undefined source)
    const Lanes r = reinterpret_cast<Lanes>(_mm512_maskz_rsqrt14_ps(0xffff, reinterpret_cast<__m512>(v)));
    return r * (1.5f - 0.5f * v * r * r);
#else
    Lanes r;
    for (int k = 0; k < width; ++k) r[k] = 1.0f / std::sqrt(v[k]);
    return r;
#endif
}

// sqrt(v) to 3e-7, for v >= 0.
SHRM_INLINE Lanes root(const Lanes& v) {
    return v * inverse_root(v > 1e-30f ? v : Lanes{} + 1e-30f);
}

SHRM_INLINE Lanes absolute(const Lanes& v) {
    return reinterpret_cast<Lanes>(reinterpret_cast<Ints>(v) & 0x7fffffff);
}

// Numbers of at least 0, rounded down.
SHRM_INLINE Ints whole(const Lanes& v) {
    return __builtin_convertvector(v, Ints);
}

SHRM_INLINE Lanes number(const Ints& k) {
    return __builtin_convertvector(k, Lanes);
}

SHRM_INLINE Lanes gather(const float* table, const Ints& at) {
#if defined(__AVX512F__)
    const auto lanes_at = reinterpret_cast<__m512i>(at);
    const __m512 zero = _mm512_setzero_ps();  // masked by all lanes, as above
    return reinterpret_cast<Lanes>(_mm512_mask_i32gather_ps(zero, 0xffff, lanes_at, table, 4));
#elif defined(__AVX2__)
    return reinterpret_cast<Lanes>(_mm256_i32gather_ps(table, reinterpret_cast<__m256i>(at), 4));
#else
    Lanes v;
    for (int k = 0; k < width; ++k) v[k] = table[at[k]];
    return v;
#endif
}

// From a at 0 to b at 1.
SHRM_INLINE Lanes mixed(const Lanes& a, const Lanes& b, const Lanes& t) {
    return a + t * (b - a);
}

// v where the mask is set, else 0.
SHRM_INLINE Lanes only(const Ints& mask, const Lanes& v) {
    return reinterpret_cast<Lanes>(reinterpret_cast<Ints>(v) & mask);
}

// The first n lanes.
SHRM_INLINE Ints below(int n) {
    Ints lane = {};
    for (int k = 0; k < width; ++k) lane[k] = k;
    return lane < n;
}

// Sums of three channels, in double, of parts that were summed in single precision.
struct Sum {
    double total[3][width] = {};

    // Adds a part, and empties it.
    SHRM_INLINE void add(Lanes part[3]) {
        for (int c = 0; c < 3; ++c) {
            float single[width];
            store(single, part[c]);
            for (int k = 0; k < width; ++k) total[c][k] += static_cast<double>(single[k]);
            part[c] = Lanes{};
        }
    }
    SHRM_INLINE void write(float* out) {
        for (int c = 0; c < 3; ++c) {
            for (int half = width / 2; half > 0; half /= 2)
                for (int k = 0; k < half; ++k) total[c][k] += total[c][k + half];
            out[c] = static_cast<float>(total[c][0]);
        }
    }
};

// Terms, but for those of one more row, that one lane may sum in single precision: rounding stays near 1e-6
// even where they all are of one sign.
inline constexpr int terms_in_single = 256;

// sum[c] += sum_j weight(j) light[c][j], n of them, a whole group of lanes at a time.
template <class Weight>
SHRM_INLINE void sum_weighted(const Weight& weight, const float* const light[3], int n, Lanes sum[3]) {
    Lanes s[3] = {sum[0], sum[1], sum[2]};  // in registers, whatever `sum` is
    int j = 0;
    for (; j + width <= n; j += width) {
        const Lanes w = weight(j);
        for (int c = 0; c < 3; ++c) s[c] += w * load(light[c] + j);
    }
    if (j < n) {
        const Lanes w = only(below(n - j), weight(j));
        for (int c = 0; c < 3; ++c) s[c] += w * load(light[c] + j);
    }
    for (int c = 0; c < 3; ++c) sum[c] = s[c];
}

// Adds sum_j weight[c][j] light[c][j], n of them; both are readable in whole groups of lanes.
SHRM_INLINE void accumulate(const float* const weight[3], const float* const light[3], int n, Sum& sum) {
    Lanes single[3] = {};
    int j = 0;
    for (; j + width <= n; j += width)
        for (int c = 0; c < 3; ++c) single[c] += load(weight[c] + j) * load(light[c] + j);
    if (j < n)
        for (int c = 0; c < 3; ++c) single[c] += only(below(n - j), load(weight[c] + j)) * load(light[c] + j);
    sum.add(single);
}

}  // namespace shrm::angular
