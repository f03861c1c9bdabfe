// Area-exact conversion between pictures of the sphere.
//
// A texel is an area with one radiance. Converting distributes the light of every source texel i
// over the target texels j by weights w_ij >= 0, the solid angles of their overlaps:
//
//     L_j = 1/Omega_j sum_i w_ij L_i,    sum_j w_ij = Omega_i,    sum_i w_ij = Omega_j.
//
// The first marginal keeps the energy of every source texel, wherever it lies; the second keeps
// a constant constant. The overlaps are first estimated by polygons - of each pair the smaller
// texel, as a quadrilateral of the other picture, is cut at that picture's grid, so that none is
// missed, however small or slender - and then fitted to both marginals, which are known exactly,
// by scaling rows and columns in turn [S67].
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shrm/pictures/layouts.hpp"

namespace shrm {

struct Picture {
    Layout layout;
    int height, width;
};

// The overlaps of one row of a picture's texels with larger texels of the other picture.
struct OverlapRow {
    struct Overlap {
        std::uint32_t other;  // the larger texel
        float solid_angle;
    };
    std::vector<std::uint32_t> first;  // (width + 1), where each texel's overlaps begin
    std::vector<Overlap> overlaps;
};

class Conversion {
  public:
    // Radiance that comes from direction w in the source comes from target_from_source w in the
    // target.
    Conversion(const Picture& source, const Picture& target, const glm::dmat3& target_from_source);

    // source (H, W, channels) -> target (H', W', channels). What lies outside the target layout
    // becomes 0.
    void apply(std::span<const float> source, int channels, std::span<float> target) const;

    // The largest relative error of a marginal sum_j w_ij = Omega_i. (The other is exact.)
    double residual() const { return residual_; }

  private:
    std::vector<OverlapRow> source_smaller_, target_smaller_;
    // w_ij / Omega_j = source_scale_[i] * overlap * target_scale_[j]
    std::vector<double> source_scale_, target_scale_;
    double residual_ = 0;
};

}  // namespace shrm
