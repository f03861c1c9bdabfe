// Vectors of the instruction set that a file is compiled for, and what is done in each of their lanes. For
// .cpp files only: what bindings include must be the same for every instruction set.
#pragma once

#include <cmath>
#include <type_traits>
#include <utility>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

// Becomes part of its callers: sums stay in registers, and vectors are passed in them.
#define SHRM_INLINE inline __attribute__((always_inline))
// For the innermost functions: all they call, lambdas too, becomes part of them.
#define SHRM_KERNEL __attribute__((flatten))

namespace shrm {

#if defined(__AVX512F__)
inline constexpr int lanes = 16;
inline constexpr int vector_registers = 32;
#elif defined(__AVX2__)
inline constexpr int lanes = 8;
inline constexpr int vector_registers = 16;
#else
inline constexpr int lanes = 4;
inline constexpr int vector_registers = 16;
#endif

typedef float Floats __attribute__((vector_size(lanes * sizeof(float))));
typedef float UnalignedFloats __attribute__((vector_size(lanes * sizeof(float)), aligned(sizeof(float))));
typedef int Ints __attribute__((vector_size(lanes * sizeof(int))));  // and masks: all bits of a lane, or none

inline constexpr int double_lanes = lanes / 2;
typedef double Doubles __attribute__((vector_size(double_lanes * sizeof(double))));

// ---- To and from memory

SHRM_INLINE Floats load(const float* from) {
    return *reinterpret_cast<const UnalignedFloats*>(from);
}

// The first `count` lanes, and zeros.
SHRM_INLINE Floats load_first(const float* from, int count) {
#if defined(__AVX512F__)
    return Floats(_mm512_maskz_loadu_ps(static_cast<__mmask16>((1u << count) - 1), from));
#else
    Floats v{};
    for (int i = 0; i < count; ++i) v[i] = from[i];
    return v;
#endif
}

SHRM_INLINE void store(float* to, Floats v) {
    *reinterpret_cast<UnalignedFloats*>(to) = v;
}

// Lane i is table[at[i]].
SHRM_INLINE Floats gather(const float* table, Ints at) {
#if defined(__AVX512F__)
    // masked by all lanes: g++ 12 warns of the plain one's undefined source
    return Floats(_mm512_mask_i32gather_ps(_mm512_setzero_ps(), 0xffff, __m512i(at), table, 4));
#elif defined(__AVX2__)
    return Floats(_mm256_i32gather_ps(table, __m256i(at), 4));
#else
    Floats v;
    for (int i = 0; i < lanes; ++i) v[i] = table[at[i]];
    return v;
#endif
}

// ---- Registers

// Calls body(0), body(1), ..., body(N - 1) with constants, so that arrays of sums stay in registers.
template <int N, class Body>
inline void unrolled(Body&& body) {
    [&]<int... i>(std::integer_sequence<int, i...>) {
        (body(std::integral_constant<int, i>()), ...);
    }(std::make_integer_sequence<int, N>());
}

// Keeps a value that several products share in a register: the compiler would load or compute it anew for
// each, and that, not the products, would be the limit.
SHRM_INLINE void keep(Floats& v) {
#if defined(__AVX512F__)
    asm("" : "+v"(v));
#elif defined(__x86_64__)
    asm("" : "+x"(v));
#else
    (void)v;
#endif
}

SHRM_INLINE Floats load_once(const float* from) {
    Floats v = load(from);
    keep(v);
    return v;
}

// A value in all lanes, hidden from the compiler, which would otherwise compute once what the lanes share.
SHRM_INLINE Floats splat(float value) {
    Floats v = Floats{} + value;
    keep(v);
    return v;
}

// ---- Functions of each lane

// 1 / sqrt(v) to 3e-7, for v > 0 that is not subnormal.
SHRM_INLINE Floats inverse_root(Floats v) {
#if defined(__AVX512F__)
    // 14 bits, then a step of Newton's: less than a third of the time of a root and a division
    const Floats r = Floats(_mm512_maskz_rsqrt14_ps(0xffff, __m512(v)));  // masked as above
    return r * (1.5f - 0.5f * v * r * r);
#else
    Floats r;
    for (int i = 0; i < lanes; ++i) r[i] = 1.0f / std::sqrt(v[i]);
    return r;
#endif
}

// sqrt(v) to 3e-7, for v >= 0.
SHRM_INLINE Floats root(Floats v) {
    return v * inverse_root(v > 1e-30f ? v : Floats{} + 1e-30f);
}

// sqrt(v), rounded as the processor does.
SHRM_INLINE Floats square_root(Floats v) {
    for (int i = 0; i < lanes; ++i) v[i] = std::sqrt(v[i]);
    return v;
}

SHRM_INLINE Floats magnitude(Floats v) {
    return Floats(Ints(v) & 0x7fffffff);
}

// a < b ? a : b: of NaN and b it is b.
SHRM_INLINE Floats smaller(Floats a, Floats b) {
    return a < b ? a : b;
}

SHRM_INLINE Floats larger(Floats a, Floats b) {
    return a > b ? a : b;
}

// From a at 0 to b at 1.
SHRM_INLINE Floats mixed(Floats a, Floats b, Floats t) {
    return a + t * (b - a);
}

// Towards zero.
SHRM_INLINE Ints truncated(Floats v) {
    return __builtin_convertvector(v, Ints);
}

SHRM_INLINE Floats floats_of(Ints v) {
    return __builtin_convertvector(v, Floats);
}

// ---- Masks

// v where the mask is set, else 0.
SHRM_INLINE Floats only(Ints mask, Floats v) {
    return Floats(Ints(v) & mask);
}

// The first n lanes.
SHRM_INLINE Ints first_lanes(int n) {
    Ints lane = {};
    for (int i = 0; i < lanes; ++i) lane[i] = i;
    return lane < n;
}

SHRM_INLINE bool any(Ints mask) {
#if defined(__AVX512F__)
    return _mm512_test_epi32_mask(__m512i(mask), __m512i(mask)) != 0;
#elif defined(__AVX2__)
    return _mm256_testz_si256(__m256i(mask), __m256i(mask)) == 0;
#else
    int bits = 0;
    for (int i = 0; i < lanes; ++i) bits |= mask[i];
    return bits != 0;
#endif
}

}  // namespace shrm
