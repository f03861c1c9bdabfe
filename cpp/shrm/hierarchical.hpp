// hierarchical: prefiltering by descent in a pyramid of the environment [KVHS00 section 5.1]. A judge and a
// rival like angular: it shares nothing with the frequency-space path.
//
// The pyramid is a quadtree over the two paraboloids on which the sphere is mapped [HS98]: its finest cells
// hold the texels of the picture, every node their power (radiance times solid angle, summed over its texels)
// at one direction, their centroid by power. For a target a lobe is compared between a node and its four
// children: where the difference, weighted by the children's power, is below a threshold, the children stand
// for all below them; elsewhere each of them is entered.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "angular.hpp"

namespace shrm {

class Pyramid {
  public:
    // Of a lat-long picture (H, W, 3), whose texels count as points of their power.
    Pyramid(std::span<const float> pixels, int H, int W);

    // A node or a texel: eight values, so that two lie in a line of the cache.
    struct Node {
        float direction[3];
        float radius;  // angle from the direction to the farthest of its texels, radians
        float power[3];
        float brightness;  // the largest of power
    };

    // Levels from the coarsest, one node for each paraboloid, to the finest; nodes in Morton order, so that
    // the children of node i are 4 i to 4 i + 3 of the next level. Empty nodes have no brightness.
    int levels() const { return static_cast<int>(first_.size()); }
    const Node& node(int level, std::size_t i) const { return nodes_[first_[std::size_t(level)] + i]; }
    // Texels of node i of the finest level.
    std::span<const Node> texels(std::size_t i) const {
        return {texels_.data() + begin_[i], begin_[i + 1] - begin_[i]};
    }
    double brightness() const { return brightness_; }

  private:
    void gather(int level);

    std::vector<Node> nodes_, texels_;
    std::vector<std::size_t> first_;  // of each level
    std::vector<std::uint32_t> begin_;
    double brightness_ = 0;  // of all
};

namespace hierarchical {

// Targets that descend together, and best lie close together: as many as the widest vectors have lanes.
inline constexpr int block = angular::lanes;

// How far to descend. A node is split while its children's kernels, weighted by their brightness, differ from
// its own by more than `threshold` times the mean over all targets: the integral of the lobe by the picture's
// mean brightness. Where a lobe could hide between samples, within `outer` of its centre, nodes are split
// down to `finest` radians whatever they say.
struct Descent {
    double threshold;
    double outer;
    double finest;
};

// What was done: kernel evaluations, for targets each.
struct Effort {
    double evaluations;
};

// Reflected radiance for each centre of a radial lobe: out [target][3].
Effort integrate_radial(const Pyramid& pyramid, const angular::RadialProfile& profile, double integral,
                        const Descent& descent, std::span<const glm::dvec3> centres, std::span<float> out);

}  // namespace hierarchical
}  // namespace shrm
