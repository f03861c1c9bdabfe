#include "shrm/sh/synthesis.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>

#include "shrm/core.hpp"
#include "shrm/simd/stream.hpp"
#include "shrm/simd/vectors.hpp"

namespace shrm {
namespace {

// Northern rings whose Legendre sums are made together.
constexpr int ring_block = 4;

// For the rings of a block and V vectors of channels: the sum over l of rows(l - m, ring) ordered(l - m). The
// northern modes are the even degrees plus the odd ones, the southern ones their difference: f_lm(pi - theta)
// = (-1)^{l+m} f_lm(theta).
template <int V>
SHRM_KERNEL inline void legendre_product(const float* rows, const float* ordered, int degrees, int stride,
                                         float* north, float* south, std::size_t ring) {
    Floats sums[2][ring_block][V] = {};
    const auto add = [&](auto parity, int i) {
        unrolled<V>([&](auto v) {
            Floats c = load(ordered + i * stride + v * lanes);
            keep(c);
            unrolled<ring_block>([&](auto b) { sums[parity][b][v] += rows[i * ring_block + b] * c; });
        });
    };
    const std::integral_constant<int, 0> even;
    const std::integral_constant<int, 1> odd;
    int i = 0;
    for (; i + 2 <= degrees; i += 2) {
        add(even, i);
        add(odd, i + 1);
    }
    if (i < degrees) add(even, i);
    unrolled<ring_block>([&](auto b) {
        unrolled<V>([&](auto v) {
            store(north + size(b) * ring + v * lanes, sums[0][b][v] + sums[1][b][v]);
            store(south + size(b) * ring + v * lanes, sums[0][b][v] - sums[1][b][v]);
        });
    });
}

}  // namespace

Synthesis::Synthesis(int H, int W, int channels, int F, Tables tables)
    : H_(H),
      W_(W),
      channels_(channels),
      F_(F),
      blocks_(((H + 1) / 2 + ring_block - 1) / ring_block),
      stride_(round_up(2 * channels, lanes)),
      fourier_(W, F),
      recurrence_(F),
      ordered_(degrees_below(F + 1) * size(stride_), 0.f) {
    const std::size_t block_size = degrees_below(F + 1) * ring_block;
    if (tables == Tables::kept && size(blocks_) * block_size * sizeof(float) <= largest_kept_table) {
        table_.resize(size(blocks_) * block_size);
#pragma omp parallel for schedule(static)
        for (int block = 0; block < blocks_; ++block)
            for (int m = 0; m <= F; ++m)
                legendre_rows(block, m, &table_[size(block) * block_size + degrees_below(m) * ring_block]);
    }
}

std::size_t Synthesis::degrees_below(int m) const {
    return size(m) * size(2 * F_ + 3 - m) / 2;
}

// The coefficients of one order side by side, degree by degree, with the norm of the real basis.
void Synthesis::gather(int m, const double* coefficients) {
    const double norm = m ? std::numbers::sqrt2 : 1;
    float* to = &ordered_[degrees_below(m) * size(stride_)];
    for (int l = m; l <= F_; ++l, to += stride_) {
        const double* cosine = coefficients + lm(l, m) * size(channels_);
        for (int c = 0; c < channels_; ++c) to[c] = static_cast<float>(norm * cosine[c]);
        if (m == 0) continue;
        const double* sine = coefficients + lm(l, -m) * size(channels_);
        for (int c = 0; c < channels_; ++c) to[channels_ + c] = static_cast<float>(norm * sine[c]);
    }
}

// f_lm of one order on the northern rings of a block: rows (l - m, ring).
void Synthesis::legendre_rows(int block, int m, float* rows) const {
    double x[ring_block], f[ring_block], previous[ring_block] = {};
    for (int b = 0; b < ring_block; ++b) {
        const double theta = (block * ring_block + b + 0.5) * pi / H_;
        x[b] = std::cos(theta);
        f[b] = recurrence_.start(m) * power(std::sin(theta), m);
    }
    for (int l = m; l <= F_; ++l) {
        const auto [a, back] = recurrence_.steps(m)[l - m];
        for (int b = 0; b < ring_block; ++b) {
            *rows++ = static_cast<float>(f[b]);
            const double next = a * x[b] * f[b] - back * previous[b];
            previous[b] = f[b];
            f[b] = next;
        }
    }
}

// The modes of a block's northern rings, then of their mirror images: (2 ring_block, F + 1, stride).
void Synthesis::legendre_step(int block, Scratch& scratch) const {
    const std::size_t ring = size(F_ + 1) * size(stride_);
    scratch.modes.resize(2 * ring_block * ring);
    const std::size_t block_size = degrees_below(F_ + 1) * ring_block;
    for (int m = 0; m <= F_; ++m) {
        const float* rows = table_.data() + size(block) * block_size + degrees_below(m) * ring_block;
        if (table_.empty()) {
            scratch.legendre.resize(size(F_ + 1) * ring_block);
            legendre_rows(block, m, scratch.legendre.data());
            rows = scratch.legendre.data();
        }
        const float* ordered = &ordered_[degrees_below(m) * size(stride_)];
        float* north = &scratch.modes[size(m) * size(stride_)];
        float* south = north + ring_block * ring;
        constexpr int V = vector_registers >= 32 ? 3 : 1;
        int z = 0;
        for (; z + V * lanes <= stride_; z += V * lanes)
            legendre_product<V>(rows, ordered + z, F_ + 1 - m, stride_, north + z, south + z, ring);
        for (; z < stride_; z += lanes)
            legendre_product<1>(rows, ordered + z, F_ + 1 - m, stride_, north + z, south + z, ring);
    }
}

void Synthesis::run(std::span<const double> coefficients, std::span<float> rings) {
    if (scratch_.size() < size(omp_get_max_threads())) scratch_.resize(size(omp_get_max_threads()));
    const std::size_t mode_size = size(F_ + 1) * size(stride_), ring_size = size(channels_) * size(W_);
    const bool streamed = rings.size_bytes() >= streamed_from;
#pragma omp parallel
    {
#pragma omp for schedule(static, 1)
        for (int m = 0; m <= F_; ++m) gather(m, coefficients.data());
        Scratch& scratch = scratch_[size(omp_get_thread_num())];
        if (streamed) scratch.channels.resize(3 * size(W_));
        float* const through = streamed ? scratch.channels.data() : nullptr;
#pragma omp for schedule(static)
        for (int block = 0; block < blocks_; ++block) {
            legendre_step(block, scratch);
            for (int b = 0; b < ring_block; ++b) {
                const int north = block * ring_block + b, south = H_ - 1 - north;
                if (north > south) break;
                const float* modes = &scratch.modes[size(b) * mode_size];
                fourier_.synthesise(modes, channels_, stride_, &rings[size(north) * ring_size], through);
                if (south > north)
                    fourier_.synthesise(modes + ring_block * mode_size, channels_, stride_,
                                        &rings[size(south) * ring_size], through);
            }
        }
        if (streamed) end_of_stream();
    }
}

}  // namespace shrm
