// A radial profile evaluated in lanes, and the innermost loop of direct integration: for each texel of an
// arc the angle, the profile and three sums. Private to angular.
#pragma once

#include "angular.hpp"
#include "angular_lanes.hpp"

namespace shrm::angular {

// A profile of few segments keeps its cubics in registers and picks them by permutation: a gather would cost
// several times as much as all the arithmetic. Others look theirs up in memory.
inline constexpr int held_segments = 32;

template <bool held>
struct Cubics {
#if defined(__AVX2__)
    static constexpr bool permutes = held;
#else
    static constexpr bool permutes = false;
#endif
    static constexpr int groups = permutes ? held_segments / width : 1;

    Lanes group[4][groups];
    const float* table;
    int segments, shift;
    int last;  // bits of the last segment of z

    SHRM_INLINE Cubics(const RadialProfile& profile, int channel)
        : table(profile.values.data() + channel * 4 * profile.segments),
          segments(profile.segments),
          shift(profile.shift),
          last(((127 << (23 - profile.shift)) + profile.segments - 1) << profile.shift) {
        if constexpr (permutes)
            for (int power = 0; power < 4; ++power)
                for (int g = 0; g < groups; ++g)
                    group[power][g] = load(table + power * held_segments + g * width);
    }

    SHRM_INLINE Lanes coefficient(int power, const Ints& k) const {
        if constexpr (permutes && groups == 2) return __builtin_shuffle(group[power][0], group[power][1], k);
        if constexpr (permutes && groups == 4) {
            const Lanes low = __builtin_shuffle(group[power][0], group[power][1], k);
            const Lanes high = __builtin_shuffle(group[power][2], group[power][3], k);
            return (k & 16) != 0 ? high : low;
        }
        Lanes c;
        for (int lane = 0; lane < width; ++lane) c[lane] = table[power * segments + (k[lane] & (segments - 1))];
        return c;
    }

    SHRM_INLINE Lanes cubic(const Lanes& z, const Ints& k) const {
        return ((coefficient(3, k) * z + coefficient(2, k)) * z + coefficient(1, k)) * z + coefficient(0, k);
    }

    // u at z = 1 + scale sin^2(theta/2), within the support.
    SHRM_INLINE Lanes operator()(const Lanes& z) const { return cubic(z, reinterpret_cast<Ints>(z) >> shift); }

    // The same anywhere: the last segment is 0. Positive floats are in the order of their bits.
    SHRM_INLINE Lanes anywhere(const Lanes& z) const {
        const Ints bits = reinterpret_cast<Ints>(z);
        return cubic(z, (bits < last ? bits : Ints{} + last) >> shift);
    }
};

// sum[c] += sum_j u(z_j) light[c][j] with z_j = ring + span azimuth[j], for n texels within the support.
// For each: 1 FMA for z, 1 shift and 4 permutations for the segment, 3 FMA for the cubic, 3 FMA for the sums.
template <class Profile>
SHRM_INLINE void sum_arc(const Profile& u, const float* azimuth, const float* const light[3], int n, float ring,
                         float span, Lanes sum[3]) {
    sum_weighted([&](int j) { return u(ring + span * load(azimuth + j)); }, light, n, sum);
}

}  // namespace shrm::angular
