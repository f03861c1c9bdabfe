// Sums in the lanes of vectors. Private to angular.
#pragma once

#include <cstring>

#include "shrm/angular/angular.hpp"
#include "shrm/simd/vectors.hpp"

namespace shrm::angular {

static_assert(most_lanes % lanes == 0);

// total[k] += lane k. By reference: of a copy g++ 12 would convert one lane at a time.
SHRM_INLINE void add_in_double(const Floats& part, double* total) {
    float single[lanes];
    std::memcpy(single, &part, sizeof part);
    for (int k = 0; k < lanes; ++k) total[k] += static_cast<double>(single[k]);
}

// Sums of three channels, in double, of parts that were summed in single precision.
struct Sum {
    double total[3][lanes] = {};

    // Adds a part, and empties it.
    SHRM_INLINE void add(Floats part[3]) {
        for (int c = 0; c < 3; ++c) {
            add_in_double(part[c], total[c]);
            part[c] = Floats{};
        }
    }
    SHRM_INLINE void write(float* out) {
        for (int c = 0; c < 3; ++c) {
            for (int half = lanes / 2; half > 0; half /= 2)
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
SHRM_INLINE void sum_weighted(const Weight& weight, const float* const light[3], int n, Floats sum[3]) {
    Floats s[3] = {sum[0], sum[1], sum[2]};  // in registers, whatever `sum` is
    int j = 0;
    for (; j + lanes <= n; j += lanes) {
        const Floats w = weight(j);
        for (int c = 0; c < 3; ++c) s[c] += w * load(light[c] + j);
    }
    if (j < n) {
        const Floats w = only(first_lanes(n - j), weight(j));
        for (int c = 0; c < 3; ++c) s[c] += w * load(light[c] + j);
    }
    for (int c = 0; c < 3; ++c) sum[c] = s[c];
}

// Adds sum_j weight[c][j] light[c][j], n of them; both are readable in whole groups of lanes.
SHRM_INLINE void accumulate(const float* const weight[3], const float* const light[3], int n, Sum& sum) {
    Floats single[3] = {};
    int j = 0;
    for (; j + lanes <= n; j += lanes)
        for (int c = 0; c < 3; ++c) single[c] += load(weight[c] + j) * load(light[c] + j);
    if (j < n)
        for (int c = 0; c < 3; ++c)
            single[c] += only(first_lanes(n - j), load(weight[c] + j)) * load(light[c] + j);
    sum.add(single);
}

}  // namespace shrm::angular
