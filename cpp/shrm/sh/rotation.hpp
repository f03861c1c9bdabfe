// Rotation of spherical harmonic coefficients: c'_lm = sum_q e^{-i m beta} d^l_{mq}(alpha) e^{-i q gamma}
// c_lq for R = R_z(beta) R_y(alpha) R_z(gamma) [VMK88 4.1].
#pragma once

#include <span>
#include <vector>

#include <glm/mat3x3.hpp>

namespace shrm {

// Rotation of coefficients up to one degree: the tables that depend on it alone, and the memory to work in.
// Repeated runs allocate nothing, and go one after the other.
class Rotation {
  public:
    Rotation(int F, int channels);

    // The coefficients of L(R^T w).
    //   coefficients and rotated ((F+1)^2, channels), real basis
    void run(std::span<const double> coefficients, const glm::dmat3& R, std::span<double> rotated);

  private:
    static constexpr int block = 8;  // orders q at once
    struct Angle {
        double x;                                    // cos(alpha)
        std::vector<double> cos_powers, sin_powers;  // of alpha / 2, to 2 F
    };
    void rotate_order(int m, const double* turned, double* sums) const;
    double start(int m, int q) const;

    int F_, channels_, width_;                 // of a row of orders, rounded up to whole blocks
    std::vector<double> root_, inverse_root_;  // (l, q): sqrt(l^2 - q^2) and its inverse, 0 where q >= l
    std::vector<double> binomial_;             // (j, k): sqrt(C(2j, j+k))
    Angle angle_;
    std::vector<double> turned_;             // (l, channel, re | im, q)
    std::vector<std::vector<double>> sums_;  // one for each thread: (l, channel, re | im, block)
};

}  // namespace shrm
