// From the coefficients of light and material to those of the reflection map's own maps, at once: they are
// scalar functions of the central direction, band-limited to degree F + p. In the global form
//
//   B~_pq    = sum_jk b^pq_jk Y_jk
//   b^pq_jk  = (-1)^q sum_l <l k+q p -q | j k> L_{l,k+q} shape_plj
//   shape_plj = sqrt(4 pi / (2j+1)) sum_s (-1)^s <l s p -s | j 0> rho_lp|s|
//
// which is [RH02] eq. 14 put into eq. 8 and the product of the two d summed by the Clebsch-Gordan series
// [VMK88 4.6]. Zonal maps keep only q = 0 of the local form, B_p0 = sum_lm Lambda_l L_lm rho_lp0 Y_lm.
#pragma once

#include <span>
#include <vector>

#include "shrm/core.hpp"

namespace shrm {

// The couplings, which depend on the orders alone, and the memory to work in: repeated runs allocate nothing,
// and go one after the other.
class MapCoefficients {
  public:
    MapCoefficients(int F, int P, int channels, bool zonal);

    // rho (F+1, P+1, P+1, channels) at (l, p, q), zero where q > min(l, p)
    void set_material(std::span<const double> rho);

    // light ((F+1)^2, channels), coefficients (basis_size(degree()), maps(), channels), real basis in light,
    // central direction and view
    void run(std::span<const double> light, std::span<double> coefficients);

    int degree() const { return zonal_ ? F_ : F_ + P_; }
    int maps() const { return zonal_ ? P_ + 1 : (P_ + 1) * (P_ + 1); }

  private:
    // One l in the sums for b^pq_jk, k = first ... first + count - 1, |k| <= j and |k + q| <= l.
    struct Term {
        int l, first, count;
        std::size_t coupling, shape;  // where count couplings begin, and the shape of (p, l, j)
    };
    // The map of (p, q), q >= 0, at one degree j; q and -q come from the same sum.
    struct Map {
        int p, q;
        std::vector<Term> terms;
    };
    // The factors of material and degrees, the same for all q and k.
    struct Shape {
        int p, l;
        std::size_t first;  // of min(l, p) + 1 factors, for rho_lps
    };
    void couple();
    void sum_degree(int j, double* b, double* coefficients) const;

    int F_, P_, channels_;
    bool zonal_;
    std::vector<std::vector<Map>> maps_;  // by j
    std::vector<double> coupling_;        // (-1)^q <l k+q p -q | j k>
    std::vector<Shape> shapes_;
    std::vector<double> shape_factor_;    // of rho_lps: the terms of s and -s together
    std::vector<double> shape_;           // (shape, channels); zonal: (l, p, channels)
    std::vector<double> light_;           // complex L_lm: (l, channel, re | im, m = -l..l)
    std::vector<std::vector<double>> b_;  // one for each thread: (channel, re | im, k = -j..j)
};

}  // namespace shrm
