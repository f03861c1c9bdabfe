// Wigner's small-d and Clebsch-Gordan coefficients [VMK88].
#pragma once

#include <vector>

#include "shrm/core.hpp"

namespace shrm {

// d^l_{mq}(alpha) for rising l at fixed m and q: the three-term recurrence in l [VMK88 4.8], in float64
// (1e-15; near the poles 1e-12). It starts at l = max(|m|, |q|) from a product of half-angle cosines and
// sines.
class WignerRecurrence {
  public:
    WignerRecurrence(int m, int q, int F);

    int first_degree() const { return first_; }
    // d at the first degree
    double start(double cos_half, double sin_half) const;
    // d^{l+1} = (a x + b) d^l - c d^{l-1} with x = cos(alpha)
    struct Step {
        double a, b, c;
    };
    const Step& step(int l) const { return steps_[size(l - first_)]; }

  private:
    int first_, cos_power_, sin_power_;
    double start_;
    std::vector<Step> steps_;
};

// <l m p mu | j m+mu> by Racah's sum [VMK88 8.2] with a table of log n!. Its terms alternate and cancel: for
// l <= 120 the absolute error is about 2e-12 for p <= 8, 2e-10 for p = 16 and 5e-9 for p = 24.
class ClebschGordan {
  public:
    explicit ClebschGordan(int max_sum);  // l + p + j + 1 <= max_sum
    double operator()(int l, int m, int p, int mu, int j) const;

  private:
    double log_factorial(int n) const { return log_factorial_[size(n)]; }
    std::vector<double> log_factorial_;
};

}  // namespace shrm
