// Synthesis on a cube map. Its texels have no rings, but the grid is its own mirror image in the planes
// x = 0, y = 0 and z = 0, and so is every Y_lm, up to a sign. The basis falls into eight classes, by the
// three signs; sums over each class at the texels of one octant give, added and subtracted, the values at all
// eight mirror images: an eighth of the plain matrix product.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "shrm/sh/legendre.hpp"

namespace shrm {

// Synthesis on a cube of one size: the tables that depend on sizes alone, and the memory to work in. Repeated
// runs allocate nothing, and go one after the other. The basis is made anew for a few texels at a time: a
// table of it would take as long to read.
class CubeSynthesis {
  public:
    // Faces of N x N texels, N even, with the border of radiance.hpp.
    CubeSynthesis(int N, int channels, int F);

    // Values at the texel centers.
    //   coefficients ((F+1)^2, channels), real basis; rings (6 (N + 4), channels, N + 4)
    void run(std::span<const double> coefficients, std::span<float> rings);

  private:
    static constexpr int classes = 8;
    // Texels of the octant in a row, and where each of the eight images of the first lies.
    struct Segment {
        int first, count;
        std::array<int, classes> row, column, step;  // by the signs of the direction; step is 1 or -1
    };
    struct Scratch {
        std::vector<float> basis;  // (term, texel of the task)
        std::vector<float> sums;   // (class, channel of the block, texel)
    };
    void basis(std::size_t task, float* values) const;
    void store_images(std::size_t task, int channel, int channels, const float* sums, float* rings) const;

    int side_, channels_, F_, texels_;  // texels of a task: a few vectors
    LegendreRecurrence recurrence_;
    std::array<std::size_t, classes + 1> first_term_;  // of each class
    std::vector<int> term_;                            // the index (l, m) of each term
    std::vector<glm::dvec3> directions_;               // of the octant's texels, rounded up to whole tasks
    std::vector<std::vector<Segment>> segments_;       // of each task
    std::vector<float> ordered_;                       // coefficients (term, channel)
    std::vector<Scratch> scratch_;                     // one for each thread
};

}  // namespace shrm
