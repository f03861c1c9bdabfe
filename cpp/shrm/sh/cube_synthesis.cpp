#include "shrm/sh/cube_synthesis.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "shrm/core.hpp"
#include "shrm/pictures/cube.hpp"
#include "shrm/simd/shuffles.hpp"
#include "shrm/simd/vectors.hpp"

namespace shrm {
namespace {

constexpr int vectors = 2;  // of texels to a task
constexpr int channel_block = vector_registers >= 32 ? 12 : 6;

// The class of Y_lm: bit 0, 1, 2 where it is odd in x, y, z. In x, phi becomes pi - phi; in y, -phi; in z,
// theta becomes pi - theta.
constexpr int mirror_class(int l, int m) {
    const bool sine = m < 0, odd_order = m % 2 != 0, odd_in_z = (l + m) % 2 != 0;
    return int(sine != odd_order) + 2 * int(sine) + 4 * int(odd_in_z);
}

int signs(const glm::dvec3& d) {
    return int(d.x < 0) + 2 * int(d.y < 0) + 4 * int(d.z < 0);
}

// sums(c, v) = sum over the terms of coefficients(term, c) basis(term, v).
template <int C>
SHRM_KERNEL inline void class_product(const float* coefficients, int channels, const float* basis,
                                      std::size_t terms, float* sums) {
    Floats of[C][vectors] = {};
    for (std::size_t k = 0; k < terms; ++k) {
        Floats b[vectors];
        unrolled<vectors>([&](auto v) {
            b[v] = load(basis + (k * vectors + size(v)) * lanes);
            keep(b[v]);
        });
        unrolled<C>([&](auto c) {
            const float coefficient = coefficients[k * size(channels) + size(c)];
            unrolled<vectors>([&](auto v) { of[c][v] += coefficient * b[v]; });
        });
    }
    unrolled<C>([&](auto c) {
        unrolled<vectors>([&](auto v) { store(sums + (c * vectors + v) * lanes, of[c][v]); });
    });
}

// From the sums of the classes to the values at the eight images: value(s) = sum over k of
// (-1)^{bits in both s and k} sum(k), by three rounds of sums and differences.
inline void mirror(Floats* v) {
    for (int bit = 1; bit < 8; bit *= 2)
        for (int k = 0; k < 8; ++k)
            if (!(k & bit)) {
                const Floats even = v[k], odd = v[k | bit];
                v[k] = even + odd;
                v[k | bit] = even - odd;
            }
}

}  // namespace

CubeSynthesis::CubeSynthesis(int N, int channels, int F)
    : side_(N + 2 * cube_border),
      channels_(channels),
      F_(F),
      texels_(vectors * lanes),
      recurrence_(F),
      first_term_{},
      term_(basis_size(F)),
      ordered_(basis_size(F) * size(channels)) {
    // The terms of each class, in the order in which basis() comes by them.
    const auto each_term = [F](const auto& visit) {
        for (int m = 0; m <= F; ++m)
            for (int l = m; l <= F; ++l) {
                visit(l, m);
                if (m > 0) visit(l, -m);
            }
    };
    each_term([&](int l, int m) { ++first_term_[size(mirror_class(l, m)) + 1]; });
    for (std::size_t k = 0; k < classes; ++k) first_term_[k + 1] += first_term_[k];
    auto next = first_term_;
    each_term([&](int l, int m) { term_[next[size(mirror_class(l, m))]++] = static_cast<int>(lm(l, m)); });

    // The octant's texels: of each pair of opposite faces a quarter of one, row by row.
    const int half = side_ / 2;
    const auto at = [this](int face, int row, int column) {
        const auto centered = [this](int i) { return (2.0 * i + 1 - side_) / (side_ - 2 * cube_border); };
        return cube_direction(face, centered(column), centered(row));
    };
    for (int face = 0; face < 6; face += 2)
        for (int row = half; row < side_; ++row)
            for (int column = half; column < side_;) {
                const int used = static_cast<int>(directions_.size()) % texels_;
                if (used == 0) segments_.emplace_back();
                Segment segment{used, std::min(texels_ - used, side_ - column), {}, {}, {}};
                for (int opposite = 0; opposite < 2; ++opposite)
                    for (int r : {row, side_ - 1 - row})
                        for (int c : {column, side_ - 1 - column}) {
                            const std::size_t image = size(signs(at(face + opposite, r, c)));
                            segment.row[image] = (face + opposite) * side_ + r;
                            segment.column[image] = c;
                            segment.step[image] = c == column ? 1 : -1;
                        }
                segments_.back().push_back(segment);
                for (int i = 0; i < segment.count; ++i)
                    directions_.push_back(glm::abs(glm::normalize(at(face, row, column + i))));
                column += segment.count;
            }
    directions_.resize(segments_.size() * size(texels_), glm::dvec3(0, 0, 1));
}

// Y_lm at the texels of a task: values (term, texel).
void CubeSynthesis::basis(std::size_t task, float* values) const {
    constexpr int n = vectors * lanes;
    double x[n], sine[n], cos1[n], sin1[n], cos_m[n], sin_m[n];
    for (int i = 0; i < n; ++i) {
        const glm::dvec3& d = directions_[task * n + size(i)];
        x[i] = d.z;
        sine[i] = std::sqrt(d.x * d.x + d.y * d.y);
        cos1[i] = sine[i] > 0 ? d.x / sine[i] : 1;
        sin1[i] = sine[i] > 0 ? d.y / sine[i] : 0;
        cos_m[i] = 1;
        sin_m[i] = 0;
    }
    std::array<std::size_t, classes + 1> next = first_term_;
    for (int m = 0; m <= F_; ++m) {
        double f[n], previous[n] = {};
        const double norm = m ? std::numbers::sqrt2 : 1;
        for (int i = 0; i < n; ++i) f[i] = norm * recurrence_.start(m) * power(sine[i], m);
        for (int l = m; l <= F_; ++l) {
            float* cosine = values + next[size(mirror_class(l, m))]++ * n;
            for (int i = 0; i < n; ++i) cosine[i] = static_cast<float>(f[i] * cos_m[i]);
            if (m > 0) {
                float* of_sine = values + next[size(mirror_class(l, -m))]++ * n;
                for (int i = 0; i < n; ++i) of_sine[i] = static_cast<float>(f[i] * sin_m[i]);
            }
            const auto [a, b] = recurrence_.steps(m)[l - m];
            for (int i = 0; i < n; ++i) {
                const double up = a * x[i] * f[i] - b * previous[i];
                previous[i] = f[i];
                f[i] = up;
            }
        }
        for (int i = 0; i < n; ++i) {
            const double turned = cos_m[i] * cos1[i] - sin_m[i] * sin1[i];
            sin_m[i] = sin_m[i] * cos1[i] + cos_m[i] * sin1[i];
            cos_m[i] = turned;
        }
    }
}

// The eight images of a task's texels, for `channels` channels from `channel` on.
//   sums (class, channel_block, texel)
void CubeSynthesis::store_images(std::size_t task, int channel, int channels, const float* sums,
                                 float* rings) const {
    constexpr int n = vectors * lanes;
    for (int c = 0; c < channels; ++c) {
        float images[classes][n];
        for (int v = 0; v < vectors; ++v) {
            Floats of[classes];
            for (int k = 0; k < classes; ++k)
                of[k] = load(sums + ((k * channel_block + c) * vectors + v) * lanes);
            mirror(of);
            for (int k = 0; k < classes; ++k) store(images[k] + v * lanes, of[k]);
        }
        for (const Segment& s : segments_[task])
            for (std::size_t k = 0; k < classes; ++k) {
                float* to = rings + (size(s.row[k]) * size(channels_) + size(channel + c)) * size(side_) +
                            s.column[k];
                const float* from = images[k] + s.first;
                int i = 0;
                for (; i + lanes <= s.count; i += lanes)
                    if (s.step[k] > 0)
                        store(to + i, load(from + i));
                    else
                        store(to - i - (lanes - 1), reversed(load(from + i)));
                for (; i < s.count; ++i) to[s.step[k] * i] = from[i];
            }
    }
}

void CubeSynthesis::run(std::span<const double> coefficients, std::span<float> rings) {
    if (scratch_.size() < size(omp_get_max_threads())) scratch_.resize(size(omp_get_max_threads()));
    const std::size_t n = size(channels_);
#pragma omp parallel
    {
        Scratch& scratch = scratch_[size(omp_get_thread_num())];
        scratch.sums.resize(size(classes * channel_block * texels_));
        scratch.basis.resize(basis_size(F_) * size(texels_));
#pragma omp for schedule(static)
        for (std::size_t k = 0; k < term_.size(); ++k)
            for (std::size_t c = 0; c < n; ++c)
                ordered_[k * n + c] = static_cast<float>(coefficients[size(term_[k]) * n + c]);
#pragma omp for schedule(dynamic)
        for (std::size_t task = 0; task < segments_.size(); ++task) {
            basis(task, scratch.basis.data());
            for (int channel = 0; channel < channels_; channel += channel_block) {
                const int count = std::min(channel_block, channels_ - channel);
                for (std::size_t k = 0; k < classes; ++k) {
                    const std::size_t first = first_term_[k], terms = first_term_[k + 1] - first;
                    int c = 0;
                    const auto add = [&]<int C>() {
                        for (; c + C <= count; c += C)
                            class_product<C>(ordered_.data() + first * n + size(channel + c), channels_,
                                             scratch.basis.data() + first * size(texels_), terms,
                                             &scratch.sums[(k * channel_block + size(c)) * size(texels_)]);
                    };
                    add.template operator()<channel_block>();
                    add.template operator()<3>();
                    add.template operator()<1>();
                }
                store_images(task, channel, count, scratch.sums.data(), rings.data());
            }
        }
    }
}

}  // namespace shrm
