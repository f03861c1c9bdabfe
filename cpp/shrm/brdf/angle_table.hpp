// Isotropic BRDFs from a regular table over three angles, interpolated linearly in them or in a warp of the
// first.
#pragma once

#include <cstdint>
#include <span>

#include "shrm/brdf/direction_pairs.hpp"

namespace shrm {

enum class Angles {
    difference,  // theta_i, theta_o, |phi_i - phi_o|
    half         // theta_h, theta_d, |phi_d| [R98]: L in the frame of H, whose x axis leads away from N
};

// The axes run over [0, pi/2], [0, pi/2] and [0, pi]. Nodes lie on both ends and evenly between them, or are
// the centers of n even bins; beyond the outer centers their values hold. `square_root` spaces the first axis
// evenly in the square root of its angle.
struct AngleAxes {
    Angles angles;
    int n[3];  // at least 2
    bool square_root, centers;
};

// values (count, channels) from table (n0, n1, n2, channels), channels 1 or 3.
template <class T>  // float or double
void interpolate(const AngleAxes& axes, int channels, std::span<const T> table, const DirectionPairs& pairs,
                 std::span<double> values);

// The index of the nearest node into (n0, n1, n2), for each pair.
void nearest_nodes(const AngleAxes& axes, const DirectionPairs& pairs, std::span<std::int64_t> nodes);

}  // namespace shrm
