// A radial profile evaluated in lanes, and the innermost loops of direct integration: for each texel of an
// arc the angle, the profile and three sums. Private to angular.
#pragma once

#include <glm/vec3.hpp>

#include "shrm/angular/angular.hpp"
#include "shrm/angular/sums.hpp"

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
    static constexpr int groups = permutes ? held_segments / lanes : 1;

    Floats group[4][groups];
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
                    group[power][g] = load(table + power * held_segments + g * lanes);
    }

    SHRM_INLINE Floats coefficient(int power, const Ints& k) const {
        if constexpr (permutes && groups == 2) return __builtin_shuffle(group[power][0], group[power][1], k);
        if constexpr (permutes && groups == 4) {
            const Floats low = __builtin_shuffle(group[power][0], group[power][1], k);
            const Floats high = __builtin_shuffle(group[power][2], group[power][3], k);
            return (k & 16) != 0 ? high : low;
        }
        Floats c = {};
        for (int lane = 0; lane < lanes; ++lane)
            c[lane] = table[power * segments + (k[lane] & (segments - 1))];
        return c;
    }

    SHRM_INLINE Floats cubic(const Floats& z, const Ints& k) const {
        const Floats x = held ? z : within_segment(z);
        return ((coefficient(3, k) * x + coefficient(2, k)) * x + coefficient(1, k)) * x + coefficient(0, k);
    }

    // The bits of z that do not tell the segment, as the mantissa of a number in [1, 2).
    SHRM_INLINE Floats within_segment(const Floats& z) const {
        const Ints bits = Ints(z) << (23 - shift);
        return Floats((bits & 0x7fffff) | 0x3f800000);
    }

    // u at z = 1 + scale sin^2(theta/2), within the support.
    SHRM_INLINE Floats operator()(const Floats& z) const { return cubic(z, Ints(z) >> shift); }

    // The same anywhere: the last segment is 0. Positive floats are in the order of their bits.
    SHRM_INLINE Floats anywhere(const Floats& z) const {
        const Ints bits = Ints(z);
        return cubic(z, (bits < last ? bits : Ints{} + last) >> shift);
    }
};

// sum[c] += sum_j u(z_j) light[c][j] with z_j = ring + span azimuth[j], for n texels within the support.
// For each: 1 FMA for z, 1 shift and 4 permutations for the segment, 3 FMA for the cubic, 3 FMA for the sums.
template <class Profile>
SHRM_INLINE void sum_arc(const Profile& u, const float* azimuth, const float* const light[3], int n,
                         float ring, float span, Floats sum[3]) {
    sum_weighted([&](int j) { return u(ring + span * load(azimuth + j)); }, light, n, sum);
}

// The same texels from as many centers as there are lanes, each turned by one texel more than the one before:
// none of the lanes is idle, however short the arc. All lanes have one angle, and each finds its weight anew:
// this is the method of every pair; sliding a kernel finds it once. Every `apart`-th azimuth belongs to light
// one further.
template <class Profile>
SHRM_INLINE void sum_turned(const Profile& u, const float* azimuth, int apart, const float* const light[3],
                            int n, const Floats& ring, const Floats& span, Floats sum[3]) {
    Floats s[3] = {sum[0], sum[1], sum[2]};
    for (int j = 0; j < n; ++j) {
        const Floats w = u(ring + span * splat(azimuth[j * apart]));
        for (int c = 0; c < 3; ++c) s[c] += w * load(light[c] + j);
    }
    for (int c = 0; c < 3; ++c) sum[c] = s[c];
}

// g H of lights, g = sqrt(scale) / 2, so that z = 1 + |g H - g N|^2: sin^2(theta_h / 2) = |H - N|^2 / 4 keeps
// its accuracy for small angles.
struct HalfVectors {
    Floats x, y, z;
};

// Half vectors of a row of nodes from a table.
struct TabulatedHalfVectors {
    const float *x, *y, *z;
    SHRM_INLINE HalfVectors at(int j) const { return {load(x + j), load(y + j), load(z + j)}; }
};

// Half vectors of a row of nodes under one view, found anew: 2 FMA for L + V, 2 FMA for its square, its
// root's inverse, 3 products.
struct ComputedHalfVectors {
    const float *cos_phi, *sin_phi;
    float sin_theta, z;  // z of L + V
    glm::vec3 view;
    float g;

    SHRM_INLINE HalfVectors at(int j) const {
        const Floats x = sin_theta * load(cos_phi + j) + view.x, y = sin_theta * load(sin_phi + j) + view.y;
        const Floats square = x * x + (y * y + z * z);
        // L = -V, which has no half vector, is below the horizon
        const Floats r = g * inverse_root(square > 1e-30f ? square : Floats{} + 1e-30f);
        return {r * x, r * y, r * z};
    }
};

// Constants of a query and a row of nodes: g N, and N.L = sin_theta height + rest.
struct HalfAngleRow {
    glm::vec3 n;
    float sin_theta, rest;
};

// u(theta_h) where N.L > 0 for a group of lanes from j on; where nothing is cut by the horizon it is not
// looked at. For each 3 differences, 3 FMA for z, 1 minimum, 1 shift and 4 permutations, 3 FMA for the cubic,
// then 3 FMA for the sums; the horizon takes 1 FMA, 1 comparison.
template <bool cut, class Profile, class Source>
SHRM_INLINE Floats half_angle(const Profile& u, const Source& half_vectors, const float* height, int j,
                              const HalfAngleRow& row) {
    const HalfVectors h = half_vectors.at(j);
    const Floats dx = h.x - row.n.x, dy = h.y - row.n.y, dz = h.z - row.n.z;
    const Floats weight = u.anywhere(dz * dz + (dy * dy + (dx * dx + 1.0f)));
    if constexpr (!cut) return weight;
    const Floats above = row.sin_theta * load(height + j) + row.rest;
    return only(above > 0.0f, weight);
}

}  // namespace shrm::angular
