// Spherical harmonics at arbitrary directions. Coefficients are in the real basis of core.hpp, row-major
// (basis function, channel).
#pragma once

#include <span>

#include <glm/vec3.hpp>

namespace shrm {

// Values at n unit directions.
//   coefficients ((F+1)^2, channels), values (n, channels)
void evaluate(std::span<const double> coefficients, int channels, int F,
              std::span<const glm::dvec3> directions, std::span<double> values);

}  // namespace shrm
