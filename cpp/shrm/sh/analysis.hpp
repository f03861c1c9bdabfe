// Analysis: from a lat-long picture to coefficients, O(F S^2) as in [RH02] section 6.1: a Fourier sum along
// each ring, then a Legendre sum across the rings. The southern ring at pi - theta shares the f_lm of the
// northern one, but for the sign (-1)^{l+m}: sums and differences of the two go through half the work.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "shrm/sh/legendre.hpp"
#include "shrm/sh/ring_fourier.hpp"

namespace shrm {

// The meaning of a texel, which decides the quadrature of the analysis.
enum class Texel {
    sample,  // the value at its center: Fejer's first rule, exact for degrees F <= H/2 - 1
    area     // a constant over its area: the exact integral of Y_lm over each texel
};

// The table of f_lm: made once and kept, for repeated runs, or made order by order on the way, for a single
// one. A larger table is never kept: a plan's memory has a bound.
enum class Tables { kept, transient };
inline constexpr std::size_t largest_kept_table = std::size_t(64) << 20;  // bytes

// Weights w_i of Fejer's first rule at theta_i = (i + 1/2) pi / H: sum_i w_i g(theta_i) is the integral
// of g(theta) sin(theta) over [0, pi], exact for polynomials in cos(theta) of degree below H [W06].
std::vector<double> fejer_weights(int H);

// Analysis of pictures of one size: all that depends on sizes alone, and the memory to work in. Repeated runs
// allocate nothing, and go one after the other.
class Analysis {
  public:
    Analysis(int H, int W, int channels, int F, Texel texel, Tables tables);

    // coefficients(lm, c) = integral of pixels(c) Y_lm over the sphere, degrees l <= F, real basis.
    //   pixels (H, W, channels), coefficients ((F+1)^2, channels)
    void run(std::span<const float> pixels, std::span<double> coefficients);

  private:
    struct Scratch {
        std::vector<float> planar;             // of one pair of rings
        std::vector<float> folded, modes;      // rows (pair, sum | difference, channel) of RingFourier
        std::vector<float> legendre;           // legendre_rows of one order, if not kept
        std::vector<double> f, previous, row;  // of the recurrence
    };
    void fourier_step(const float* pixels, int first_ring, Scratch& scratch);
    void legendre_rows(int m, Scratch& scratch, float* rows) const;
    void legendre_step(int m, Scratch& scratch, double* coefficients);
    std::size_t row_size(int m) const;  // floats of the rows of all orders below m

    int H_, W_, channels_, F_;
    int rings_, padded_;  // northern rings; rounded up to whole vectors
    int pairs_;           // of rings that are folded at once
    int nodes_;           // of the quadrature in theta, to a ring
    RingFourier fourier_;
    LegendreRecurrence recurrence_;
    std::vector<double> x_, sine_, weight_;  // (nodes, padded rings)
    std::vector<double> order_weight_;       // per m: the quadrature in phi, and the norm of the real basis
    std::vector<float> table_;               // legendre_rows of all orders, if kept
    std::vector<float> modes_;               // (m, even | odd in theta, cos | sin, channel, ring)
    std::vector<std::ptrdiff_t> place_;      // in modes_, of each of RingFourier's modes; -1 for none
    std::vector<Scratch> scratch_;           // one for each thread
};

}  // namespace shrm
