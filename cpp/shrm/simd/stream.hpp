// Stores that go past the caches. What is larger than the caches would push all else out of them, and every
// line of it would be read from memory before it is written. For .cpp files only, as vectors.hpp.
#pragma once

#include <algorithm>
#include <cstdint>

#if defined(__SSE__)
#include <immintrin.h>
#endif

#include "shrm/simd/vectors.hpp"

namespace shrm {

// Results from this size on go past the caches: beyond what one core can count on of the last level.
inline constexpr std::size_t streamed_from = std::size_t{8} << 20;  // bytes

// Copies n values to any place; what other threads are to see needs end_of_stream() first.
inline void stream(const float* from, int n, float* to) {
#if defined(__SSE__)
    const auto beyond = reinterpret_cast<std::uintptr_t>(to) / sizeof(float) % lanes;
    int i = std::min(n, static_cast<int>((lanes - beyond) % lanes));
    std::copy_n(from, i, to);
    for (; i + lanes <= n; i += lanes)
#if defined(__AVX512F__)
        _mm512_stream_ps(to + i, _mm512_loadu_ps(from + i));
#elif defined(__AVX__)
        _mm256_stream_ps(to + i, _mm256_loadu_ps(from + i));
#else
        _mm_stream_ps(to + i, _mm_loadu_ps(from + i));
#endif
    std::copy_n(from + i, n - i, to + i);
#else
    std::copy_n(from, n, to);
#endif
}

inline void end_of_stream() {
#if defined(__SSE__)
    _mm_sfence();
#endif
}

}  // namespace shrm
