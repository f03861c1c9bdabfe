// From a tabulated transfer function to its projections on the degrees and orders of the light: the first and
// the third of the three steps of [RH02] appendix C, step 1. The second, over theta_o, is a small
// least-squares fit for each P, left to the caller.
#pragma once

#include <span>
#include <vector>

namespace shrm {

// f_lm(theta), l = 0..F, at n angles: values (F+1, n), zero for l < m.
void legendre(int F, int m, std::span<const double> theta, std::span<double> values);

// In the frame of the central direction, with views v, angles theta_i and azimuths phi in [0, pi], which
// stand for both signs:
//
//   g_lq(v)   = int int f_lq(theta_i) cos(q phi) rho_hat(theta_i, v, phi) sin(theta_i) dtheta_i dphi
//   energy(v) = int int rho_hat^2 sin(theta_i) dtheta_i dphi
//             = sum over all l, q of U_q g_lq(v)^2,  U_0 = 1, else 2     [R02] eq. 5.18
//
//   rho_hat (views, I, K, channels)
//   theta_i, weight_theta (views, I); the weights include sin(theta_i)
//   phi, weight_phi (views, I, K); the weights count both signs of phi
//   g (channels, Q+1, L+1, views), zero for l < q
//   energy (channels, views)
struct TransferTable {
    int views, I, K, channels;
    std::span<const double> rho_hat, theta_i, weight_theta, phi, weight_phi;
};
void project(const TransferTable& table, int L, int Q, std::span<double> g, std::span<double> energy);

}  // namespace shrm
