#include "shrm/sh/rotation.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <complex>

#include "shrm/core.hpp"
#include "shrm/sh/legendre.hpp"
#include "shrm/simd/packs.hpp"

namespace shrm {
namespace {

using Complex = std::complex<double>;

constexpr int few_degrees = 16;  // which take less time than to wake threads

struct EulerAngles {
    double beta, alpha, gamma;
};

EulerAngles euler_angles(const glm::dmat3& R) {  // glm: R[column][row]
    const double sine = std::hypot(R[2][0], R[2][1]);
    if (sine < 1e-12)  // about z, or z turned over: only one angle is determined
        return {std::atan2(-R[1][0], R[1][1]), R[2][2] < 0 ? pi : 0, 0};
    return {std::atan2(R[2][1], R[2][0]), std::atan2(sine, R[2][2]), std::atan2(R[1][2], -R[0][2])};
}

}  // namespace

Rotation::Rotation(int F, int channels)
    : F_(F),
      channels_(channels),
      width_(round_up(F + 1, block)),
      root_(size(F + 2) * size(width_), 0.),
      inverse_root_(root_),
      binomial_(basis_size(F)),
      angle_{1, std::vector<double>(size(2 * F + 1)), std::vector<double>(size(2 * F + 1))},
      turned_(size(F + 1) * size(2 * channels * width_), 0.) {
    for (int l = 0; l <= F + 1; ++l)
        for (int q = 0; q < std::min(l, width_); ++q) {
            const double root = std::sqrt(double(l) * l - double(q) * q);
            root_[size(l * width_ + q)] = root;
            inverse_root_[size(l * width_ + q)] = 1 / root;
        }
    for (int j = 0; j <= F; ++j) {
        double* row = &binomial_[size(j) * size(F + 1)];
        row[j] = 1;
        for (int k = j; k > 0; --k) row[k - 1] = row[k] * std::sqrt((j + k) / (j - k + 1.0));
    }
}

// d^j_{mq} at j = max(m, |q|), m >= 0: sqrt(C(2j, j+k)) cos^{j+k} (-sin)^{j-k} of the half angle at (j, k);
// the other edges of the matrix by d_{mq} = (-1)^{m-q} d_{qm} = (-1)^{m-q} d_{-m,-q}.
double Rotation::start(int m, int q) const {
    const int j = std::max(m, std::abs(q));
    const int k = m >= std::abs(q) ? q : q > 0 ? m : -m;
    const bool negative = (j - k) % 2 != 0 && !(q > m);
    const double value = binomial_[size(j) * size(F_ + 1) + size(std::abs(k))] *
                         angle_.cos_powers[size(j + k)] * angle_.sin_powers[size(j - k)];
    return negative ? -value : value;
}

// The sums over q of one order m, the terms of q and -q at once, for `block` orders q at a time.
void Rotation::rotate_order(int m, const double* turned, double* sums) const {
    const int rows = 2 * channels_;
    std::fill_n(sums, size(F_ + 1) * size(rows * block), 0.);
    for (int q0 = 0; q0 <= F_; q0 += block) {
        // d of q and e of -q, the signs of (-1)^q.
        d8 d = {}, e = {}, before_d = {}, before_e = {}, sign, q;
        for (int i = 0; i < block; ++i) {
            sign[i] = i % 2 ? -1 : 1;
            q[i] = q0 + i;
        }
        for (int l = std::max(m, q0); l <= F_; ++l) {
            // The recurrence in l of order q begins at l = max(m, q).
            for (int i = 0; i < block; ++i)
                if (q0 + i <= F_ && l == std::max(m, q0 + i)) {
                    d[i] = start(m, q0 + i);
                    e[i] = start(m, -(q0 + i));
                }
            // c_{l,-q} = (-1)^q conj(c_lq); the sums are c'_lm / sqrt2
            d8 re = (d + sign * e) / 2, im = (d - sign * e) / 2;
            if (q0 == 0) {
                re[0] = d[0] / std::numbers::sqrt2;
                im[0] = 0;
            }
            const double* light = turned + size(l * rows) * size(width_) + q0;
            double* sum = sums + size(l * rows * block);
            for (int z = 0; z < rows; z += 2, light += 2 * width_, sum += 2 * block) {
                store(sum, load(sum) + re * load(light));
                store(sum + block, load(sum + block) + im * load(light + width_));
            }
            // d^{l+1} = (a x + b) d^l - c d^{l-1}   [VMK88 4.8]
            const std::size_t up = size((l + 1) * width_), here = size(l * width_);
            const double norm = (l + 1) * inverse_root_[up + size(m)], over_l = l ? 1.0 / l : 0;
            const d8 scale = norm * load(&inverse_root_[up + size(q0)]);
            const d8 a_x = scale * ((2 * l + 1) * angle_.x);
            const d8 b = scale * ((2 * l + 1) * m * over_l / (l + 1)) * q;
            const d8 c = scale * (root_[here + size(m)] * over_l) * load(&root_[here + size(q0)]);
            const d8 next_d = (a_x - b) * d - c * before_d, next_e = (a_x + b) * e - c * before_e;
            before_d = d;
            before_e = e;
            d = next_d;
            e = next_e;
        }
    }
}

void Rotation::run(std::span<const double> coefficients, const glm::dmat3& R, std::span<double> rotated) {
    if (sums_.size() < size(omp_get_max_threads())) sums_.resize(size(omp_get_max_threads()));
    // Powers of the half angle's cosine and sine, with which the recurrences start.
    const auto [beta, alpha, gamma] = euler_angles(R);
    const std::size_t n = size(channels_), width = size(width_);
    angle_.x = std::cos(alpha);
    for (int i = 0; i <= 2 * F_; ++i) {
        angle_.cos_powers[size(i)] = power(std::cos(alpha / 2), i);
        angle_.sin_powers[size(i)] = power(std::sin(alpha / 2), i);
    }
#pragma omp parallel if (F_ > few_degrees)
    {
        std::vector<double>& sums = sums_[size(omp_get_thread_num())];
        sums.resize(size(F_ + 1) * 2 * n * block);
        // sqrt2 e^{-i q gamma} c_lq for q > 0, and c_l0, with c_lq of the complex basis
#pragma omp for schedule(static)
        for (int q = 0; q <= F_; ++q) {
            const Complex turn = std::polar(1.0, -q * gamma);
            for (int l = q; l <= F_; ++l)
                for (std::size_t c = 0; c < n; ++c) {
                    const double plus = coefficients[lm(l, q) * n + c],
                                 minus = coefficients[lm(l, -q) * n + c];
                    const Complex value = q ? Complex(plus, -minus) * turn : Complex(plus, 0);
                    double* to = &turned_[(size(l) * n + c) * 2 * width + size(q)];
                    to[0] = value.real();
                    to[width] = value.imag();
                }
        }
        // e^{-i m beta} times the sums over q, back in the real basis.
#pragma omp for schedule(dynamic)
        for (int m = 0; m <= F_; ++m) {
            rotate_order(m, turned_.data(), sums.data());
            const Complex turn = std::polar(std::numbers::sqrt2, -m * beta);
            for (int l = m; l <= F_; ++l)
                for (std::size_t c = 0; c < n; ++c) {
                    const double* of = &sums[(size(l) * n + c) * 2 * block];
                    Complex sum = 0;
                    for (int i = 0; i < block; ++i) sum += Complex(of[i], of[block + i]);
                    const Complex s = sum * turn;
                    rotated[lm(l, m) * n + c] = m ? s.real() * std::numbers::sqrt2 : s.real();
                    if (m) rotated[lm(l, -m) * n + c] = -s.imag() * std::numbers::sqrt2;
                }
        }
    }
}

}  // namespace shrm
