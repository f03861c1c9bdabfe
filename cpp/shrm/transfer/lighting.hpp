// Matrix radiance transfer at run time: the radiance of an object's vertices towards an eye, from the
// coefficients of light (n^2, 3) in global coordinates. Radiance is (V, 3).
//
// Arrays of values that do not change are float or half; those of C channels have 1, the same for red, green
// and blue, or 3.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shrm/transfer/views.hpp"

namespace shrm {

struct TransferValues {
    std::span<const float> floats;
    std::span<const std::uint16_t> halves;  // IEEE half floats in place of floats

    bool empty() const { return floats.empty() && halves.empty(); }
};

// sum_t g_t(view) A_p,t light   [LK03] eq. 9: four rows of a vertex's matrix.
//   matrices (V, M^2, C, n^2)
void light_tents(const TransferSurface& surface, const TransferValues& matrices, int M, int channels,
                 std::span<const float> light, const Eye& eye, std::span<float> radiance);

// The same under light that is fixed: sum_t g_t(view) l_p,t   [LK03] section 3.3.
//   coefficients (V, M^2, 3)
void light_fixed_tents(const TransferSurface& surface, std::span<const float> coefficients, int M,
                       const Eye& eye, std::span<float> radiance);

// A row for each vertex times light: of diffuse materials [SKS02], and of any under a fixed view.
//   rows (V, C, n^2)
void light_rows(const TransferValues& rows, int vertices, int channels, std::span<const float> light,
                std::span<float> radiance);

// Matrices as weighted sums of principal components, A_p = sum_k w_pk A_k   [LK03] eq. 12; of the vertex's
// cluster, where there are clusters.
class CompressedTransfer {
  public:
    // weights (V, stored), of which the first K count; clusters (V,), below Q, or empty;
    // components (Q, stored, M^2, C, n^2)
    CompressedTransfer(const TransferValues& weights, std::span<const std::int32_t> clusters,
                       std::span<const float> components, int vertices, int Q, int stored, int K, int M,
                       int channels, int terms);

    // sum_t g_t(view) sum_k w_pk (A_k light)_t   [LK03] eq. 13
    void light(const TransferSurface& surface, std::span<const float> light, const Eye& eye,
               std::span<float> radiance);

    int vertices() const { return vertices_; }
    int terms() const { return terms_; }

  private:
    void light_node(std::size_t node, std::span<const float> light);

    int vertices_, Q_, K_, M_, channels_, terms_;
    bool half_;
    std::vector<float> weights_;         // (V, K), K rounded up to whole fours
    std::vector<std::uint16_t> halves_;  // in their place
    std::vector<std::int32_t> clusters_;
    std::vector<float> components_;  // (Q, M^2, C, n^2, K)
    std::vector<float> tables_;      // A_k light: (Q, M^2, K, red green blue 0)
};

inline constexpr int rotation_room = 16;

// The material's row at the local view, rotated into global coordinates, times T light: b(view) R_p T_p light
// [KSS02]. The row, one for the three channels if C = 1, is multiplied from the left, so that a vertex takes
// as many products as a matrix has elements.
//   samples    (side^2, C, n^2), rows at the views of a parabolic map, or of the tents (side = M)
//   rotations  (V, 1 + 9 + ... + (2n-1)^2): the bands of R_p, local from global, by rows; then rotation_room
//              floats, for the vectors that begin in the last; or empty: 1
//   transfer   (V, n^2, n^2): T_p; or empty: 1
void light_projected(const TransferSurface& surface, std::span<const float> samples, int side, bool parabolic,
                     int channels, std::span<const float> rotations, const TransferValues& transfer,
                     std::span<const float> light, const Eye& eye, std::span<float> radiance);

// A lobe that is symmetric about the reflection of the view, or about the normal, as a convolution of
// transferred light: sum_lm Lambda_l rho_l (T_p light)_lm Y_lm(axis)   [SKS02].
//   kernel    (n, C): Lambda_l rho_l, Lambda_l = sqrt(4 pi / (2 l + 1))
//   transfer  (V, n^2, n^2): T_p; or empty: 1
void light_convolved(const TransferSurface& surface, std::span<const float> kernel, int channels,
                     bool about_normal, const TransferValues& transfer, std::span<const float> light,
                     const Eye& eye, std::span<float> radiance);

}  // namespace shrm
