// What this machine can do: products with sums per second, and bytes read per second from each level of its
// memory, as JSON. With as many threads as OMP_NUM_THREADS says; arguments: what L1, L2 and L3 hold, bytes.
// Each figure is the best of many short runs: a limit, not an average. Compiled and run by limits.py.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <omp.h>

namespace {

#if defined(__AVX512F__)
constexpr int bytes = 64;
#elif defined(__AVX__)
constexpr int bytes = 32;
#else
constexpr int bytes = 16;
#endif
typedef float Floats __attribute__((vector_size(bytes)));
typedef double Doubles __attribute__((vector_size(bytes)));

// So many sums that depend on themselves alone hide the latency of a product with its sum.
constexpr int chains = 12;

// The compiler must compute it.
template <class Vector>
void keep(const Vector& value) {
    Vector copy = value;
    asm volatile("" : "+m"(copy));
}

// Work per second of all threads at once: each starts with the others and keeps its best time, so that one
// which had to wait for a processor does not spoil the sum.
template <class Body>
double rate(int runs, double work_of_thread, const Body& body) {
    double sum = 0;
#pragma omp parallel reduction(+ : sum)
    {
        double best = 1e9;
        for (int run = 0; run < runs; ++run) {
#pragma omp barrier
            const auto start = std::chrono::steady_clock::now();
            body(omp_get_thread_num());
            const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
            best = std::min(best, taken.count());
        }
        sum += work_of_thread / best;
    }
    return sum;
}

template <class Vector>
double gigaflops() {
    constexpr int steps = 50000, lanes = sizeof(Vector) / sizeof(Vector{}[0]);
    return rate(100, 2e-9 * steps * chains * lanes, [](int) {
        Vector sums[chains] = {}, factor = Vector{} + 0.5f, term = Vector{} + 0.25f;
        asm volatile("" : "+m"(factor), "+m"(term));
        for (int i = 0; i < steps; ++i)
#pragma GCC unroll 12
            for (int c = 0; c < chains; ++c) sums[c] = sums[c] * factor + term;
        for (int c = 1; c < chains; ++c) sums[0] += sums[c];
        keep(sums[0]);
    });
}

// Reading `total` bytes, an equal part by each thread, again and again.
double read_gigabytes(std::size_t total) {
    const int threads = omp_get_max_threads();
    constexpr std::size_t block = 8;
    const std::size_t vectors = total / sizeof(Floats) / std::size_t(threads) / block * block;
    const std::size_t repeats =
        std::max<std::size_t>(1, (std::size_t(32) << 20) / (vectors * sizeof(Floats)));
    std::vector<std::vector<Floats>> parts(static_cast<std::size_t>(threads));
#pragma omp parallel
    parts[std::size_t(omp_get_thread_num())].assign(vectors, Floats{} + 1.f);
    const int runs = total > (std::size_t(64) << 20) ? 15 : 100;
    return rate(runs, 1e-9 * double(repeats * vectors * sizeof(Floats)), [&](int thread) {
        const Floats* from = parts[std::size_t(thread)].data();
        Floats sums[block] = {};
        for (std::size_t r = 0; r < repeats; ++r) {
            for (std::size_t i = 0; i < vectors; i += block)
#pragma GCC unroll 8
                for (std::size_t k = 0; k < block; ++k) sums[k] += from[i + k];
            asm volatile("" : "+r"(from) : : "memory");
        }
        for (std::size_t k = 1; k < block; ++k) sums[0] += sums[k];
        keep(sums[0]);
    });
}

}  // namespace

int main(int count, char** arguments) {
    if (count != 4) return 2;
    const auto bytes_of = [&](int i) { return std::strtoull(arguments[i], nullptr, 10); };
    std::printf("{\"threads\": %d, \"vector_bytes\": %d, \"float\": %.1f, \"double\": %.1f,\n",
                omp_get_max_threads(), bytes, gigaflops<Floats>(), gigaflops<Doubles>());
    std::printf(" \"read\": {\"L1\": %.1f, \"L2\": %.1f, \"L3\": %.1f, \"DRAM\": %.1f}}\n",
                read_gigabytes(bytes_of(1) / 2), read_gigabytes(bytes_of(2) / 2),
                read_gigabytes(bytes_of(3) / 2), read_gigabytes(bytes_of(3) * 8));
}
