#include "shrm/sh/analysis.hpp"

#include <omp.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "shrm/core.hpp"
#include "shrm/quadrature.hpp"
#include "shrm/simd/shuffles.hpp"
#include "shrm/simd/vectors.hpp"

namespace shrm {
namespace {

// Sums and differences of two rings, channel by channel: sum and difference (channels, W).
inline void planes(const float* north, const float* south, int W, int channels, float* sum,
                   float* difference) {
    int j = 0;
    if (channels == 3)
        for (; j + lanes <= W; j += lanes) {
            Floats of_channels[6];
            sum_and_difference<false>(north + 3 * j, south + 3 * j, of_channels);
            for (int c = 0; c < 3; ++c) {
                store(sum + c * W + j, of_channels[c]);
                store(difference + c * W + j, of_channels[3 + c]);
            }
        }
    for (; j < W; ++j)
        for (int c = 0; c < channels; ++c) {
            const float n = north[j * channels + c], m = south[j * channels + c];
            sum[c * W + j] = n + m;
            difference[c * W + j] = n - m;
        }
}

// products(i, z) = sum over the rings of rows(2 i) modes(z), for I degrees of one parity and two modes.
template <int I>
SHRM_KERNEL inline void legendre_product(const float* rows, const float* modes, int padded,
                                         float products[][2]) {
    constexpr int N = std::bit_ceil(unsigned(2 * I)), at_once = std::min(N, lanes);
    Floats sums[N] = {};
    for (int k = 0; k < padded; k += lanes) {
        const Floats a = load(modes + k), b = load(modes + padded + k);
        unrolled<I>([&](auto i) {
            const Floats f = load(rows + 2 * i * padded + k);
            sums[2 * i] += f * a;
            sums[2 * i + 1] += f * b;
        });
    }
    unrolled<N / at_once>([&](auto part) {
        Floats group[at_once];
        unrolled<at_once>([&](auto k) { group[k] = sums[part * at_once + k]; });
        const Floats total = sums_of(group);
        unrolled<at_once>([&](auto k) {
            constexpr int z = part * at_once + k;
            if constexpr (z < 2 * I) products[z / 2][z % 2] = total[int(k)];
        });
    });
}

// Pairs of rings that are folded at once: the fewest that fill whole blocks of rows, which stay in the first
// cache. Of small pictures `lanes` or more, so that modes are put in place by transposing whole vectors: that
// saves more than leaving the first cache for the second costs.
int pairs_at_once(int W, int channels) {
    constexpr std::size_t small = 1 << 17;  // bytes of folded rows, a part of any second cache
    const int few = RingFourier::row_block / 2 / std::gcd(RingFourier::row_block / 2, channels);
    const int many = round_up(lanes, few);
    return size(many * 2) * size(channels) * size(W) * sizeof(float) <= small ? many : few;
}

}  // namespace

std::vector<double> fejer_weights(int H) {
    // w_i = 2/H (1 - 2 sum_k cos(2 k theta_i) / (4 k^2 - 1)), k <= H/2 [W06]; the cosines by recurrence.
    std::vector<double> weights(size(H));
    for (int i = 0; i < H; ++i) {
        const double twice = 2 * std::cos(2 * (i + 0.5) * pi / H);
        double sum = 0, c0 = 1, c1 = twice / 2;
        for (int k = 1; k <= H / 2; ++k) {
            sum += c1 / (4.0 * k * k - 1);
            c0 = std::exchange(c1, twice * c1 - c0);
        }
        weights[size(i)] = 2.0 / H * (1 - 2 * sum);
    }
    return weights;
}

Analysis::Analysis(int H, int W, int channels, int F, Texel texel, Tables tables)
    : H_(H),
      W_(W),
      channels_(channels),
      F_(F),
      rings_((H + 1) / 2),
      padded_(round_up(rings_, lanes)),
      pairs_(pairs_at_once(W, channels)),
      nodes_(1),
      fourier_(W, F),
      recurrence_(F) {
    // Weights in theta: the sum over a ring's nodes of weight f_lm(node) is f_lm sin(theta) dtheta for
    // samples, its integral over the row for areas.
    const double row = pi / H, step = 2 * pi / W;
    std::vector<double> offsets{0.}, weights{1.}, fejer;
    if (texel == Texel::area) {
        // f_lm sin(theta) is a trigonometric polynomial of degree l + 1: within a row it turns by
        // (F + 1) row radians, and 5 more nodes than half of that leave an error below 1e-13.
        nodes_ = 5 + static_cast<int>((F + 1) * row / 2);
        gauss_legendre(nodes_, offsets, weights);
    } else {
        fejer = fejer_weights(H);
    }
    x_.assign(size(nodes_ * padded_), 0);
    sine_ = weight_ = x_;
    for (int g = 0; g < nodes_; ++g)
        for (int i = 0; i < rings_; ++i) {
            const double theta = (i + 0.5 + offsets[size(g)] / 2) * row;
            const std::size_t at = size(g * padded_ + i);
            x_[at] = std::cos(theta);
            sine_[at] = std::sin(theta);
            weight_[at] = texel == Texel::sample ? fejer[size(i)] : weights[size(g)] * row / 2 * sine_[at];
        }
    // Weights in phi: dphi for samples, the integral of cos(m phi) over a texel for areas
    for (int m = 0; m <= F; ++m) {
        const double half = m * step / 2, sinc = m == 0 || texel == Texel::sample ? 1 : std::sin(half) / half;
        order_weight_.push_back(step * sinc * (m ? std::numbers::sqrt2 : 1));
    }
    // The place that each output of the Fourier transform goes to; -1 where it holds no mode
    modes_.assign(size(F + 1) * size(4 * channels) * size(padded_), 0);
    place_.assign(size(fourier_.mode_pitch()), -1);
    for (int m = 0; m <= F; ++m)
        for (int s = 0; s < 2; ++s)
            place_[fourier_.mode_at(s == 1, m)] = std::ptrdiff_t(4 * m + s) * channels * padded_;

    // The Legendre functions of all orders, if they are to be kept and are not too many.
    if (tables == Tables::kept && row_size(F + 1) * sizeof(float) <= largest_kept_table) {
        table_.resize(row_size(F + 1));
#pragma omp parallel
        {
            Scratch scratch;
#pragma omp for schedule(dynamic)
            for (int m = 0; m <= F; ++m) legendre_rows(m, scratch, &table_[row_size(m)]);
        }
    }
}

std::size_t Analysis::row_size(int m) const {
    return size(m) * size(2 * F_ + 3 - m) / 2 * size(padded_);
}

// L_m(theta), the integral over phi: [RH02] section 6.1, first step, for pairs_ rings from first_ring on and
// their mirror images.
void Analysis::fourier_step(const float* pixels, int first_ring, Scratch& scratch) {
    const std::size_t ring = size(W_) * size(channels_);
    const int rows = 2 * pairs_ * channels_;
    scratch.planar.resize(2 * ring);
    scratch.folded.resize(size(fourier_.folds() * rows) * size(fourier_.pitch()));
    scratch.modes.resize(size(rows) * size(fourier_.mode_pitch()));
    // Rings folded about their symmetries, a northern one together with its mirror image.
    const int count = std::min(pairs_, rings_ - first_ring);
    float *sum = scratch.planar.data(), *difference = sum + ring;
    for (int i = 0; i < count; ++i) {
        const int north = first_ring + i, south = H_ - 1 - north;
        // The equator's ring mirrors onto itself, and is taken once.
        const float* mirrored = pixels + size(south) * ring;
        if (channels_ == 3 && north != south && fourier_.fold_pair_serves()) {
            fourier_.fold_pair(pixels + size(north) * ring, mirrored, 2 * channels_ * i, rows,
                               scratch.folded.data());
            continue;
        }
        planes(pixels + size(north) * ring, mirrored, W_, channels_, sum, difference);
        if (north == south)
            for (std::size_t j = 0; j < ring; ++j) sum[j] /= 2;
        fourier_.fold(sum, 2 * channels_, 2 * channels_ * i, rows, scratch.folded.data());
    }
    fourier_.analyse(scratch.folded.data(), rows, scratch.modes.data());

    // Modes to their places: rings side by side, whole squares of them by transposition
    const std::size_t pitch = size(fourier_.mode_pitch()), apart = 2 * size(channels_) * pitch;
    for (int parity = 0; parity < 2; ++parity)
        for (int c = 0; c < channels_; ++c) {
            const float* from = &scratch.modes[size(parity * channels_ + c) * pitch];
            float* to = &modes_[size(2 * parity * channels_ + c) * size(padded_) + size(first_ring)];
            int i = 0;
            for (; i + lanes <= count; i += lanes)
                for (std::size_t column = 0; column < pitch; column += lanes) {
                    Floats square[lanes];
                    for (int k = 0; k < lanes; ++k) square[k] = load(from + size(i + k) * apart + column);
                    transpose(square);
                    for (std::size_t k = 0; k < lanes; ++k)
                        if (place_[column + k] >= 0) store(to + place_[column + k] + i, square[k]);
                }
            for (std::size_t column = 0; column < pitch; ++column)
                for (int k = i; k < count && place_[column] >= 0; ++k)
                    to[place_[column] + k] = from[size(k) * apart + column];
        }
}

// f_lm of one order, with all the weights of the quadrature: rows (l - m, padded rings).
void Analysis::legendre_rows(int m, Scratch& scratch, float* rows) const {
    const std::size_t count = size(nodes_ * padded_);
    std::vector<double>&f = scratch.f, &previous = scratch.previous, &row = scratch.row;
    f.resize(count);
    previous.assign(count, 0);
    row.resize(size(padded_));
    for (std::size_t i = 0; i < count; ++i)
        f[i] = order_weight_[size(m)] * recurrence_.start(m) * power(sine_[i], m);
    for (int l = m; l <= F_; ++l) {
        std::fill(row.begin(), row.end(), 0.);
        for (std::size_t g = 0; g < size(nodes_); ++g)
            for (std::size_t i = 0; i < size(padded_); ++i)
                row[i] += weight_[g * size(padded_) + i] * f[g * size(padded_) + i];
        for (std::size_t i = 0; i < size(padded_); ++i) *rows++ = static_cast<float>(row[i]);
        const auto [a, b] = recurrence_.steps(m)[l - m];
        for (std::size_t i = 0; i < count; ++i) {
            const double next = a * x_[i] * f[i] - b * previous[i];
            previous[i] = f[i];
            f[i] = next;
        }
    }
}

// L_lm, the integral over theta: [RH02] section 6.1, second step, for one order.
void Analysis::legendre_step(int m, Scratch& scratch, double* coefficients) {
    // The order's Legendre functions, from the table or computed anew.
    const float* rows = table_.data() + row_size(m);
    if (table_.empty()) {
        scratch.legendre.resize(size(F_ + 1 - m) * size(padded_));
        legendre_rows(m, scratch, scratch.legendre.data());
        rows = scratch.legendre.data();
    }
    // Products with the modes of their own parity, several degrees and two modes at a time.
    constexpr int I = 4;  // degrees whose sums stay in registers
    for (int parity = 0; parity < 2; ++parity)
        for (int l0 = m + parity; l0 <= F_; l0 += 2 * I)
            // modes two by two: the cosine's channels, then the sine's
            for (int z = 0; z < 2 * channels_; z += 2) {
                const float* modes = &modes_[size(((m * 2 + parity) * 2) * channels_ + z) * size(padded_)];
                const float* first = rows + size(l0 - m) * size(padded_);
                const int degrees = std::min(I, (F_ - l0) / 2 + 1);
                float products[I][2];
                switch (degrees) {
                    case 1:
                        legendre_product<1>(first, modes, padded_, products);
                        break;
                    case 2:
                        legendre_product<2>(first, modes, padded_, products);
                        break;
                    case 3:
                        legendre_product<3>(first, modes, padded_, products);
                        break;
                    default:
                        legendre_product<4>(first, modes, padded_, products);
                }
                for (int i = 0; i < degrees; ++i)
                    for (int y = z; y < z + 2; ++y) {
                        const bool is_sine = y >= channels_;
                        if (m > 0 || !is_sine)
                            coefficients[lm(l0 + 2 * i, is_sine ? -m : m) * size(channels_) +
                                         size(y % channels_)] = products[i][y - z];
                    }
            }
}

void Analysis::run(std::span<const float> pixels, std::span<double> coefficients) {
    if (scratch_.size() < size(omp_get_max_threads())) scratch_.resize(size(omp_get_max_threads()));
#pragma omp parallel
    {
        Scratch& scratch = scratch_[size(omp_get_thread_num())];
#pragma omp for schedule(static)
        for (int i = 0; i < rings_; i += pairs_) fourier_step(pixels.data(), i, scratch);
#pragma omp for schedule(dynamic)
        for (int m = 0; m <= F_; ++m) legendre_step(m, scratch, coefficients.data());
    }
}

}  // namespace shrm
