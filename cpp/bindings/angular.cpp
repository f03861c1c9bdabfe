#include "shrm/angular.hpp"

#include <vector>

#include "ndarray.hpp"
#include "radial_profile.hpp"

namespace shrm::bindings {
namespace {

angular::Picture picture_of(const Array<float>& planes, int subsamples) {
    require_shape(planes, "planes", {3, any, any});
    const int H = extent(planes, 1), W = (extent(planes, 2) - angular::lanes) / 2;
    if (W < 1 || extent(planes, 2) != angular::row_length(W))
        throw py::value_error("planes has rows of " + std::to_string(extent(planes, 2)) +
                              " values, but needs 2 W + " + std::to_string(angular::lanes));
    if (H < 1 || subsamples < 1) throw py::value_error("planes must have rows and subsamples be at least 1");
    return {view(planes), H, W, subsamples};
}

Array<float> radial(const Array<float>& planes, int subsamples, const Array<float>& profile, int shift,
                    double scale, double support, double outer, const Array<double>& centres) {
    const auto picture = picture_of(planes, subsamples);
    const auto table = profile_of(profile, shift, scale, support);
    const auto axes = directions(centres, "centres");
    Array<float> out = allocate<float>({centres.shape(0), 3});
    const std::span<float> result(out.mutable_data(), static_cast<std::size_t>(out.size()));
    {
        const py::gil_scoped_release release;
        angular::integrate_radial(picture, table, outer, axes, result);
    }
    return out;
}

Array<float> radial_map(const Array<float>& planes, int subsamples, const Array<float>& profile, int shift,
                        double scale, double support, double outer, int height, int width, bool symmetry) {
    const auto picture = picture_of(planes, subsamples);
    const auto table = profile_of(profile, shift, scale, support);
    if (height < 1 || width < 1) throw py::value_error("a map needs at least one row and one column");
    Array<float> out = allocate<float>({height, width, 3});
    const std::span<float> result(out.mutable_data(), static_cast<std::size_t>(out.size()));
    {
        const py::gil_scoped_release release;
        angular::integrate_radial_map(picture, table, outer, height, width, symmetry, result);
    }
    return out;
}

std::vector<angular::Cap> caps_of(const Array<double>& caps) {
    std::vector<angular::Cap> result;
    for (py::ssize_t k = 0; k < caps.shape(0); ++k) result.push_back({caps.at(k, 0), caps.at(k, 1)});
    return result;
}

Array<float> half_angle(const Array<float>& planes, int subsamples, const Array<float>& profile, int shift,
                        double scale, double support, const Array<double>& caps, const Array<double>& normals,
                        const Array<double>& views, bool share) {
    const auto picture = picture_of(planes, subsamples);
    const auto table = profile_of(profile, shift, scale, support);
    if (table.channels != 1) throw py::value_error("a half-angle profile has 1 channel");
    require_shape(caps, "caps", {any, 2});
    if (extent(caps, 0) < 2) throw py::value_error("caps needs at least 2 view nodes");
    const auto n = directions(normals, "normals"), v = directions(views, "views");
    require_shape(views, "views", {normals.shape(0), 3});
    const auto ranges = caps_of(caps);
    Array<float> out = allocate<float>({normals.shape(0), 3});
    const std::span<float> result(out.mutable_data(), static_cast<std::size_t>(out.size()));
    {
        const py::gil_scoped_release release;
        angular::integrate_half_angle(picture, table, ranges, n, v, share, result);
    }
    return out;
}

Array<float> zonal(const Array<float>& planes, int subsamples, const Array<float>& profiles,
                   const Array<double>& bands, const Array<double>& axes, const Array<double>& theta_o) {
    const auto picture = picture_of(planes, subsamples);
    require_shape(profiles, "profiles", {any, any, any});
    require_shape(bands, "bands", {profiles.shape(0), 2});
    require_channels(extent(profiles, 1));
    if (extent(profiles, 0) < 2 || extent(profiles, 2) < 3)
        throw py::value_error("profiles needs at least 2 rows and 3 nodes");
    const auto centres = directions(axes, "axes");
    require_shape(theta_o, "theta_o", {axes.shape(0)});
    std::vector<angular::Band> ranges;
    for (py::ssize_t k = 0; k < bands.shape(0); ++k) ranges.push_back({bands.at(k, 0), bands.at(k, 1)});
    const angular::ZonalProfiles table = {view(profiles), ranges, extent(profiles, 0), extent(profiles, 1),
                                          extent(profiles, 2) - 2};
    Array<float> out = allocate<float>({axes.shape(0), 3});
    const std::span<float> result(out.mutable_data(), static_cast<std::size_t>(out.size()));
    {
        const py::gil_scoped_release release;
        angular::integrate_zonal(picture, table, centres, view(theta_o), result);
    }
    return out;
}

Array<float> isotropic(const Array<float>& planes, int subsamples, const Array<float>& envelope,
                       const Array<float>& ratio, const Array<double>& caps, const Array<double>& normals,
                       const Array<double>& views) {
    const auto picture = picture_of(planes, subsamples);
    require_shape(envelope, "envelope", {any});
    require_shape(ratio, "ratio", {any, any, any, any});
    require_channels(extent(ratio, 1));
    require_shape(caps, "caps", {ratio.shape(0), 2});
    if (extent(envelope, 0) < 3 || extent(ratio, 0) < 2 || extent(ratio, 2) < 3 || extent(ratio, 3) < 3)
        throw py::value_error("envelope and ratio need at least one interval along each axis");
    const auto n = directions(normals, "normals"), v = directions(views, "views");
    require_shape(views, "views", {normals.shape(0), 3});
    const auto ranges = caps_of(caps);
    const angular::IsotropicTable table = {view(envelope),
                                           view(ratio),
                                           ranges,
                                           extent(ratio, 1),
                                           extent(envelope, 0) - 2,
                                           extent(ratio, 0) - 1,
                                           extent(ratio, 2) - 2,
                                           extent(ratio, 3) - 2};
    Array<float> out = allocate<float>({normals.shape(0), 3});
    const std::span<float> result(out.mutable_data(), static_cast<std::size_t>(out.size()));
    {
        const py::gil_scoped_release release;
        angular::integrate_isotropic(picture, table, n, v, result);
    }
    return out;
}

}  // namespace

void bind_angular(py::module_& module) {
    module.attr("ANGULAR_LANES") = angular::lanes;
    module.def("angular_radial", radial, py::kw_only(), py::arg("planes").noconvert(), py::arg("subsamples"),
               py::arg("profile").noconvert(), py::arg("shift"), py::arg("scale"), py::arg("support"),
               py::arg("outer"), py::arg("centres").noconvert());
    module.def("angular_radial_map", radial_map, py::kw_only(), py::arg("planes").noconvert(),
               py::arg("subsamples"), py::arg("profile").noconvert(), py::arg("shift"), py::arg("scale"),
               py::arg("support"), py::arg("outer"), py::arg("height"), py::arg("width"),
               py::arg("symmetry"));
    module.def("angular_half_angle", half_angle, py::kw_only(), py::arg("planes").noconvert(),
               py::arg("subsamples"), py::arg("profile").noconvert(), py::arg("shift"), py::arg("scale"),
               py::arg("support"), py::arg("caps").noconvert(), py::arg("normals").noconvert(),
               py::arg("views").noconvert(), py::arg("share"));
    module.def("angular_zonal", zonal, py::kw_only(), py::arg("planes").noconvert(), py::arg("subsamples"),
               py::arg("profiles").noconvert(), py::arg("bands").noconvert(), py::arg("axes").noconvert(),
               py::arg("theta_o").noconvert());
    module.def("angular_isotropic", isotropic, py::kw_only(), py::arg("planes").noconvert(),
               py::arg("subsamples"), py::arg("envelope").noconvert(), py::arg("ratio").noconvert(),
               py::arg("caps").noconvert(), py::arg("normals").noconvert(), py::arg("views").noconvert());
}

}  // namespace shrm::bindings
