// The directions in which the vertices of an object see the eye: in their frames, and as places among the
// samples of the radiance that they send.
//
// Vertices are taken in blocks, whose arrays stay in the first cache between the steps of the lighting.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "shrm/core.hpp"

namespace shrm {

inline constexpr int vertex_block = 64;

// Vertices and their frames, in blocks of planes: positions x, y, z, then the nine elements of
// global_from_local, column by column (x, y and z of the tangent, of the bitangent, of the normal).
class TransferSurface {
  public:
    static constexpr int planes = 12;

    // vertices (V, 3), frames (V, 3, 3): rotations global_from_local
    TransferSurface(std::span<const float> vertices, std::span<const float> frames);

    int vertices() const { return vertices_; }
    int blocks() const { return (vertices_ + vertex_block - 1) / vertex_block; }
    // Vertices of a block; the last may be shorter, though its planes are not.
    int count(int block) const;
    const float* plane(int block, int which) const {
        return &planes_[(size(block) * planes + size(which)) * vertex_block];
    }

  private:
    int vertices_;
    std::vector<float> planes_;  // (blocks, planes, vertex_block)
};

// An eye near the object, at a position; or far away, in a direction that points to it.
struct Eye {
    glm::vec3 at;
    bool distant;
};

// For each vertex of a block four neighbors on a grid of `side` samples in each dimension: first, first + 1,
// first + side, first + side + 1; their weights sum to 1. Beyond the block's vertices they are valid as well.
struct Neighbours {
    alignas(64) std::int32_t first[vertex_block];
    alignas(64) float weights[4][vertex_block];
};

struct Directions {
    alignas(64) float x[vertex_block], y[vertex_block], z[vertex_block];
};

// The four tents that are not zero at the local view, as four_tents of tent_basis has them, in
// float32: to 1e-6 of the square's side. Views below the horizon are brought to it.   M >= 2
void tents_of_views(const TransferSurface& surface, int block, const Eye& eye, int M, Neighbours& tents);

// The four samples about the local view in a parabolic map [HS98] of side x side samples: (x, y) / (1 + z),
// from -1 to 1 along columns and along rows.   side >= 2
void parabolic_samples_of_views(const TransferSurface& surface, int block, const Eye& eye, int side,
                                Neighbours& samples);

// The reflections of the view about the normal, in global coordinates; views below the horizon are brought to
// it.
void reflections_of_views(const TransferSurface& surface, int block, const Eye& eye, Directions& reflections);

}  // namespace shrm
