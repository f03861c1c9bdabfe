#include "shrm/ring_fourier.hpp"

#include <algorithm>
#include <cmath>

#include "shrm/core.hpp"

namespace shrm {
namespace {

typedef float f8 __attribute__((vector_size(32)));
typedef float f8u __attribute__((vector_size(32), aligned(4)));  // loads from any address

// products(r, j) = sum over k of rows(r, k) table(k, j), for 8 columns j. At most 256 texels are added up in
// float32, those sums in float64.
template <int R>
inline void analysis_product(const float* rows, int K, const float* table, int columns, double* products) {
    constexpr int block = 256;
    for (int k0 = 0; k0 < K; k0 += block) {
        f8 sums[R] = {};
        for (int k = k0; k < std::min(K, k0 + block); ++k) {
            const f8 t = *reinterpret_cast<const f8u*>(table + size(k) * size(columns));
            for (int r = 0; r < R; ++r) sums[r] += rows[size(r) * size(K) + size(k)] * t;
        }
        for (int r = 0; r < R; ++r)
            for (int j = 0; j < 8; ++j) products[r * 8 + j] += double(sums[r][j]);
    }
}

}  // namespace

RingFourier::RingFourier(int W, int max_order)
    : W_(W),
      max_order_(max_order),
      quarters_(W % 2 == 0),
      K_(quarters_ ? (W + 2) / 4 : (W + 1) / 2),
      K_padded_(round_up(K_, 16)) {
    const double step = 2 * pi / W;
    for (int m = 0; m <= max_order; ++m) {
        const double half = m * step / 2;
        weight_sample_.push_back(step);
        weight_area_.push_back(m == 0 ? step : step * std::sin(half) / half);
    }
    const int stride = quarters_ ? 2 : 1;
    for (bool sine : {false, true})
        for (int parity = 0; parity < stride; ++parity) {
            Fold f;
            f.sine = sine;
            f.sign_b = sine != (parity == 1) ? -1.f : 1.f;
            f.sign_d = sine ? -1.f : 1.f;
            for (int m = parity; m <= max_order; m += stride) f.orders.push_back(m);
            const int n = static_cast<int>(f.orders.size());
            f.columns = round_up(n, 8);
            f.by_texel.assign(size(K_) * size(f.columns), 0);
            f.by_order.assign(size(n) * size(K_padded_), 0);
            for (int i = 0; i < n; ++i) {
                // phi = pi - psi: cos(m phi) = (-1)^m cos(m psi), sin(m phi) = -(-1)^m sin(m psi)
                const int m = f.orders[size(i)];
                const double sign = (m % 2 ? -1 : 1) * (sine ? -1 : 1);
                for (int k = 0; k < K_; ++k) {
                    const double psi = (k + 0.5) * step;
                    const auto value =
                        static_cast<float>(sign * (sine ? std::sin(m * psi) : std::cos(m * psi)));
                    f.by_texel[size(k) * size(f.columns) + size(i)] = value;
                    f.by_order[size(i) * size(K_padded_) + size(k)] = value;
                }
            }
            folds_.push_back(std::move(f));
        }
}

inline void RingFourier::fold(const Fold& f, const float* planar, float* folded) const {
    if (quarters_) {
        const float b = f.sign_b, c = f.sign_b * f.sign_d, d = f.sign_d;
        const float *B = planar + W_ / 2 - 1, *C = planar + W_ / 2, *D = planar + W_ - 1;
        for (int k = 0; k < K_; ++k) folded[k] = (planar[k] + d * D[-k]) + (b * B[-k] + c * C[k]);
    } else {
        const float* D = planar + W_ - 1;
        for (int k = 0; k < K_; ++k) folded[k] = planar[k] + f.sign_d * D[-k];
    }
    // A texel on the fold is its own mirror image and was counted twice.
    if (W_ % 4 != 0) folded[K_ - 1] /= 2;
}

inline void RingFourier::unfold(const float* const* parts, float* ring) const {
    if (quarters_) {
        const float *ce = parts[0], *co = parts[1], *se = parts[2], *so = parts[3];
        float *B = ring + W_ / 2 - 1, *C = ring + W_ / 2, *D = ring + W_ - 1;
        for (int k = 0; k < K_; ++k) ring[k] = (ce[k] + co[k]) + (se[k] + so[k]);
        for (int k = 0; k < K_; ++k) B[-k] = (ce[k] - co[k]) - (se[k] - so[k]);
        for (int k = 0; k < K_; ++k) C[k] = (ce[k] - co[k]) + (se[k] - so[k]);
        for (int k = 0; k < K_; ++k) D[-k] = (ce[k] + co[k]) - (se[k] + so[k]);
    } else {
        for (int k = 0; k < K_; ++k) ring[k] = parts[0][k] + parts[1][k];
        for (int k = 0; k < K_; ++k) ring[W_ - 1 - k] = parts[0][k] - parts[1][k];
    }
}

void RingFourier::analyse(const float* ring, int channels, Texel texel, double* modes,
                          std::vector<float>& scratch) const {
    scratch.resize(size(channels) * size(W_ + K_));
    float* planar = scratch.data();
    float* folded = planar + size(channels) * size(W_);
    for (int c = 0; c < channels; ++c)
        for (int j = 0; j < W_; ++j)
            planar[size(c) * size(W_) + size(j)] = ring[size(j) * size(channels) + size(c)];

    const std::vector<double>& weight = texel == Texel::area ? weight_area_ : weight_sample_;
    for (const Fold& f : folds_) {
        for (int c = 0; c < channels; ++c) fold(f, planar + size(c) * size(W_), folded + size(c) * size(K_));
        for (int i0 = 0; i0 < f.columns; i0 += 8)
            for (int c0 = 0; c0 < channels; c0 += 3) {
                const int rows = std::min(3, channels - c0);
                const float* first = folded + size(c0) * size(K_);
                const float* table = f.by_texel.data() + i0;
                double products[24] = {};
                if (rows == 3)
                    analysis_product<3>(first, K_, table, f.columns, products);
                else if (rows == 2)
                    analysis_product<2>(first, K_, table, f.columns, products);
                else
                    analysis_product<1>(first, K_, table, f.columns, products);
                const int columns = std::min(8, static_cast<int>(f.orders.size()) - i0);
                for (int r = 0; r < rows; ++r)
                    for (int i = 0; i < columns; ++i) {
                        const std::size_t m = size(f.orders[size(i0 + i)]);
                        modes[(size(c0 + r) * 2 + f.sine) * size(max_order_ + 1) + m] =
                            weight[m] * products[r * 8 + i];
                    }
            }
    }
}

void RingFourier::synthesise(const float* modes, int channels, int stride, float* ring,
                             std::vector<float>& scratch) const {
    constexpr int R = 4;  // channels at a time
    scratch.resize(size(4 * R) * size(K_padded_));
    for (int c0 = 0; c0 < channels; c0 += R) {
        for (std::size_t t = 0; t < folds_.size(); ++t) {
            const Fold& f = folds_[t];
            for (int k = 0; k < K_padded_; k += 16) {
                f8 sums[R][2] = {};
                for (std::size_t i = 0; i < f.orders.size(); ++i) {
                    const float* h = modes + (size(f.orders[i]) * 2 + f.sine) * size(stride) + c0;
                    const float* table = f.by_order.data() + i * size(K_padded_) + k;
                    const f8 t0 = *reinterpret_cast<const f8u*>(table);
                    const f8 t1 = *reinterpret_cast<const f8u*>(table + 8);
                    for (int r = 0; r < R; ++r) {
                        sums[r][0] += h[r] * t0;
                        sums[r][1] += h[r] * t1;
                    }
                }
                for (int r = 0; r < R; ++r) {
                    float* part = scratch.data() + (size(r) * 4 + t) * size(K_padded_) + k;
                    *reinterpret_cast<f8u*>(part) = sums[r][0];
                    *reinterpret_cast<f8u*>(part + 8) = sums[r][1];
                }
            }
        }
        for (int r = 0; r < std::min(R, channels - c0); ++r) {
            const float* parts[4];
            for (int t = 0; t < 4; ++t) parts[t] = scratch.data() + size(r * 4 + t) * size(K_padded_);
            unfold(parts, ring + size(c0 + r) * size(W_));
        }
    }
}

}  // namespace shrm
