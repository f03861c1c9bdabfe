// An explicit set of reflection maps, one for each view of a grid.
#pragma once

#include <span>

#include "shrm/reflection/reflection_map.hpp"

namespace shrm {

// pixels (T, T, H, W, 3), or (T, T, 6, N, N, 3) for cubes = sum_pq B~_pq(C) Y_pq(V) at the views
// theta = (a + 1/2) pi / T, phi = pi - 2 pi (b + 1/2) / T. The sum is taken over p once for each theta, then
// over q: O(P) for each texel of each map, not O(P^2)   [RH02] appendix C
//   map  of the global form, in float32
void explicit_maps(const ReflectionMapView& map, int T, std::span<float> pixels);

}  // namespace shrm
