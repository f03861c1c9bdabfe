#include "shrm/angular/angular.hpp"

#include <vector>

#include "lobe_tables.hpp"
#include "ndarray.hpp"

namespace shrm::bindings {
namespace {

angular::Picture picture_of(const Array<float>& planes, int subsamples) {
    require_shape(planes, "planes", {3, any, any});
    const int H = extent(planes, 1), W = (extent(planes, 2) - angular::most_lanes) / 2;
    require_at_least("H", H, 1);
    require_at_least("W", W, 1);
    require_shape(planes, "planes", {3, H, angular::row_length(W)});
    require_at_least("subsamples", subsamples, 1);
    return {view(planes), H, W, subsamples};
}

Array<float> radial(const Array<float>& planes, int subsamples, const Array<float>& profile, int shift,
                    double scale, double support, double outer, const Array<double>& centers) {
    const auto picture = picture_of(planes, subsamples);
    const auto table = profile_of(profile, shift, scale, support);
    const auto axes = unit_vectors(centers, "centers");
    return filled<float>({centers.shape(0), 3}, [&](std::span<float> out) {
        angular::integrate_radial(picture, table, outer, axes, out);
    });
}

Array<float> radial_map(const Array<float>& planes, int subsamples, const Array<float>& profile, int shift,
                        double scale, double support, double outer, int height, int width, bool symmetry) {
    const auto picture = picture_of(planes, subsamples);
    const auto table = profile_of(profile, shift, scale, support);
    require_at_least("height", height, 1);
    require_at_least("width", width, 1);
    return filled<float>({height, width, 3}, [&](std::span<float> out) {
        angular::integrate_radial_map(picture, table, outer, height, width, symmetry, out);
    });
}

Array<float> half_angle(const Array<float>& planes, int subsamples, const Array<float>& profile, int shift,
                        double scale, double support, const Array<double>& caps, const Array<double>& normals,
                        const Array<double>& views, bool share) {
    const auto picture = picture_of(planes, subsamples);
    require_shape(profile, "profile", {1, 4, any});
    const auto table = profile_of(profile, shift, scale, support);
    const auto n = unit_vectors(normals, "normals"), v = unit_vectors(views, "views", normals.shape(0));
    const auto ranges = caps_of(caps, any);
    return filled<float>({normals.shape(0), 3}, [&](std::span<float> out) {
        angular::integrate_half_angle(picture, table, ranges, n, v, share, out);
    });
}

Array<float> zonal(const Array<float>& planes, int subsamples, const Array<float>& profiles,
                   const Array<double>& bands, const Array<double>& axes, const Array<double>& theta_o) {
    const auto picture = picture_of(planes, subsamples);
    const auto ranges = bands_of(bands, "bands", profiles.shape(0));
    const auto table = zonal_of(profiles, ranges);
    const auto centers = unit_vectors(axes, "axes");
    require_shape(theta_o, "theta_o", {axes.shape(0)});
    return filled<float>({axes.shape(0), 3}, [&](std::span<float> out) {
        angular::integrate_zonal(picture, table, centers, view(theta_o), out);
    });
}

Array<float> isotropic(const Array<float>& planes, int subsamples, const Array<float>& envelope,
                       const Array<float>& ratio, const Array<double>& caps, const Array<double>& normals,
                       const Array<double>& views) {
    const auto picture = picture_of(planes, subsamples);
    const auto ranges = caps_of(caps, ratio.shape(0));
    const auto table = isotropic_of(envelope, ratio, ranges);
    const auto n = unit_vectors(normals, "normals"), v = unit_vectors(views, "views", normals.shape(0));
    return filled<float>({normals.shape(0), 3}, [&](std::span<float> out) {
        angular::integrate_isotropic(picture, table, n, v, out);
    });
}

}  // namespace

void bind_angular(py::module_& module) {
    using namespace py::literals;
    module.attr("ANGULAR_LANES") = angular::most_lanes;
    module.def("angular_radial", radial, py::kw_only(), "planes"_a.noconvert(), "subsamples"_a,
               "profile"_a.noconvert(), "shift"_a, "scale"_a, "support"_a, "outer"_a,
               "centers"_a.noconvert());
    module.def("angular_radial_map", radial_map, py::kw_only(), "planes"_a.noconvert(), "subsamples"_a,
               "profile"_a.noconvert(), "shift"_a, "scale"_a, "support"_a, "outer"_a, "height"_a, "width"_a,
               "symmetry"_a);
    module.def("angular_half_angle", half_angle, py::kw_only(), "planes"_a.noconvert(), "subsamples"_a,
               "profile"_a.noconvert(), "shift"_a, "scale"_a, "support"_a, "caps"_a.noconvert(),
               "normals"_a.noconvert(), "views"_a.noconvert(), "share"_a);
    module.def("angular_zonal", zonal, py::kw_only(), "planes"_a.noconvert(), "subsamples"_a,
               "profiles"_a.noconvert(), "bands"_a.noconvert(), "axes"_a.noconvert(),
               "theta_o"_a.noconvert());
    module.def("angular_isotropic", isotropic, py::kw_only(), "planes"_a.noconvert(), "subsamples"_a,
               "envelope"_a.noconvert(), "ratio"_a.noconvert(), "caps"_a.noconvert(), "normals"_a.noconvert(),
               "views"_a.noconvert());
}

}  // namespace shrm::bindings
