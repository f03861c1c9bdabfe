// shrm: frequency-space environment map rendering. Read this file first.
//
// CONVENTIONS
//   World      right-handed, z up. theta is the colatitude from +z, phi the azimuth from +x
//              towards +y. Radiance is linear.
//   Lat-long   pixel (i, j) of an H x W picture covers theta in [i, i+1] pi/H and is centred
//              on phi_j = pi - 2 pi (j + 1/2) / W: the centre of the picture looks along +x,
//              +y is a quarter of the width to the left, the top row is +z.
//   Y_lm       f_lm(theta) e^{i m phi}: complex, orthonormal, Condon-Shortley phase.
//   Real basis at index l (l+1) + m: sqrt2 Re Y_lm (m > 0), Y_l0, sqrt2 Im Y_l|m| (m < 0).
//              A real function with complex coefficients L_lm has the real coefficients
//              sqrt2 Re L_lm (m > 0), L_l0, -sqrt2 Im L_l|m| (m < 0).
//   Wigner     d^l_{mq}(alpha): small-d of the z-y-z convention, d^1_{10} = -sin(alpha)/sqrt2,
//              f_lm(theta) = sqrt((2l+1)/4pi) d^l_{m0}(theta).
//   Rotation   R_{alpha,beta} = R_z(beta) R_y(alpha) carries +z to (theta, phi) = (alpha, beta).
//   Order      in the papers is the maximum degree: F of l, P of p.
//   Arrays     row-major; the last index is the channel unless a comment says otherwise.
//
// BIBLIOGRAPHY (cited as [RH02] eq. 14 at the line that computes it)
//   [RH02]   R. Ramamoorthi, P. Hanrahan. Frequency Space Environment Map Rendering.
//            ACM TOG 21(3), 2002.
//   [R02]    R. Ramamoorthi. A Signal-Processing Framework for Forward and Inverse Rendering.
//            PhD thesis, Stanford, 2002. Chapter 5 is the long form of [RH02].
//   [RH01]   R. Ramamoorthi, P. Hanrahan. An Efficient Representation for Irradiance
//            Environment Maps. SIGGRAPH 2001.
//   [KVHS00] J. Kautz, P.-P. Vazquez, W. Heidrich, H.-P. Seidel. A Unified Approach to
//            Prefiltered Environment Maps. EGWR 2000.
//   [LK03]   J. Lehtinen, J. Kautz. Matrix Radiance Transfer. I3D 2003.
//   [VMK88]  D. Varshalovich, A. Moskalev, V. Khersonskii. Quantum Theory of Angular Momentum.
//            World Scientific, 1988.
//   [W06]    J. Waldvogel. Fast Construction of the Fejer and Clenshaw-Curtis Quadrature
//            Rules. BIT 46, 2006.
//   [K81]    R. Keys. Cubic Convolution Interpolation for Digital Image Processing. IEEE TASSP
//            29(6), 1981.
//
// INDEX, in the order the data flows
//   grid            picture layouts, solid angles, area-exact conversion
//   sh              analysis, synthesis and evaluation of spherical harmonics
//   wigner          small-d recurrences, rotation in frequency space
//   brdf_analysis   the transfer function's coefficients rho_lpq
//   reflection_map  the spherical harmonic reflection map: local, global, per view, per pixel
//   angular         direct integration; shares no code with sh, so that it can judge it
#pragma once

#include <cstddef>
#include <numbers>

// One compiled clone per instruction set, chosen when the library is loaded. With
// -ffp-contract=off all clones give identical results.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(SHRM_NO_CLONES)
#define SHRM_CLONES __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#else
#define SHRM_CLONES
#endif

namespace shrm {

inline constexpr double pi = std::numbers::pi;

// Index of (l, m) in the real basis, |m| <= l.
constexpr std::size_t lm(int l, int m) {
    return static_cast<std::size_t>(l * (l + 1) + m);
}

// Number of basis functions up to degree F.
constexpr std::size_t basis_size(int F) {
    return static_cast<std::size_t>(F + 1) * static_cast<std::size_t>(F + 1);
}

}  // namespace shrm
