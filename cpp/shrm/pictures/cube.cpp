#include "shrm/pictures/cube.hpp"

#include <array>
#include <cmath>

#include "shrm/core.hpp"

namespace shrm {

glm::dvec3 cube_direction(int face, double s, double t) {
    const std::array<glm::dvec3, 6> in_cube{
        {{1, -t, -s}, {-1, -t, s}, {s, 1, t}, {s, -1, -t}, {s, -t, 1}, {-s, -t, -1}}};
    const glm::dvec3 c = in_cube[size(face)];
    return {c.z, -c.x, c.y};
}

glm::dvec3 cube_texel_direction(int N, int row, int column) {
    const int bordered = N + 2 * cube_border;
    const auto centered = [N](int i) { return (2 * (i - cube_border) + 1.0) / N - 1; };
    const glm::dvec3 d = cube_direction(row / bordered, centered(column), centered(row % bordered));
    const double length = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
    return {d.x / length, d.y / length, d.z / length};
}

void cube_texel_directions(int N, std::span<glm::dvec3> directions) {
    const int bordered = N + 2 * cube_border;
    std::size_t texel = 0;
    for (int row = 0; row < 6 * bordered; ++row)
        for (int column = 0; column < bordered; ++column)
            directions[texel++] = cube_texel_direction(N, row, column);
}

}  // namespace shrm
