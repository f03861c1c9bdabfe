// Synthesis: from coefficients to lat-long maps, the adjoint of analysis but for the quadrature weights: a
// Legendre sum for each pair of rings at theta and pi - theta, then a Fourier sum along each. The maps are
// planar ring by ring, the order in which reflection maps are kept.
#pragma once

#include <span>
#include <vector>

#include "shrm/sh/analysis.hpp"
#include "shrm/sh/legendre.hpp"
#include "shrm/sh/ring_fourier.hpp"

namespace shrm {

// Synthesis on a grid of one size: all that depends on sizes alone, and the memory to work in. Repeated runs
// allocate nothing, and go one after the other.
class Synthesis {
  public:
    Synthesis(int H, int W, int channels, int F, Tables tables);

    // Values at the texel centers.
    //   coefficients ((F+1)^2, channels), real basis; rings (H, channels, W)
    void run(std::span<const double> coefficients, std::span<float> rings);

  private:
    struct Scratch {
        std::vector<float> modes;     // (north | south, ring of the block, m, stride)
        std::vector<float> legendre;  // legendre_rows of one order, if not kept
        std::vector<float> channels;  // (3, W), on their way past the caches
    };
    void gather(int m, const double* coefficients);
    void legendre_rows(int block, int m, float* rows) const;
    void legendre_step(int block, Scratch& scratch) const;
    std::size_t degrees_below(int m) const;  // (l, m) of all orders below m

    int H_, W_, channels_, F_;
    int blocks_;  // of northern rings
    int stride_;  // the cosine's and the sine's channels, rounded up to whole vectors
    RingFourier fourier_;
    LegendreRecurrence recurrence_;
    std::vector<float> table_;      // legendre_rows of all blocks and orders, if kept
    std::vector<float> ordered_;    // the coefficients (m, l, cosine's channels | sine's | padding)
    std::vector<Scratch> scratch_;  // one for each thread
};

}  // namespace shrm
