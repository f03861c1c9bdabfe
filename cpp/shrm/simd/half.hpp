// IEEE half floats: a sign, 5 bits of exponent, 10 of fraction. They keep 11 bits of a number between 6.1e-5
// and 65504, and fewer down to 6e-8. A map of halves takes half the memory, and half the time where memory is
// the limit. For .cpp files only, as vectors.hpp.
#pragma once

#include <bit>
#include <cstdint>

#if defined(__F16C__)
#include <immintrin.h>
#endif

#include "shrm/simd/vectors.hpp"

namespace shrm {

using Half = std::uint16_t;

inline float float_from(Half h) {
    const std::uint32_t magnitude = h & 0x7fffu, sign = std::uint32_t(h & 0x8000u) << 16;
    // The exponent's bias goes from 15 to 127 by a product, which makes subnormal numbers right too; the
    // exponent of infinity and NaN goes on to all ones.
    const float value = std::bit_cast<float>(magnitude << 13) * 0x1p112f;
    const std::uint32_t beyond = magnitude >= 0x7c00u ? 0x7f800000u : 0u;
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(value) | beyond | sign);
}

inline float float_from(float value) {
    return value;
}

// Rounds to the nearest half, ties to even; from 65520 on to infinity, and NaN stays NaN, as in the
// processor's own conversion.
inline Half half_from(float value) {
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(value), sign = bits >> 16 & 0x8000u;
    const std::uint32_t magnitude_bits = bits & 0x7fffffffu;
    const float magnitude = std::bit_cast<float>(magnitude_bits);
    if (!(magnitude < 65520.f)) return static_cast<Half>(sign | (magnitude > 0 ? 0x7c00u : 0x7e00u));
    if (magnitude < 0x1p-14f) {
        // Subnormal: one half's last bit, 2^-24, is that of 1/2 as a float, so that the sum rounds there.
        const std::uint32_t sum = std::bit_cast<std::uint32_t>(magnitude + 0.5f);
        return static_cast<Half>(sign | (sum - std::bit_cast<std::uint32_t>(0.5f)));
    }
    // 13 bits go. Adding half of the last bit kept, less one if that bit is 0, rounds to the nearest, ties to
    // even. The exponent's bias goes from 127 to 15.
    const std::uint32_t carry = 0xfffu + (magnitude_bits >> 13 & 1u);
    return static_cast<Half>(sign | ((magnitude_bits - (112u << 23) + carry) >> 13));
}

// Masked by all lanes: g++ 12 warns of the plain conversions' undefined source.
inline Floats load(const Half* from) {
#if defined(__AVX512F__)
    return Floats(_mm512_maskz_cvtph_ps(0xffff, _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from))));
#elif defined(__F16C__)
    return Floats(_mm256_cvtph_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from))));
#else
    Floats v;
    for (int i = 0; i < lanes; ++i) v[i] = float_from(from[i]);
    return v;
#endif
}

inline Floats load_first(const Half* from, int count) {
#if defined(__AVX512BW__) && defined(__AVX512VL__)
    const auto these = static_cast<__mmask16>((1u << count) - 1);
    return Floats(_mm512_maskz_cvtph_ps(0xffff, _mm256_maskz_loadu_epi16(these, from)));
#else
    Floats v{};
    for (int i = 0; i < count; ++i) v[i] = float_from(from[i]);
    return v;
#endif
}

inline void store(Half* to, Floats v) {
#if defined(__AVX512F__)
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm512_maskz_cvtps_ph(0xffff, __m512(v), 0));
#elif defined(__F16C__)
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to), _mm256_cvtps_ph(__m256(v), 0));
#else
    for (int i = 0; i < lanes; ++i) to[i] = half_from(v[i]);
#endif
}

}  // namespace shrm
