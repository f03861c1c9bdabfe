// Maps on the faces of a cube: where their texels look.
#pragma once

#include <span>

#include <glm/vec3.hpp>

namespace shrm {

// Texels that each stored face has beyond each of its edges. They continue the face's own plane, so that no
// interpolation of four points looks across an edge.
inline constexpr int cube_border = 2;

// The direction of a point of a cube face, s and t in [-1, 1] to the right and downwards; not normalised.
// Faces are +X -X +Y -Y +Z -Z, they and their orientation OpenGL's, in the axes of the layout `strip`: +Z
// front (+x of the world), +X right (-y), +Y up (+z).
glm::dvec3 cube_direction(int face, double s, double t);

// The unit vector to the center of a texel of faces of N x N texels with their borders, stored one below the
// other: row < 6 (N + 4), column < N + 4.
glm::dvec3 cube_texel_direction(int N, int row, int column);

// The same of all texels: directions (6 (N + 4), N + 4).
void cube_texel_directions(int N, std::span<glm::dvec3> directions);

}  // namespace shrm
