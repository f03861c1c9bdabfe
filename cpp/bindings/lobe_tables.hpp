// Arguments of the two integrators: directions, and the tables of lobes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "ndarray.hpp"
#include "shrm/angular/angular.hpp"

namespace shrm::bindings {

inline std::vector<glm::dvec3> unit_vectors(const Array<double>& array, const char* name,
                                            py::ssize_t count = any) {
    require_shape(array, name, {count, 3});
    const auto a = array.unchecked<2>();
    std::vector<glm::dvec3> result(static_cast<std::size_t>(a.shape(0)));
    for (py::ssize_t k = 0; k < a.shape(0); ++k)
        result[static_cast<std::size_t>(k)] = {a(k, 0), a(k, 1), a(k, 2)};
    return result;
}

inline angular::RadialProfile profile_of(const Array<float>& profile, int shift, double scale,
                                         double support) {
    require_shape(profile, "profile", {any, 4, any});
    require_channels(profile.shape(0), "profile");
    const int segments = extent(profile, 2);
    require_in("shift", shift, 0, 22);
    if (segments < 32 || (segments & (segments - 1)) != 0)
        refuse("profile", "have a power of two of segments, 32 or more", segments);
    if (segments >> (23 - shift) > 100)
        refuse("profile", "have segments for at most 100 octaves", segments >> (23 - shift));
    require_positive("scale", scale);
    require_positive("support", support);
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
    require_at_least("the number of caps", extent(caps, 0), 2);
    std::vector<angular::Cap> result;
    for (py::ssize_t k = 0; k < caps.shape(0); ++k) result.push_back({caps.at(k, 0), caps.at(k, 1)});
    return result;
}

// `bands` has to outlive it.
inline angular::ZonalProfiles zonal_of(const Array<float>& profiles, std::span<const angular::Band> bands) {
    require_shape(profiles, "profiles", {any, any, any});
    require_channels(profiles.shape(1), "profiles");
    require_at_least("the number of profiles", extent(profiles, 0), 2);
    require_at_least("the number of a profile's nodes", extent(profiles, 2), 3);
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
    require_channels(ratio.shape(1), "ratio");
    const int nodes = extent(envelope, of_channels ? 1 : 0);
    require_at_least("the number of the envelope's nodes", nodes, 3);
    require_at_least("the number of the ratio's views", extent(ratio, 0), 2);
    for (int axis : {2, 3}) require_at_least("the number of the ratio's nodes", extent(ratio, axis), 3);
    if (of_channels && extent(envelope, 0) != 1) require_shape(envelope, "envelope", {ratio.shape(1), nodes});
    return {view(envelope),       view(ratio),         caps,
            extent(ratio, 1),     nodes - 2,           extent(ratio, 0) - 1,
            extent(ratio, 2) - 2, extent(ratio, 3) - 2};
}

}  // namespace shrm::bindings
