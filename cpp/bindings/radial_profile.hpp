// What the two integrators take: directions, and the table of a radial lobe.
#pragma once

#include <string>
#include <vector>

#include "ndarray.hpp"
#include "shrm/angular.hpp"

namespace shrm::bindings {

inline std::vector<glm::dvec3> directions(const Array<double>& array, const char* name) {
    require_shape(array, name, {any, 3});
    const auto a = array.unchecked<2>();
    std::vector<glm::dvec3> result(static_cast<std::size_t>(a.shape(0)));
    for (py::ssize_t k = 0; k < a.shape(0); ++k)
        result[static_cast<std::size_t>(k)] = {a(k, 0), a(k, 1), a(k, 2)};
    return result;
}

inline void require_channels(int channels) {
    if (channels != 1 && channels != 3)
        throw py::value_error("a table has 1 or 3 channels, not " + std::to_string(channels));
}

inline angular::RadialProfile profile_of(const Array<float>& profile, int shift, double scale,
                                         double support) {
    require_shape(profile, "profile", {any, 4, any});
    require_channels(extent(profile, 0));
    const int segments = extent(profile, 2);
    if (shift < 0 || shift > 22 || segments < 32 || (segments & (segments - 1)) != 0)
        throw py::value_error(
            "profile needs a power of two of segments, at least 32, and a shift in [0, 22]");
    if (segments >> (23 - shift) > 100) throw py::value_error("profile covers more octaves than a float has");
    if (!(scale > 0) || !(support > 0)) throw py::value_error("scale and support must be positive");
    return {view(profile), extent(profile, 0), segments, shift, scale, support};
}

}  // namespace shrm::bindings
