#include "shrm/sh/wigner.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "shrm/sh/legendre.hpp"

namespace shrm {
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
