// Lanes that change places, within vectors and between them. For .cpp files only, as vectors.hpp.
#pragma once

#include <algorithm>
#include <utility>

#include "shrm/simd/vectors.hpp"

namespace shrm {

// Lane i of the result is lane index(i) of a followed by b.
template <auto index>
SHRM_INLINE Floats shuffled(Floats a, Floats b) {
    return [&]<int... i>(std::integer_sequence<int, i...>) {
#if defined(__clang__)
        return __builtin_shufflevector(a, b, index(i)...);
#else
        return __builtin_shuffle(a, b, Ints{index(i)...});
#endif
    }(std::make_integer_sequence<int, lanes>());
}

SHRM_INLINE Floats reversed(Floats v) {
    return shuffled<[](int i) { return lanes - 1 - i; }>(v, v);
}

// The lanes of one channel, where three channels are interleaved in three vectors and each lane holds a
// channel in one of them alone: the second vector's lanes where that is vector V, the first one's elsewhere.
template <int V, int channel>
struct WithChannel {
    static_assert(lanes % 3 != 0);
    constexpr int operator()(int i) const { return i + ((V * lanes + i) % 3 == channel ? lanes : 0); }
};

// The lane of texel i of a channel, in whichever vector; backwards, that of texel i from the last.
template <int channel, bool backwards>
struct LaneOfThree {
    constexpr int operator()(int i) const { return (3 * (backwards ? lanes - 1 - i : i) + channel) % lanes; }
};

// Channel C of `lanes` texels of three channels, interleaved in three vectors; the last texel first if
// backwards.
template <int C, bool backwards = false>
SHRM_INLINE Floats channel_of_three(Floats a, Floats b, Floats c) {
    const Floats ab = shuffled<WithChannel<1, C>{}>(a, b), abc = shuffled<WithChannel<2, C>{}>(ab, c);
    return shuffled<LaneOfThree<C, backwards>{}>(abc, abc);
}

// Channels of the sum (0 to 2) and of the difference (3 to 5) of `lanes` texels of two rows, interleaved; the
// last texel first if backwards.
template <bool backwards>
SHRM_INLINE void sum_and_difference(const float* north, const float* south, Floats (&channels)[6]) {
    Floats s[3], d[3];
    unrolled<3>([&](auto v) {
        const Floats n = load(north + v * lanes), m = load(south + v * lanes);
        s[v] = n + m;
        d[v] = n - m;
    });
    unrolled<3>([&](auto c) {
        channels[c] = channel_of_three<c, backwards>(s[0], s[1], s[2]);
        channels[3 + c] = channel_of_three<c, backwards>(d[0], d[1], d[2]);
    });
}

// Every texel of one channel to the lane where it stands in whichever of the three vectors holds it there.
template <int channel>
struct SpreadOfThree {
    constexpr int operator()(int i) const {
        int value = i;
        while (value % 3 != channel) value += lanes;
        return value / 3;
    }
};

// Stores `lanes` texels whose three channels a, b and c are: the inverse of channel_of_three.
SHRM_INLINE void store_interleaved(float* to, Floats a, Floats b, Floats c) {
    a = shuffled<SpreadOfThree<0>{}>(a, a);
    b = shuffled<SpreadOfThree<1>{}>(b, b);
    c = shuffled<SpreadOfThree<2>{}>(c, c);
    unrolled<3>([&](auto v) {
        const Floats ab = shuffled<WithChannel<v, 1>{}>(a, b);
        store(to + v * lanes, shuffled<WithChannel<v, 2>{}>(ab, c));
    });
}

// The first (0) or the second (1) of each two blocks of `apart` lanes; odd blocks of the result are from the
// second vector.
template <int apart, int which>
struct EveryOther {
    constexpr int operator()(int i) const {
        return i / apart % 2 * lanes + i / (2 * apart) * (2 * apart) + i % apart + which * apart;
    }
};

template <int N, int apart>
SHRM_INLINE void add_lanes(Floats (&v)[N]) {
    if constexpr (apart < lanes) {
        constexpr int left = std::max(N / apart, 1);  // vectors that still hold sums
        unrolled<std::max(left / 2, 1)>([&](auto pair) {
            Floats& first = v[2 * apart * pair];
            const Floats second = v[left > 1 ? 2 * apart * pair + apart : 0];
            first = shuffled<EveryOther<apart, 0>{}>(first, second) +
                    shuffled<EveryOther<apart, 1>{}>(first, second);
        });
        add_lanes<N, 2 * apart>(v);
    }
}

// Lane k of the result is the sum of all lanes of v[k], k < N, a power of two, at most `lanes`. Each step
// adds pairs of blocks of lanes, and puts the blocks of two vectors side by side in one. v is overwritten.
template <int N>
SHRM_INLINE Floats sums_of(Floats (&v)[N]) {
    static_assert((N & (N - 1)) == 0 && N <= lanes);
    add_lanes<N, 1>(v);
    return v[0];
}

// Blocks of `apart` lanes of the upper (0) or lower (1) row of two, after the two off the diagonal have
// changed places.
template <int apart, int row>
struct Exchanged {
    constexpr int operator()(int i) const {
        return i / apart % 2 == 0 ? i + row * apart : lanes + i - (1 - row) * apart;
    }
};

// Exchanges rows and columns of a square.
template <int apart = 1>
SHRM_INLINE void transpose(Floats (&v)[lanes]) {
    if constexpr (apart < lanes) {
        unrolled<lanes / 2>([&](auto k) {
            constexpr int row = k / apart * 2 * apart + k % apart;
            const Floats upper = shuffled<Exchanged<apart, 0>{}>(v[row], v[row + apart]);
            v[row + apart] = shuffled<Exchanged<apart, 1>{}>(v[row], v[row + apart]);
            v[row] = upper;
        });
        transpose<2 * apart>(v);
    }
}

}  // namespace shrm
