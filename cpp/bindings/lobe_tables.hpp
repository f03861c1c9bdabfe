// What the two integrators take: directions, and the tables of lobes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "ndarray.hpp"
#include "shrm/angular/angular.hpp"

namespace shrm::bindings {

inline std::vector<glm::dvec3> unit_vectors(const Array<double>& array, const char* name) {
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

inline std::vector<angular::Band> bands_of(const Array<double>& bands, const char* name, py::ssize_t rows) {
    require_shape(bands, name, {rows, 2});
    std::vector<angular::Band> result;
    for (py::ssize_t k = 0; k < bands.shape(0); ++k) result.push_back({bands.at(k, 0), bands.at(k, 1)});
    return result;
}

inline std::vector<angular::Cap> caps_of(const Array<double>& caps, py::ssize_t views) {
    require_shape(caps, "caps", {views, 2});
    if (extent(caps, 0) < 2) throw py::value_error("caps needs at least 2 view nodes");
    std::vector<angular::Cap> result;
    for (py::ssize_t k = 0; k < caps.shape(0); ++k) result.push_back({caps.at(k, 0), caps.at(k, 1)});
    return result;
}

// `bands` has to outlive it.
inline angular::ZonalProfiles zonal_of(const Array<float>& profiles, std::span<const angular::Band> bands) {
    require_shape(profiles, "profiles", {any, any, any});
    require_channels(extent(profiles, 1));
    if (extent(profiles, 0) < 2 || extent(profiles, 2) < 3)
        throw py::value_error("profiles needs at least 2 rows and 3 nodes");
    return {view(profiles), bands, extent(profiles, 0), extent(profiles, 1), extent(profiles, 2) - 2};
}

// `caps` have to outlive it. The envelope is (intervals + 2), or with `of_channels` (1 or channels,
// intervals + 2).
inline angular::IsotropicTable isotropic_of(const Array<float>& envelope, const Array<float>& ratio,
                                            std::span<const angular::Cap> caps, bool of_channels = false) {
    if (of_channels)
        require_shape(envelope, "envelope", {any, any});
    else
        require_shape(envelope, "envelope", {any});
    require_shape(ratio, "ratio", {any, any, any, any});
    require_channels(extent(ratio, 1));
    const int nodes = extent(envelope, of_channels ? 1 : 0);
    if (nodes < 3 || extent(ratio, 0) < 2 || extent(ratio, 2) < 3 || extent(ratio, 3) < 3)
        throw py::value_error("envelope and ratio need at least one interval along each axis");
    if (of_channels && extent(envelope, 0) != 1 && extent(envelope, 0) != extent(ratio, 1))
        throw py::value_error("envelope needs one row, or one for each channel");
    return {view(envelope),       view(ratio),         caps,
            extent(ratio, 1),     nodes - 2,           extent(ratio, 0) - 1,
            extent(ratio, 2) - 2, extent(ratio, 3) - 2};
}

}  // namespace shrm::bindings
