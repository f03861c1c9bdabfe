// Matrices of vertices from what their rays see: the innermost product of the precomputation of matrix
// radiance transfer [LK03 section 4.4], A_p = Q (V_p o Y) R_p.
#pragma once

#include <cstdint>
#include <span>

namespace shrm {

struct VisibleSizes {
    int vertices, rows, directions, terms;
};

// products(p, r, j) = sum over the visible k of rays(r, k) harmonics(k, j), and then times the vertex's
// rotation of harmonics if there are rotations.
//   rays (rows, directions), harmonics (directions, terms), visible (vertices, directions): 0 or 1
//   rotations (vertices, sum of (2l+1)^2 over the degrees), each degree's D(m, m') row by row; or empty
//   products (vertices, rows, terms)
void sum_over_visible(const VisibleSizes& sizes, std::span<const float> rays,
                      std::span<const float> harmonics, std::span<const std::uint8_t> visible,
                      std::span<const float> rotations, std::span<float> products);

}  // namespace shrm
