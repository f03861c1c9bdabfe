// The spherical harmonic reflection map the paper's way: the local form from the coefficients of light and
// material, then each texel's series turned into the global form. Global maps in use are made at once, by
// map_coefficients and synthesis, and compared with these. Central directions C = (alpha, beta) index the
// maps; each texel holds the coefficients of a spherical harmonic series in the view.
//
//   light    L_lm, real basis            ((F+1)^2, channels)
//   rho      rho_lpq, 0 <= q <= p        (F+1, P+1, P+1, channels), zero where q > min(l, p)
//   maps     rings (H, (P+1)^2, channels, W), map p (p+1) + q
//
// In both forms B_{p,-q} = (-1)^q conj(B_pq), so that real maps are enough: sqrt2 Re B_pq at (p, q > 0),
// B_p0, and -sqrt2 Im B_pq at (p, -q) are the coefficients of the radiance in the real basis of the view.
#pragma once

#include <span>

namespace shrm {

// The local form [RH02] eq. 14 on a lat-long grid of central directions, by the two steps of appendix C,
// step 3. B_pq, q /= 0, is a spin function, singular at the poles: for the grid it is made on, not for
// interpolation.
void local_reflection_map(std::span<const double> light, std::span<const double> rho, int F, int P,
                          int channels, int H, int W, std::span<float> rings);

// From the local form to the global one [RH02] eq. 8: each texel's series is rotated into the world's frame.
void global_from_local(std::span<const float> local, int P, int channels, int H, int W,
                       std::span<float> global);

}  // namespace shrm
