#include "shrm/sh/ring_fourier.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "shrm/core.hpp"
#include "shrm/simd/shuffles.hpp"
#include "shrm/simd/stream.hpp"
#include "shrm/simd/vectors.hpp"

namespace shrm {
namespace {

// modes(r, j) = sum over k of rows(r, k) table(k, j), for V vectors of columns j. At most 256 texels are
// added up one by one, then those sums: rounding grows with the root of 256, not of W. Each product of a row
// takes its texel straight from memory, so that the two loads a cycle feed the two units that multiply.
template <int R, int V>
SHRM_KERNEL inline void analysis_product(const float* rows, int row_pitch, int K, const float* table,
                                         int columns, float* modes, int mode_pitch) {
    constexpr int block = 256;
    for (int k0 = 0; k0 < K; k0 += block) {
        Floats sums[R][V] = {};
        const int end = std::min(K, k0 + block);
        for (int k = k0; k < end; ++k) {
            Floats t[V];
            unrolled<V>([&](auto v) {
                t[v] = load(table + size(k) * size(columns) + v * lanes);
                keep(t[v]);
            });
            unrolled<R>([&](auto r) {
                const float texel = rows[size(r) * size(row_pitch) + size(k)];
                unrolled<V>([&](auto v) { sums[r][v] += texel * t[v]; });
            });
        }
        unrolled<R>([&](auto r) {
            unrolled<V>([&](auto v) {
                float* to = modes + size(r) * size(mode_pitch) + v * lanes;
                store(to, k0 == 0 ? sums[r][v] : load(to) + sums[r][v]);
            });
        });
    }
}

// Sums that fit the registers beside the V vectors of the table.
constexpr int rows_at_once(int V) {
    return V == 1 || vector_registers >= 32 ? 12 : 6;
}

template <int V>
inline void analysis_rows(const float* rows, int count, int row_pitch, int K, const float* table, int columns,
                          float* modes, int mode_pitch) {
    constexpr int R = rows_at_once(V);
    for (int r = 0; r < count; r += R)
        analysis_product<R, V>(rows + size(r) * size(row_pitch), row_pitch, K, table, columns,
                               modes + size(r) * size(mode_pitch), mode_pitch);
}

}  // namespace

RingFourier::RingFourier(int W, int max_order)
    : W_(W),
      quarters_(W % 2 == 0),
      K_(quarters_ ? (W + 2) / 4 : (W + 1) / 2),
      K_padded_(round_up(K_, 2 * lanes)),
      mode_pitch_(0) {
    const double step = 2 * pi / W;
    for (bool sine : {false, true})
        for (int parity = 0; parity < order_step(); ++parity) {
            Fold f;
            f.sine = sine;
            f.sign_b = sine != (parity == 1) ? -1.f : 1.f;
            f.sign_d = sine ? -1.f : 1.f;
            f.first = parity;
            f.orders = max_order < parity ? 0 : (max_order - parity) / order_step() + 1;
            f.columns = round_up(f.orders, lanes);
            f.first_mode = mode_pitch_;
            mode_pitch_ += f.columns;
            f.by_texel.assign(size(K_) * size(f.columns), 0);
            f.by_order.assign(size(f.orders) * size(K_padded_), 0);
            for (int i = 0; i < f.orders; ++i) {
                // phi = pi - psi: cos(m phi) = (-1)^m cos(m psi), sin(m phi) = -(-1)^m sin(m psi)
                const int m = f.first + i * order_step();
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

std::size_t RingFourier::mode_at(bool sine, int m) const {
    const Fold& f = folds_[size(sine * order_step() + m % order_step())];
    return size(f.first_mode + m / order_step());
}

// One row of the circle to the folds, [fold] -> (K).
inline void RingFourier::fold_row(const float* planar, float* const* folded) const {
    const float *B = planar + W_ / 2 - 1, *C = planar + W_ / 2, *D = planar + W_ - 1;
    const auto quarters = [&](int k, auto a, auto b, auto c, auto d, const auto& put) {
        put(folded[0] + k, (a + d) + (b + c));
        put(folded[1] + k, (a + d) - (b + c));
        put(folded[2] + k, (a - d) - (b - c));
        put(folded[3] + k, (a - d) + (b - c));
    };
    const auto halves = [&](int k, auto a, auto d, const auto& put) {
        put(folded[0] + k, a + d);
        put(folded[1] + k, a - d);
    };
    const auto put_vector = [](float* to, Floats v) { store(to, v); };
    const auto put_one = [](float* to, float v) { *to = v; };
    const auto before = [](const float* last) { return reversed(load(last - (lanes - 1))); };
    int k = 0;
    for (; k + lanes <= K_; k += lanes)
        if (quarters_)
            quarters(k, load(planar + k), before(B - k), load(C + k), before(D - k), put_vector);
        else
            halves(k, load(planar + k), before(D - k), put_vector);
    for (; k < K_; ++k)
        if (quarters_)
            quarters(k, planar[k], B[-k], C[k], D[-k], put_one);
        else
            halves(k, planar[k], D[-k], put_one);
    // A texel on the fold is its own mirror image and was counted twice.
    if (W_ % 4 != 0)
        for (std::size_t t = 0; t < folds_.size(); ++t) folded[t][K_ - 1] /= 2;
}

void RingFourier::fold(const float* planar, int count, int first, int rows, float* folded) const {
    const std::size_t plane = size(rows) * size(K_padded_);
    for (int r = 0; r < count; ++r) {
        float* parts[4];
        for (std::size_t t = 0; t < folds_.size(); ++t)
            parts[t] = folded + t * plane + size(first + r) * size(K_padded_);
        fold_row(planar + size(r) * size(W_), parts);
    }
}

// Quarters of rings that come from memory are read more slowly, backwards two of them, than rings in order.
inline constexpr int held_in_cache = 24 << 10;  // bytes, of the first cache

bool RingFourier::fold_pair_serves() const {
    return W_ % (4 * lanes) == 0 && 2 * 3 * W_ * int(sizeof(float)) <= held_in_cache;
}

SHRM_KERNEL void RingFourier::fold_pair(const float* north, const float* south, int first, int rows,
                                        float* folded) const {
    const std::size_t plane = size(rows) * size(K_padded_);
    float* const to = folded + size(first) * size(K_padded_);
    for (int k = 0; k < K_; k += lanes) {
        // The places of the quarters, as in fold_row; the second and the fourth run backwards.
        const int at[4] = {k, W_ / 2 - k - lanes, W_ / 2 + k, W_ - k - lanes};
        Floats a[6], b[6], c[6], d[6];
        sum_and_difference<false>(north + 3 * at[0], south + 3 * at[0], a);
        sum_and_difference<true>(north + 3 * at[3], south + 3 * at[3], d);
        unrolled<6>([&](auto r) {
            const Floats sum = a[r] + d[r];
            d[r] = a[r] - d[r];
            a[r] = sum;
        });
        sum_and_difference<true>(north + 3 * at[1], south + 3 * at[1], b);
        sum_and_difference<false>(north + 3 * at[2], south + 3 * at[2], c);
        unrolled<6>([&](auto r) {
            const Floats sum = b[r] + c[r], difference = b[r] - c[r];
            float* const place = to + r * K_padded_ + k;
            store(place, a[r] + sum);
            store(place + plane, a[r] - sum);
            store(place + 2 * plane, d[r] - difference);
            store(place + 3 * plane, d[r] + difference);
        });
    }
}

void RingFourier::analyse(const float* folded, int rows, float* modes) const {
    const std::size_t plane = size(rows) * size(K_padded_);
    for (std::size_t t = 0; t < folds_.size(); ++t) {
        const Fold& f = folds_[t];
        int j = 0;
        for (; j + 2 * lanes <= f.columns; j += 2 * lanes)
            analysis_rows<2>(folded + t * plane, rows, K_padded_, K_, f.by_texel.data() + j, f.columns,
                             modes + f.first_mode + j, mode_pitch_);
        for (; j < f.columns; j += lanes)
            analysis_rows<1>(folded + t * plane, rows, K_padded_, K_, f.by_texel.data() + j, f.columns,
                             modes + f.first_mode + j, mode_pitch_);
    }
}

namespace {

// A vector of folded texels k.. to its place; the last may hang over the quarter's end.
inline void store_forward(float* to, Floats v, int count) {
    if (count >= lanes)
        store(to, v);
    else
        for (int i = 0; i < count; ++i) to[i] = v[i];
}

inline void store_backward(float* last, Floats v, int count) {
    if (count >= lanes)
        store(last - (lanes - 1), reversed(v));
    else
        for (int i = 0; i < count; ++i) last[-i] = v[i];
}

// Vectors of texels at once: what the registers hold of 4 folds and 3 channels.
inline constexpr int synthesis_vectors = vector_registers >= 32 ? 2 : 1;

}  // namespace

template <int Folds, int Channels>
SHRM_KERNEL inline void RingFourier::synthesise_channels(const float* modes, int channels, int stride,
                                                         float* const* rings) const {
    constexpr int V = synthesis_vectors;
    const std::ptrdiff_t step = std::ptrdiff_t(order_step()) * stride;
    // The folds have as many orders each, or one more where they are even.
    const int common = folds_[size(order_step() - 1)].orders;
    for (int k = 0; k < K_; k += V * lanes) {
        // Each fold's modes and rows of cosines or sines.
        const float *h[Folds], *table[Folds];
        for (int t = 0; t < Folds; ++t) {
            const Fold& f = folds_[size(t)];
            h[t] = modes + f.first * stride + (f.sine ? channels : 0);
            table[t] = f.by_order.data() + k;
        }
        // The sums over orders, of all folds at once.
        Floats sums[Folds][Channels][V] = {};
        const auto add = [&](auto t) {
            unrolled<V>([&](auto v) {
                Floats row = load(table[t] + v * lanes);
                keep(row);
                unrolled<Channels>([&](auto c) { sums[t][c][v] += h[t][c] * row; });
            });
            table[t] += K_padded_;
            h[t] += step;
        };
        for (int i = 0; i < common; ++i) unrolled<Folds>(add);
        unrolled<Folds>([&](auto t) {
            if (folds_[size(t)].orders > common) add(t);
        });

        // Unfolded: sums and differences of folds are texels of the ring's halves or quarters.
        unrolled<Channels>([&](auto c) {
            unrolled<V>([&](auto v) {
                const int at = k + v * lanes, count = K_ - at;
                float* ring = rings[c];
                if constexpr (Folds == 4) {
                    const Floats even = sums[0][c][v] + sums[2][c][v], odd = sums[1][c][v] + sums[3][c][v],
                                 even_d = sums[0][c][v] - sums[2][c][v],
                                 odd_d = sums[1][c][v] - sums[3][c][v];
                    store_forward(ring + at, even + odd, count);
                    store_backward(ring + W_ / 2 - 1 - at, even_d - odd_d, count);
                    store_forward(ring + W_ / 2 + at, even - odd, count);
                    store_backward(ring + W_ - 1 - at, even_d + odd_d, count);
                } else {
                    store_forward(ring + at, sums[0][c][v] + sums[1][c][v], count);
                    store_backward(ring + W_ - 1 - at, sums[0][c][v] - sums[1][c][v], count);
                }
            });
        });
    }
}

void RingFourier::synthesise(const float* modes, int channels, int stride, float* ring,
                             float* through) const {
    for (int c = 0; c < channels; c += 3) {
        float *const place = ring + size(c) * size(W_), *const made = through ? through : place;
        float* rings[3];
        for (int i = 0; i < 3; ++i) rings[i] = made + size(i) * size(W_);
        const int count = std::min(3, channels - c);
        const auto run = [&]<int Folds>() {
            if (count == 3)
                synthesise_channels<Folds, 3>(modes + c, channels, stride, rings);
            else if (count == 2)
                synthesise_channels<Folds, 2>(modes + c, channels, stride, rings);
            else
                synthesise_channels<Folds, 1>(modes + c, channels, stride, rings);
        };
        if (quarters_)
            run.template operator()<4>();
        else
            run.template operator()<2>();
        if (through) stream(through, count * W_, place);
    }
}

}  // namespace shrm
