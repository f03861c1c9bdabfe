// pyramid: a picture as a quadtree over the two paraboloids on which the sphere is mapped [HS98]. Its finest
// cells hold the texels of the picture, every node their power (radiance times solid angle, summed over its
// texels) at one direction, their centroid by power.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace shrm {

class Pyramid {
  public:
    // The pyramid of a lat-long picture (H, W, 3), whose texels count as points of their power.
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

}  // namespace shrm
