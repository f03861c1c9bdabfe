// The Fourier half of the transforms: one ring of equally spaced texels, in the convention of core.hpp, to
// and from its modes cos(m phi), sin(m phi). Folding phi four ways (two when W is odd) leaves a quarter of
// the circle and splits cosines from sines and even from odd orders: a quarter of the plain matrix product,
// and for the orders in use faster than an FFT.
#pragma once

#include <vector>

#include "shrm/sh.hpp"

namespace shrm {

class RingFourier {
  public:
    RingFourier(int W, int max_order);

    // modes (channels, 2, max_order + 1): the integrals over phi of ring cos(m phi) and ring sin(m phi).
    //   ring (W, channels); scratch is the caller's, one per thread
    void analyse(const float* ring, int channels, Texel texel, double* modes,
                 std::vector<float>& scratch) const;

    // ring (channels, W) = sum over m of modes(m, 0, c) cos(m phi) + modes(m, 1, c) sin(m phi).
    //   modes (max_order + 1, 2, stride) with the channels first; stride >= channels, a multiple of 4
    void synthesise(const float* modes, int channels, int stride, float* ring,
                    std::vector<float>& scratch) const;

  private:
    // The orders that share one folding. With psi = pi - phi the quarters of the ring lie at psi, pi - psi,
    // pi + psi and 2 pi - psi, and enter with the signs 1, sign_b, sign_b sign_d and sign_d.
    struct Fold {
        bool sine;
        float sign_b, sign_d;
        std::vector<int> orders;
        int columns;                  // orders.size() rounded up to 8
        std::vector<float> by_texel;  // (K, columns), for analysis
        std::vector<float> by_order;  // (orders, K rounded up to 16), for synthesis
    };
    void fold(const Fold& fold, const float* planar, float* folded) const;
    void unfold(const float* const* parts, float* ring) const;

    int W_, max_order_;
    bool quarters_;     // four foldings, or two
    int K_, K_padded_;  // texels in a folded ring
    std::vector<Fold> folds_;
    std::vector<double> weight_sample_, weight_area_;  // per order: dphi, dphi sinc(m dphi / 2)
};

}  // namespace shrm
