// f_lm(theta), the theta part of Y_lm with the Condon-Shortley phase, by the three-term recurrence in l in
// float64. Orthonormal to l^2 times the rounding error, to l = 1000. Values below 1e-300 flush to zero: where
// that happens, near the poles at high order, f_lm stays below 1e-100 for all degrees in use.
#pragma once

#include <cmath>
#include <vector>

#include "shrm/core.hpp"

namespace shrm {

// The constants of the recurrence f_{l+1,m} = a x f_lm - b f_{l-1,m} for all orders up to F.
class LegendreRecurrence {
  public:
    explicit LegendreRecurrence(int F) : F_(F), start_(size(F) + 1), steps_(triangle(F + 1)) {
        start_[0] = std::sqrt(1 / (4 * pi));
        for (int m = 1; m <= F; ++m)
            start_[size(m)] = -start_[size(m - 1)] * std::sqrt((2 * m + 1) / (2.0 * m));
        for (int m = 0; m <= F; ++m) {
            double previous = 0;
            for (int l = m; l <= F; ++l) {
                const double up = l + 1.0, m2 = double(m) * m;
                const double a = std::sqrt((4 * up * up - 1) / (up * up - m2));
                steps_[triangle(m) + offset(l, m)] = {a, l > m ? a / previous : 0};
                previous = a;
            }
        }
    }

    struct Step {
        double a, b;
    };
    // f_mm(theta) = start(m) sin(theta)^m
    double start(int m) const { return start_[size(m)]; }
    // from degree l to l + 1 at order m
    const Step* steps(int m) const { return &steps_[triangle(m)]; }

  private:
    static std::size_t offset(int l, int m) { return size(l - m); }
    std::size_t triangle(int m) const { return size(m) * size(2 * F_ + 3 - m) / 2; }
    int F_;
    std::vector<double> start_;
    std::vector<Step> steps_;
};

// x^n by squaring.
inline double power(double x, int n) {
    double result = 1;
    for (; n; n >>= 1, x *= x)
        if (n & 1) result *= x;
    return result;
}

}  // namespace shrm
