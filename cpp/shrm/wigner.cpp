#include "shrm/wigner.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <utility>

#include "shrm/legendre.hpp"

namespace shrm {
namespace {}  // namespace

WignerRecurrence::WignerRecurrence(int m, int q, int F) : first_(std::max(std::abs(m), std::abs(q))) {
    // d^j_{jk} = sqrt(C(2j, j+k)) cos^{j+k} (-sin)^{j-k} of the half angle; the other edges of the matrix by
    // d_{mq} = (-1)^{m-q} d_{qm} = (-1)^{m-q} d_{-m,-q}.
    const int j = first_;
    int k = 0, sign_power = 0;
    if (m == j)
        k = q, sign_power = j - k;
    else if (m == -j)
        k = -q, sign_power = 0;
    else if (q == j)
        k = m, sign_power = 0;
    else
        k = -m, sign_power = j - k;
    cos_power_ = j + k;
    sin_power_ = j - k;
    double binomial = 1;
    for (int i = 1; i <= j - std::abs(k); ++i) binomial *= std::sqrt((2.0 * j - (j - std::abs(k)) + i) / i);
    start_ = sign_power % 2 ? -binomial : binomial;

    for (int l = first_; l < F; ++l) {
        const double up = l + 1.0, m2 = double(m) * m, q2 = double(q) * q, l2 = double(l) * l;
        const double norm = up / std::sqrt((up * up - m2) * (up * up - q2));
        steps_.push_back({norm * (2 * l + 1), l ? -norm * (2 * l + 1) * m * q / (l * up) : 0,
                          l ? norm * std::sqrt((l2 - m2) * (l2 - q2)) / l : 0});
    }
}

double WignerRecurrence::start(double cos_half, double sin_half) const {
    return start_ * power(cos_half, cos_power_) * power(sin_half, sin_power_);
}

EulerAngles euler_angles(const glm::dmat3& R) {  // glm: R[column][row]
    const double sine = std::hypot(R[2][0], R[2][1]);
    if (sine < 1e-12)  // about z, or z turned over: only one angle is determined
        return {std::atan2(-R[1][0], R[1][1]), R[2][2] < 0 ? pi : 0, 0};
    return {std::atan2(R[2][1], R[2][0]), std::atan2(sine, R[2][2]), std::atan2(R[1][2], -R[0][2])};
}

void rotate(std::span<const double> coefficients, int channels, int F, const glm::dmat3& R,
            std::span<double> rotated) {
    using Complex = std::complex<double>;
    const auto [beta, alpha, gamma] = euler_angles(R);
    const double x = std::cos(alpha), cos_half = std::cos(alpha / 2), sin_half = std::sin(alpha / 2);
    const std::size_t n = size(channels);

    // sqrt2 e^{-i q gamma} c_lq for q > 0, and c_l0, with c_lq of the complex basis
    std::vector<Complex> turned(basis_size(F) * n);
    for (int l = 0; l <= F; ++l)
        for (int q = 0; q <= l; ++q)
            for (std::size_t c = 0; c < n; ++c) {
                const double plus = coefficients[lm(l, q) * n + c], minus = coefficients[lm(l, -q) * n + c];
                turned[lm(l, q) * n + c] =
                    q ? Complex(plus, -minus) * std::polar(1.0, -q * gamma) : Complex(plus, 0);
            }
#pragma omp parallel
    {
        std::vector<Complex> sums;
#pragma omp for schedule(dynamic)
        for (int m = 0; m <= F; ++m) {
            sums.assign(size(F + 1) * n, 0);
            for (int q = 0; q <= F; ++q) {
                const WignerRecurrence plus(m, q, F), minus(m, -q, F);
                double d = plus.start(cos_half, sin_half), e = minus.start(cos_half, sin_half), d0 = 0,
                       e0 = 0;
                const double sign = q % 2 ? -1 : 1;
                for (int l = plus.first_degree(); l <= F; ++l) {
                    // the terms of q and -q at once, c_{l,-q} = (-1)^q conj(c_lq); sums are c'_lm / sqrt2
                    const double re = q ? (d + sign * e) / 2 : d / std::numbers::sqrt2,
                                 im = q ? (d - sign * e) / 2 : 0;
                    for (std::size_t c = 0; c < n; ++c) {
                        const Complex t = turned[lm(l, q) * n + c];
                        sums[size(l) * n + c] += Complex(re * t.real(), im * t.imag());
                    }
                    if (l == F) break;
                    const auto [a, b, back] = plus.step(l);
                    d0 = std::exchange(d, (a * x + b) * d - back * d0);
                    e0 = std::exchange(e, (a * x - b) * e - back * e0);
                }
            }
            for (int l = m; l <= F; ++l)
                for (std::size_t c = 0; c < n; ++c) {
                    const Complex s = sums[size(l) * n + c] * std::polar(std::numbers::sqrt2, -m * beta);
                    rotated[lm(l, m) * n + c] = m ? s.real() * std::numbers::sqrt2 : s.real();
                    if (m) rotated[lm(l, -m) * n + c] = -s.imag() * std::numbers::sqrt2;
                }
        }
    }
}

ClebschGordan::ClebschGordan(int max_sum) : log_factorial_(size(max_sum) + 1, 0) {
    for (int n = 1; n <= max_sum; ++n) log_factorial_[size(n)] = log_factorial_[size(n - 1)] + std::log(n);
}

double ClebschGordan::operator()(int l, int m, int p, int mu, int j) const {
    const int k = m + mu;
    if (std::abs(m) > l || std::abs(mu) > p || std::abs(k) > j || j < std::abs(l - p) || j > l + p) return 0;
    const auto f = [this](int n) { return log_factorial(n); };
    const double norm = (std::log(2 * j + 1) + f(l + p - j) + f(l - p + j) + f(p + j - l) - f(l + p + j + 1) +
                         f(j + k) + f(j - k) + f(l - m) + f(l + m) + f(p - mu) + f(p + mu)) /
                        2;
    double sum = 0;
    const int last = std::min({l + p - j, l - m, p + mu});
    for (int z = std::max({0, p - m - j, l + mu - j}); z <= last; ++z) {
        const double term = std::exp(norm - f(z) - f(l + p - j - z) - f(l - m - z) - f(p + mu - z) -
                                     f(j - p + m + z) - f(j - l - mu + z));
        sum += z % 2 ? -term : term;
    }
    return sum;
}

}  // namespace shrm
