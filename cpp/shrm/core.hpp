// shrm: frequency-space environment map rendering. Read this file first.
//
// CONVENTIONS
//   World      right-handed, z up. theta is the colatitude from +z, phi the azimuth from +x
//              towards +y. Radiance is linear.
//   Lat-long   pixel (i, j) of an H x W picture covers theta in [i, i+1] pi/H and is centered
//              on phi_j = pi - 2 pi (j + 1/2) / W: the center of the picture looks along +x,
//              +y is a quarter of the width to the left, the top row is +z.
//   Y_lm       f_lm(theta) e^{i m phi}: complex, orthonormal, Condon-Shortley phase.
//   Real basis at index l (l+1) + m: sqrt2 Re Y_lm (m > 0), Y_l0, sqrt2 Im Y_l|m| (m < 0).
//              A real function with complex coefficients L_lm has the real coefficients
//              sqrt2 Re L_lm (m > 0), L_l0, -sqrt2 Im L_l|m| (m < 0).
//   Wigner     d^l_{mq}(alpha): small-d of the z-y-z convention, d^1_{10} = -sin(alpha)/sqrt2,
//              f_lm(theta) = sqrt((2l+1)/4pi) d^l_{m0}(theta).
//   Rotation   R_{alpha,beta} = R_z(beta) R_y(alpha) carries +z to (theta, phi) = (alpha, beta).
//   Order      in [RH02] is the maximum degree: F of l, P of p; in [LK03] the number of degrees: 0 to n - 1.
//   Arrays     row-major; the last index is the channel unless a comment says otherwise.
//
// BIBLIOGRAPHY (cited as [RH02] eq. 14 at the line that computes it; python/shrm/bibliography.py has all)
//   Rendering in frequency space, and what it is compared with
//   [RH02]     R. Ramamoorthi, P. Hanrahan. Frequency Space Environment Map Rendering. ACM TOG 21(3),
//              2002.
//   [R02]      R. Ramamoorthi. A Signal-Processing Framework for Forward and Inverse Rendering. PhD
//              thesis, Stanford, 2002. Chapter 5 is the long form of [RH02].
//   [KVHS00]   J. Kautz, P.-P. Vazquez, W. Heidrich, H.-P. Seidel. A Unified Approach to Prefiltered
//              Environment Maps. EGWR 2000.
//   [LK03]     J. Lehtinen, J. Kautz. Matrix Radiance Transfer. I3D 2003.
//   [SKS02]    P.-P. Sloan, J. Kautz, J. Snyder. Precomputed Radiance Transfer for Real-Time
//              Rendering in Dynamic, Low-Frequency Lighting Environments. SIGGRAPH 2002.
//   [KSS02]    J. Kautz, P.-P. Sloan, J. Snyder. Fast, Arbitrary BRDF Shading for Low-Frequency
//              Lighting Using Spherical Harmonics. EGWR 2002.
//   Mathematics
//   [VMK88]    D. Varshalovich, A. Moskalev, V. Khersonskii. Quantum Theory of Angular Momentum.
//              World Scientific, 1988.
//   [W06]      J. Waldvogel. Fast Construction of the Fejer and Clenshaw-Curtis Quadrature Rules. BIT
//              46, 2006.
//   [S67]      R. Sinkhorn. Diagonal Equivalence to Matrices with Prescribed Row and Column Sums.
//              American Mathematical Monthly 74(4), 1967.
//   [OS83]     A. van Oosterom, J. Strackee. The Solid Angle of a Plane Triangle. IEEE Transactions
//              on Biomedical Engineering 30(2), 1983.
//   [SC97]     P. Shirley, K. Chiu. A Low Distortion Map Between Disk and Square. Journal of Graphics
//              Tools 2(3), 1997.
//   Layouts, materials, light and color
//   [HS98]     W. Heidrich, H.-P. Seidel. View-Independent Environment Maps. Graphics Hardware 1998.
//   [ED08]     T. Engelhardt, C. Dachsbacher. Octahedral Environment Maps. VMV 2008.
//   [R98]      S. Rusinkiewicz. A New Change of Variables for Efficient BRDF Representation. EGWR
//              1998.
//   [DJ18]     J. Dupuy, W. Jakob. An Adaptive Parameterization for Efficient Material Acquisition
//              and Rendering. ACM TOG 37(6), 2018.
//
// ROOMS, in the order the data flows: what stands in one includes only rooms above it
//   quadrature    Gauss-Legendre nodes and weights
//   simd/         the instruction set: vectors of it, for .cpp files only
//     vectors          vectors of floats, and functions of their lanes
//     shuffles         lanes that change places
//     packs            eight numbers at a time, whatever the instruction set
//     half             maps as half floats
//     stream           stores of what is larger than the caches
//     trigonometry     functions of eight angles at once, in float64
//   pictures/     pictures of the sphere
//     layouts          directions, positions, solid angles of texels
//     grid             area-exact conversion from one picture to another
//     cube             the faces on which maps are stored
//   sh/           spherical harmonics
//     legendre         f_lm, the theta part of Y_lm, by recurrence
//     ring_fourier     the phi part: Fourier transforms of the rings of a picture
//     analysis         light: from a lat-long picture to coefficients L_lm
//     synthesis        from coefficients to maps, on a lat-long grid
//     cube_synthesis   the same on a cube
//     evaluation       the same at any directions
//     wigner           small-d recurrences, Clebsch-Gordan
//     rotation         rotation of coefficients
//     view_harmonics   the basis of the view at one direction
//   brdf/         materials
//     direction_pairs, direction_lanes         many pairs of directions, eight at a time
//     angle_table, adaptive_parameterization   materials measured in tables
//     brdf_analysis    the transfer function's coefficients rho_lpq
//   reflection/   [RH02]: light times material
//     reflection_map   a map in memory
//     map_coefficients the product of both: the coefficients of the reflection map's own maps
//     local_form       the paper's way to the same maps: the local form, rotated texel by texel
//     radiance         looking a reflection map up, point by point
//     view_map         all central directions under one view: the dynamic reflection map
//     explicit_maps    the dynamic maps of many views at once
//   angular/      direct integration over lobes; shares nothing with sh/ and reflection/, which it judges
//     angular          what it integrates and how
//     sums             sums in the lanes of vectors
//     profile          a radial profile in lanes, and the innermost loops
//     texels           the nodes of a picture's texels, and which of them a lobe visits
//     caps             what a lobe that is cut at the horizon visits
//     queries          planes of the picture; threads
//     radial, half_angle, zonal, isotropic   the kinds of lobe
//   hierarchical/ the same sums by descent in a pyramid, the second judge
//     pyramid          a picture as a quadtree over two paraboloids
//     hierarchical     what it integrates and how
//     walk             the descent itself
//     radial, zonal, isotropic   the kinds of lobe
//   transfer/     matrix radiance transfer [LK03]
//     tent_basis       tents over the hemisphere, for outgoing radiance
//     products         its precomputation: matrices from what the rays of vertices see
//     lighting         its run time: vertices lit through their matrices
//     views            where vertices see the eye, in their frames and between samples
//     rows             products of rows and light in vectors
//     tents, compressed, earlier   the methods
#pragma once

#include <cstddef>
#include <numbers>

namespace shrm {

inline constexpr double pi = std::numbers::pi;

// An int that is at least 0, as sizes and indices of arrays.
constexpr std::size_t size(int n) {
    return static_cast<std::size_t>(n);
}

constexpr int round_up(int n, int multiple) {
    return (n + multiple - 1) / multiple * multiple;
}

// Index of (l, m) in the real basis, |m| <= l.
constexpr std::size_t lm(int l, int m) {
    return size(l * (l + 1) + m);
}

// Number of basis functions up to degree F.
constexpr std::size_t basis_size(int F) {
    return size(F + 1) * size(F + 1);
}

}  // namespace shrm
