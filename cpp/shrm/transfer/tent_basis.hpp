// The directional basis of matrix radiance transfer [LK03 section 4.3]: M x M piecewise bilinear tents on the
// unit square, carried to the hemisphere about +z by the concentric map, which preserves area [SC97].
//
//   square     (u, v) in [0, 1]^2; tent j M + i has its peak at u = i / (M-1), v = j / (M-1)
//   disk       a = 2u - 1, b = 2v - 1; r = |a|, phi = pi/4 b/a towards +-x where |a| >= |b|, likewise
//              r = |b| towards +-y
//   hemisphere z = 1 - r^2, (x, y) = r sqrt(2 - r^2) (cos phi, sin phi)
//
// The rim of the square is the horizon; directions below it are brought to it.
#pragma once

#include <array>
#include <span>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace shrm {

glm::dvec3 hemisphere_from_square(glm::dvec2 uv);
glm::dvec2 square_from_hemisphere(const glm::dvec3& w);

// The tents that are not zero at a direction: first, first + 1, first + M, first + M + 1. Weights sum to 1.
struct FourTents {
    std::size_t first;
    std::array<double, 4> weights;

    std::array<std::size_t, 4> indices(int M) const;
};

// M >= 2
FourTents four_tents(int M, const glm::dvec3& w);

// values(n, c) = sum over j of g_j(w_n) coefficients(j, c), [LK03] eq. 9.
//   coefficients (M^2, channels), values (n, channels)
void evaluate_tents(std::span<const double> coefficients, int channels, int M,
                    std::span<const glm::dvec3> directions, std::span<double> values);

// The adjoint of the evaluation: sums(j, c) = sum over n of g_j(w_n) values(n, c).
//   values (n, channels), sums (M^2, channels)
void accumulate_tents(std::span<const double> values, int channels, int M,
                      std::span<const glm::dvec3> directions, std::span<double> sums);

}  // namespace shrm
