// What the innermost loop of direct integration could do if nothing but its own instructions counted: the
// same code on rows that stay in the first cache, without rows to find, and the processor's multiply-adds
// alone. Prints samples per second of the loop for radial lobes and of those for half-angle lobes, half
// vectors found anew or read from a table, and floating point operations per second of fused multiply-adds.
// Built and run by bench_angular.py.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

#include "shrm/angular/profile.hpp"

namespace {

using namespace shrm;
using namespace shrm::angular;

constexpr int n = 1024;  // seven rows of which are 28 KiB
constexpr int turned = 64;
constexpr int repeats = 2000, trials = 25;

template <class Work>
double least_seconds(const Work& work) {
    double least = 1e9;
    for (int trial = 0; trial < trials; ++trial) {
        const auto start = std::chrono::steady_clock::now();
        work();
        least =
            std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
    return least;
}

// Not inlined, so that the compiler may not see that every repeat is the same.
__attribute__((noinline)) void row(const Cubics<true>& profile, const float* azimuth,
                                   const float* const light[3], float ring, float span, Floats out[3]) {
    const Cubics<true> u = profile;
    Floats sum[3] = {};
    sum_turned(u, azimuth, 1, light, turned, splat(ring), splat(span), sum);
    std::copy_n(sum, 3, out);
}

template <class Source>
__attribute__((noinline)) void half_angle_row(const Cubics<true>& profile, const Source& half_vectors,
                                              const float* const light[3], const HalfAngleRow& row,
                                              Floats out[3]) {
    const Cubics<true> u = profile;
    Floats sum[3] = {};
    sum_weighted([&](int j) { return half_angle<false>(u, half_vectors, nullptr, j, row); }, light, n, sum);
    std::copy_n(sum, 3, out);
}

__attribute__((noinline)) void multiply_adds(Floats x[12], const Floats& a) {
    Floats y[12];
    std::copy_n(x, 12, y);
    for (int k = 0; k < n; ++k)
        for (Floats& one : y) one = one * a + a;
    std::copy_n(y, 12, x);
}

}  // namespace

int main() {
    std::vector<float> values(4 * held_segments, 0.25f), rows(7 * n);
    for (int k = 0; k < 7 * n; ++k) rows[static_cast<std::size_t>(k)] = static_cast<float>(k % n) / n;
    const Cubics<true> profile({values, 1, held_segments, 21, 1.0, pi}, 0);
    const float* light[3] = {rows.data() + n, rows.data() + 2 * n, rows.data() + 3 * n};
    Floats sum[3] = {}, x[12] = {}, all = {};
    const double loop = least_seconds([&] {
        for (int k = 0; k < repeats; ++k) {
            row(profile, rows.data(), light, 1.0f, 200.0f, sum);
            for (const Floats& part : sum) all += part;
        }
    });
    const auto half_angle_seconds = [&](const auto& half_vectors) {
        return least_seconds([&] {
            for (int k = 0; k < repeats; ++k) {
                half_angle_row(profile, half_vectors, light, {{0.5f, 0.5f, 0.5f}, 1.0f, 0.5f}, sum);
                for (const Floats& part : sum) all += part;
            }
        });
    };
    const float* half = rows.data() + 4 * n;
    const double computed =
        half_angle_seconds(ComputedHalfVectors{half, half + n, 0.5f, 0.5f, {0.6f, 0.0f, 0.8f}, 9.0f});
    const double tabulated = half_angle_seconds(TabulatedHalfVectors{half, half + n, half + 2 * n});
    const double fma = least_seconds([&] {
        for (int k = 0; k < repeats; ++k) multiply_adds(x, all * 1e-20f);
    });
    for (const Floats& part : x) all += part;
    volatile float kept = all[0];
    static_cast<void>(kept);
    const double samples = repeats * static_cast<double>(n);
    std::printf("%.4g %.4g %.4g %.4g\n", repeats * static_cast<double>(turned * lanes) / loop,
                samples / computed, samples / tabulated, 2 * samples * 12 * lanes / fma);
    return 0;
}
