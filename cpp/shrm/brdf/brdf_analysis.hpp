// From a tabulated transfer function to its projections on the degrees and orders of the light: the first and
// the third of the three steps of [RH02] appendix C, step 1. The second, over theta_o, is a small
// least-squares fit for each P, left to the caller.
#pragma once

#include <span>
#include <vector>

namespace shrm {

// f_lm(theta), l = 0..F, at n angles: values (F+1, n), zero for l < m.
void legendre(int F, int m, std::span<const double> theta, std::span<double> values);

// Light directions in the frame of the central direction C: (views, I) colatitudes theta_i, and for each the
// azimuths arc share_k, which stand for both signs. arc is at most pi.
//
//   theta_i, arc (views, I)    share (K)
struct LightNodes {
    int I;
    std::span<const double> theta_i, arc, share;
};

// wi at the nodes and wo, (3, views, K, I), carried to the frame of the normal: N at the angle gamma from C
// and at azimuth 0, V at theta_v from N.   theta_v, gamma (views)
void directions(const LightNodes& nodes, std::span<const double> theta_v, std::span<const double> gamma,
                std::span<double> wi, std::span<double> wo);

// In the frame of the central direction, with views v:
//
//   g_lq(v)   = int int f_lq(theta_i) cos(q phi) rho_hat(theta_i, v, phi) sin(theta_i) dtheta_i dphi
//   energy(v) = int int rho_hat^2 sin(theta_i) dtheta_i dphi
//             = sum over all l, q of U_q g_lq(v)^2,  U_0 = 1, else 2     [R02] eq. 5.18
//
//   rho_hat (views, K, I, channels)
//   theta_i, weight_theta, arc (views, I), share (K) as above; the weights include sin(theta_i)
//   weight_share (K)           weights on [0, 1]: that of phi_k is 2 arc weight_share, for both signs
//   g (channels, Q+1, L+1, views), zero for l < q
//   energy (channels, views)
struct TransferTable {
    int views, K, I, channels;
    std::span<const double> rho_hat, theta_i, weight_theta, arc, share, weight_share;
};
void project(const TransferTable& table, int L, int Q, std::span<double> g, std::span<double> energy);

}  // namespace shrm
