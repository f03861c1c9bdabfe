// Isotropic BRDFs in the adaptive parameterization of [DJ18], which spends its samples where the lobe is: a
// warp of the unit square, made of the distribution of visible normals, carries them to half vectors.
//
//   u_m = (sqrt(2 theta_m / pi), (phi_m - phi_i + pi) / 2 pi)     H in the unit square
//   x   = int_0^u D(u', v) du' / int_0^1 D(u', v) du'             D(u, v): vndf, linear in theta_i and
//   y   = int_0^v int_0^1 D(u', v') du' dv'                       bilinear in the square, at (u, v) = u_m
//   f_r cos(theta_o) = max(values(theta_i, y, x), 0) ndf(u_m) / (4 sigma(theta_i))
//
// theta_i is the colatitude of the direction that the table is over and theta_o that of the other, whose
// cosine is in the values.
#pragma once

#include <span>
#include <vector>

#include "shrm/brdf/direction_pairs.hpp"

namespace shrm {

class AdaptiveParameterization {
  public:
    struct Square {
        int rows, columns;  // at least 2; nodes on the borders, rows along y or v
    };

    //   theta_i (slices), ascending     vndf (slices, rows, columns), not negative, none of the slices 0
    //   values (slices, rows, columns, 3)
    //   ndf (rows, columns) over u_m    sigma (n) over sqrt(2 theta_i / pi), positive, n at least 2
    // Without ndf the values are what is wanted, without the last factor.
    AdaptiveParameterization(std::span<const double> theta_i, std::span<const float> vndf, Square vndf_square,
                             std::span<const float> values, Square values_square, std::span<const float> ndf,
                             Square ndf_square, std::span<const float> sigma);

    // f_r cos(theta_o), (count, 3): i is pairs.wo, o is pairs.wi.
    void evaluate(const DirectionPairs& pairs, std::span<double> values) const;

    // The places at which the values are looked up, (count, 3): that of theta_i among the slices, from 0 to
    // slices - 1, y and x.
    void samples(const DirectionPairs& pairs, std::span<double> samples) const;

  private:
    struct Node {
        float density;     // of a slice whose integral is 1, in units of the cells
        float cumulative;  // its integral over the row up to here
    };
    struct Sample;
    struct Eight;

    template <class Body>
    void each(const DirectionPairs& pairs, const Body& body) const;
    Sample sample(double theta_i, double u, double v) const;

    std::vector<double> theta_i_;
    std::vector<Node> vndf_;
    std::vector<float> marginal_;  // (slices, rows): integral of a slice up to the row
    std::vector<float> values_, ndf_, sigma_;
    Square vndf_square_, values_square_, ndf_square_;
};

}  // namespace shrm
