#include "shrm/hierarchical/pyramid.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "shrm/core.hpp"

namespace shrm {
namespace {

// The bits of x and y in turns.
std::uint32_t morton(std::uint32_t x, std::uint32_t y) {
    std::uint32_t code = 0;
    for (unsigned bit = 0; bit < 16; ++bit)
        code |= (x >> bit & 1u) << (2 * bit) | (y >> bit & 1u) << (2 * bit + 1);
    return code;
}

// The cell of a direction among N x N of either paraboloid: p = (x, y) / (1 + |z|) [HS98].
std::size_t cell_of(const glm::dvec3& d, int N) {
    const auto place = [N](double p) {
        return static_cast<std::uint32_t>(std::clamp(static_cast<int>((p + 1) / 2 * N), 0, N - 1));
    };
    const double far = 1 + std::abs(d.z);
    return (d.z < 0 ? size(N) * size(N) : 0) + morton(place(d.x / far), place(d.y / far));
}

glm::dvec3 direction_of(const Pyramid::Node& node) {
    return {node.direction[0], node.direction[1], node.direction[2]};
}

// The power of all, at their centroid by power, and how far they reach from it.
Pyramid::Node gathered(std::span<const Pyramid::Node> parts) {
    Pyramid::Node all{};
    glm::dvec3 centroid(0);
    double power[3] = {};
    for (const Pyramid::Node& part : parts) {
        double weight = 0;
        for (int c = 0; c < 3; ++c) {
            power[c] += static_cast<double>(part.power[c]);
            weight += std::abs(static_cast<double>(part.power[c]));
        }
        centroid += weight * direction_of(part);
        all.brightness += part.brightness;
    }
    const double length = glm::length(centroid);
    if (length > 0) centroid /= length;
    for (int c = 0; c < 3; ++c) {
        all.power[c] = static_cast<float>(power[c]);
        all.direction[c] = static_cast<float>(centroid[c]);
    }
    for (const Pyramid::Node& part : parts) {
        if (part.brightness == 0) continue;
        const double chord = std::min(2., glm::length(direction_of(part) - centroid));
        all.radius = std::max(all.radius, static_cast<float>(2 * std::asin(chord / 2)) + part.radius);
    }
    return all;
}

}  // namespace

Pyramid::Pyramid(std::span<const float> pixels, int H, int W) {
    // About two texels to a cell of the discs.
    int N = 1;
    while (2. * N * N < double(H) * W / pi) N *= 2;

    // Azimuths of the columns, which all rows share.
    std::vector<glm::dvec2> column(size(W));
    for (int j = 0; j < W; ++j) {
        const double phi = pi - 2 * pi * (j + 0.5) / W;
        column[size(j)] = {std::cos(phi), std::sin(phi)};
    }
    // Every texel that is not black, with its power, and the cell that it lies in.
    std::vector<std::uint32_t> cell;
    std::vector<Node> found;
    cell.reserve(size(H) * size(W));
    found.reserve(size(H) * size(W));
    for (int i = 0; i < H; ++i) {
        const double theta = (i + 0.5) * pi / H, area = 4 * pi / W * std::sin(theta) * std::sin(0.5 * pi / H);
        const double sine = std::sin(theta), cosine = std::cos(theta);
        const float* texels = &pixels[3 * size(i) * size(W)];
        for (const glm::dvec2& circle : column) {
            const glm::dvec3 d(sine * circle, cosine);
            Node texel{};
            for (int c = 0; c < 3; ++c) {
                texel.direction[c] = static_cast<float>(d[c]);
                texel.power[c] = static_cast<float>(area * double(*texels++));
                texel.brightness = std::max(texel.brightness, std::abs(texel.power[c]));
            }
            if (texel.brightness == 0) continue;
            brightness_ += static_cast<double>(texel.brightness);
            cell.push_back(static_cast<std::uint32_t>(cell_of(d, N)));
            found.push_back(texel);
        }
    }

    // Sorted cell by cell, by counting.
    begin_.assign(2 * size(N) * size(N) + 1, 0);
    for (std::uint32_t k : cell) ++begin_[k + 1];
    for (std::size_t k = 1; k < begin_.size(); ++k) begin_[k] += begin_[k - 1];
    texels_.resize(found.size());
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    for (std::size_t k = 0; k < found.size(); ++k) texels_[next[cell[k]]++] = found[k];

    // The nodes from the finest level up, each from its four children.
    std::size_t count = 0;
    for (int n = 1; n <= N; n *= 2) {
        first_.push_back(count);
        count += 2 * size(n) * size(n);
    }
    nodes_.resize(count);
    for (int level = levels() - 1; level >= 0; --level) gather(level);
}

void Pyramid::gather(int level) {
    const bool finest = level + 1 == levels();
    const std::size_t count = std::size_t{2} << (2 * level);
    Node* const to = &nodes_[first_[size(level)]];
    for (std::size_t i = 0; i < count; ++i)
        to[i] = gathered(finest ? texels(i) : std::span(&node(level + 1, 4 * i), 4));
}

}  // namespace shrm
