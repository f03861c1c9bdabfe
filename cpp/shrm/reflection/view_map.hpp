// The dynamic reflection map: all central directions under one view.
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "shrm/pictures/cube.hpp"
#include "shrm/reflection/reflection_map.hpp"

namespace shrm {

// The texels of a map that are shown: those of a cube's borders are not.
struct ShownTexels {
    int rows, columns, border;

    explicit ShownTexels(const ReflectionMapView& map)
        : rows(map.layout == MapLayout::cube ? 6 * (map.W - 2 * cube_border) : map.H),
          columns(map.layout == MapLayout::cube ? map.W - 2 * cube_border : map.W),
          border(map.layout == MapLayout::cube ? cube_border : 0) {}
    // Row i in the map's memory.
    int row(int i) const { return border ? i / columns * (columns + 2 * border) + border + i % columns : i; }
};

// pixels = sum_pq B~_pq(C) Y_pq(V)   [RH02] eq. 12, or sum_p B_p0(C) Y_p0(C.V) if zonal, on the map's own
// grid: (H, W, 3), or (6, N, N, 3) for cubes, without their borders.
void view_map(const ReflectionMapView& map, const glm::dvec3& view, std::span<float> pixels);

// The maps as half floats, to the nearest; from 65520 on they are infinite. Rows of W values, `pitch` apart
// in `halves`.
void to_half(std::span<const float> rings, int W, std::uint16_t* halves, int pitch);

// The largest magnitude in the maps, NaN aside: what tells beforehand whether they fit half floats.
float largest_magnitude(std::span<const float> rings);

}  // namespace shrm
