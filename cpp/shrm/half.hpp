// IEEE half floats, read only: 11 bits, 6e-8 to 65504. A map of halves takes half the memory, and half the
// time where memory is the limit.
#pragma once

#include <bit>
#include <cstdint>

#if defined(__F16C__)
#include <immintrin.h>
#endif

#include "shrm/simd.hpp"

namespace shrm {

using Half = std::uint16_t;

inline float float_from(Half h) {
    const std::uint32_t magnitude = h & 0x7fffu, sign = std::uint32_t(h & 0x8000u) << 16;
    // The exponent's bias goes from 15 to 127 by a product, which makes subnormal numbers right too.
    const float value = std::bit_cast<float>(magnitude << 13) * 0x1p112f;
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(value) | sign);
}

inline float float_from(float value) {
    return value;
}

inline Floats load(const Half* from) {
#if defined(__AVX512F__)
    return Floats(_mm512_cvtph_ps(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(from))));
#elif defined(__F16C__)
    return Floats(_mm256_cvtph_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from))));
#else
    Floats v;
    for (int i = 0; i < lanes; ++i) v[i] = float_from(from[i]);
    return v;
#endif
}

}  // namespace shrm
