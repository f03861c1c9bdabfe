// The Fourier half of the transforms: one ring of equally spaced texels, in the convention of core.hpp, to
// and from its modes cos(m phi), sin(m phi). Folding phi four ways (two when W is odd) leaves a quarter of
// the circle and splits cosines from sines and even from odd orders: a quarter of the plain matrix product,
// and for the orders in use, up to 80 and more, faster than an FFT (bench/README.md).
#pragma once

#include <cstddef>
#include <vector>

namespace shrm {

class RingFourier {
  public:
    RingFourier(int W, int max_order);

    // The number of rows that are folded and transformed at a time; that of all is rounded up to a multiple.
    static constexpr int row_block = 12;

    // Folds `count` rings, planar (count, W), to the rows from `first` on of folded (folds(), rows, pitch()).
    void fold(const float* planar, int count, int first, int rows, float* folded) const;
    // The same for the sum and the difference of two rings of three channels, texel by texel (W, 3): rows
    // `first` to `first` + 5 are the channels of the sum, then of the difference. For the W that
    // fold_pair_serves.
    void fold_pair(const float* north, const float* south, int first, int rows, float* folded) const;
    bool fold_pair_serves() const;
    // modes(row, j) = sum over the ring of row(k) cos(m phi_k), or sin(m phi_k), for the orders of each fold,
    // from the folded rows: mode_at() says where m is.
    //   folded (folds(), rows, pitch()), modes (rows, mode_pitch())
    void analyse(const float* folded, int rows, float* modes) const;
    int folds() const { return static_cast<int>(folds_.size()); }
    int pitch() const { return K_padded_; }
    int mode_pitch() const { return mode_pitch_; }
    std::size_t mode_at(bool sine, int m) const;

    // ring (channels, W) = sum over m of modes(m, 0, c) cos(m phi) + modes(m, 1, c) sin(m phi).
    //   modes (max_order + 1, stride): the channels of the cosine, then those of the sine
    // Given memory for three channels, `through` (3, W), it makes them there and streams them to the ring.
    void synthesise(const float* modes, int channels, int stride, float* ring,
                    float* through = nullptr) const;

  private:
    // The orders that share one folding. With psi = pi - phi the quarters of the ring lie at psi, pi - psi,
    // pi + psi and 2 pi - psi, and enter with the signs 1, sign_b, sign_b sign_d and sign_d.
    struct Fold {
        bool sine;
        float sign_b, sign_d;
        int first, orders;  // first, first + order_step(), ...
        int columns;        // orders rounded up to whole vectors
        int first_mode;
        std::vector<float> by_texel;  // (K, columns), for analysis
        std::vector<float> by_order;  // (orders, K_padded), for synthesis
    };
    int order_step() const { return quarters_ ? 2 : 1; }
    void fold_row(const float* planar, float* const* folded) const;
    template <int Folds, int Channels>
    void synthesise_channels(const float* modes, int channels, int stride, float* const* rings) const;

    int W_;
    bool quarters_;     // four folds, or two
    int K_, K_padded_;  // texels in a folded ring
    int mode_pitch_;
    std::vector<Fold> folds_;
};

}  // namespace shrm
