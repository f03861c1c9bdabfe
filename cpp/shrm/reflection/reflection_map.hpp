// A reflection map in memory, as all that reads it sees it.
#pragma once

#include <cstdint>
#include <span>

namespace shrm {

enum class MapLayout {
    latlong,  // rings (H, maps, 3, W), the grid of core.hpp; W even
    cube      // rings (6 (N + 4), maps, 3, N + 4): the bordered faces of pictures/cube.hpp
};

struct ReflectionMapView {
    MapLayout layout;
    int H, W;   // of the rings: cube maps include their borders
    int pitch;  // values from one row of W to the next; more than W where rows begin at multiples of 16 bytes
    int P;
    bool zonal;  // P + 1 maps of a series in Y_p0(angle between C and V), else (P+1)^2 in Y_pq(V)
    std::span<const float> rings;
    std::span<const std::uint16_t> halves;  // IEEE half floats in place of rings

    int maps() const { return zonal ? P + 1 : (P + 1) * (P + 1); }
};

}  // namespace shrm
