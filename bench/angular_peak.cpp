// What the innermost loop of direct integration could do if nothing but its own instructions counted: the same
// code on rows that stay in the first cache, without rows to find, and the processor's multiply-adds alone.
// Prints: samples per second of the loop, floating point operations per sample, and operations per second of
// fused multiply-adds. Built and run by bench_angular.py.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

#include "shrm/angular_profile.hpp"

namespace {

using namespace shrm::angular;

constexpr int n = 1024;  // four rows of which fill a third of 48 KiB
constexpr int repeats = 2000, trials = 25;

template <class Work>
double least_seconds(const Work& work) {
    double least = 1e9;
    for (int trial = 0; trial < trials; ++trial) {
        const auto start = std::chrono::steady_clock::now();
        work();
        least = std::min(
            least, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
    return least;
}

// Not inlined, so that the compiler may not see that every repeat is the same.
__attribute__((noinline)) void row(const Cubics<true>& profile, const float* azimuth, const float* const light[3],
                                   float ring, float span, Lanes out[3]) {
    const Cubics<true> u = profile;
    Lanes sum[3] = {};
    sum_arc(u, azimuth, light, n, ring, span, sum);
    std::copy_n(sum, 3, out);
}

__attribute__((noinline)) void multiply_adds(Lanes x[12], const Lanes& a) {
    Lanes y[12];
    std::copy_n(x, 12, y);
    for (int k = 0; k < n; ++k)
        for (Lanes& one : y) one = one * a + a;
    std::copy_n(y, 12, x);
}

}  // namespace

int main() {
    std::vector<float> values(4 * held_segments, 0.25f), rows(4 * n);
    for (int k = 0; k < 4 * n; ++k) rows[static_cast<std::size_t>(k)] = static_cast<float>(k % n) / n;
    const Cubics<true> profile({values, 1, held_segments, 21, 1.0, shrm::pi}, 0);
    const float* light[3] = {rows.data() + n, rows.data() + 2 * n, rows.data() + 3 * n};
    Lanes sum[3] = {}, x[12] = {}, all = {};
    const double loop = least_seconds([&] {
        for (int k = 0; k < repeats; ++k) {
            row(profile, rows.data(), light, 1.0f, 200.0f, sum);
            for (const Lanes& part : sum) all += part;
        }
    });
    const double fma = least_seconds([&] {
        for (int k = 0; k < repeats; ++k) multiply_adds(x, all * 1e-20f);
    });
    for (const Lanes& part : x) all += part;
    volatile float kept = all[0];
    static_cast<void>(kept);
    // 7 multiply-adds: z, the cubic (3) and the sums (3)
    std::printf("%.4g %d %.4g\n", repeats * static_cast<double>(n) / loop, 14,
                repeats * 2.0 * n * 12 * width / fma);
    return 0;
}
