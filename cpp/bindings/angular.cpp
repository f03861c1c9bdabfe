#include "shrm/angular/angular.hpp"

#include <vector>

#include "lobe_tables.hpp"
#include "ndarray.hpp"

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
                    double scale, double support, double outer, const Array<double>& centers) {
    const auto picture = picture_of(planes, subsamples);
    const auto table = profile_of(profile, shift, scale, support);
    const auto axes = unit_vectors(centers, "centers");
    Array<float> out = allocate<float>({centers.shape(0), 3});
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

Array<float> half_angle(const Array<float>& planes, int subsamples, const Array<float>& profile, int shift,
                        double scale, double support, const Array<double>& caps, const Array<double>& normals,
                        const Array<double>& views, bool share) {
    const auto picture = picture_of(planes, subsamples);
    const auto table = profile_of(profile, shift, scale, support);
    if (table.channels != 1) throw py::value_error("a half-angle profile has 1 channel");
    const auto n = unit_vectors(normals, "normals"), v = unit_vectors(views, "views");
    require_shape(views, "views", {normals.shape(0), 3});
    const auto ranges = caps_of(caps, any);
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
    const auto ranges = bands_of(bands, "bands", profiles.shape(0));
    const auto table = zonal_of(profiles, ranges);
    const auto centers = unit_vectors(axes, "axes");
    require_shape(theta_o, "theta_o", {axes.shape(0)});
    Array<float> out = allocate<float>({axes.shape(0), 3});
    const std::span<float> result(out.mutable_data(), static_cast<std::size_t>(out.size()));
    {
        const py::gil_scoped_release release;
        angular::integrate_zonal(picture, table, centers, view(theta_o), result);
    }
    return out;
}

Array<float> isotropic(const Array<float>& planes, int subsamples, const Array<float>& envelope,
                       const Array<float>& ratio, const Array<double>& caps, const Array<double>& normals,
                       const Array<double>& views) {
    const auto picture = picture_of(planes, subsamples);
    const auto ranges = caps_of(caps, ratio.shape(0));
    const auto table = isotropic_of(envelope, ratio, ranges);
    const auto n = unit_vectors(normals, "normals"), v = unit_vectors(views, "views");
    require_shape(views, "views", {normals.shape(0), 3});
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
               py::arg("outer"), py::arg("centers").noconvert());
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
