// Spherical harmonics on lat-long pictures and at arbitrary directions. Everything is separable,
// O(F S^2) as in [RH02] section 6.1: a Fourier sum along each ring, then a Legendre sum across rings.
// Coefficients are in the real basis of core.hpp, row-major (basis function, channel).
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace shrm {

// What a texel stands for (and so the quadrature of the analysis).
enum class Texel {
    sample,  // the value at its centre: Fejer's first rule, exact for degrees F <= H/2 - 1
    area     // a constant over its area: the exact integral of Y_lm over each texel
};

// Weights w_i of Fejer's first rule at theta_i = (i + 1/2) pi / H: sum_i w_i g(theta_i) is the integral
// of g(theta) sin(theta) over [0, pi], exact for polynomials in cos(theta) of degree below H [W06].
std::vector<double> fejer_weights(int H);

// coefficients(lm, c) = integral of pixels(c) Y_lm over the sphere, degrees l <= F: L_lm by the two steps of
// [RH02] section 6.1.
//   pixels (H, W, channels), coefficients ((F+1)^2, channels)
void analysis(std::span<const float> pixels, int H, int W, int channels, int F, Texel texel,
              std::span<double> coefficients);

// Values at the texel centres, the adjoint of analysis but for the quadrature weights. Ring by ring and
// planar, the order in which reflection maps are kept:
//   coefficients ((F+1)^2, channels), rings (H, channels, W)
void synthesis(std::span<const double> coefficients, int channels, int F, int H, int W,
               std::span<float> rings);

// Values at n unit directions; Real is float (maps) or double (the public evaluation).
//   coefficients ((F+1)^2, channels), values (n, channels)
template <class Real>
void evaluate(std::span<const double> coefficients, int channels, int F,
              std::span<const glm::dvec3> directions, std::span<Real> values);

}  // namespace shrm
