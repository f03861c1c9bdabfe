#include "shrm/hierarchical/hierarchical.hpp"

#include <limits>
#include <memory>

#include "lobe_tables.hpp"
#include "ndarray.hpp"

namespace shrm::bindings {
namespace {

std::unique_ptr<Pyramid> pyramid_of(const Array<float>& pixels) {
    require_shape(pixels, "pixels", {any, any, 3});
    if (pixels.size() == 0) refuse("pixels", "have at least one texel", shape_text(pixels));
    const auto in = view(pixels);
    const py::gil_scoped_release release;
    return std::make_unique<Pyramid>(in, extent(pixels, 0), extent(pixels, 1));
}

// Runs integrate(out) for as many targets: their radiance, and the evaluations that it took.
template <class Integrate>
py::tuple descended(py::ssize_t targets, const Integrate& integrate) {
    Array<float> out = allocate<float>({targets, 3});
    const auto result = view(out);
    hierarchical::Effort effort{};
    {
        const py::gil_scoped_release release;
        effort = integrate(result);
    }
    return py::make_tuple(out, effort.evaluations);
}

py::tuple descend_radial(const Pyramid& pyramid, const Array<float>& profile, int shift, double scale,
                         double support, double outer, double threshold, double integral, double finest,
                         const Array<double>& centers) {
    const auto table = profile_of(profile, shift, scale, support);
    const auto targets = unit_vectors(centers, "centers");
    return descended(centers.shape(0), [&](std::span<float> out) {
        return hierarchical::integrate_radial(pyramid, table, outer, {threshold, integral, finest}, targets,
                                              out);
    });
}

py::tuple descend_zonal(const Pyramid& pyramid, const Array<float>& profiles, const Array<double>& bands,
                        const Array<double>& supports, double threshold, double integral, double finest,
                        const Array<double>& axes, const Array<double>& theta_o) {
    const auto inner = bands_of(bands, "bands", profiles.shape(0));
    const auto whole = bands_of(supports, "supports", profiles.shape(0));
    const auto table = zonal_of(profiles, inner);
    const auto targets = unit_vectors(axes, "axes");
    require_shape(theta_o, "theta_o", {axes.shape(0)});
    return descended(axes.shape(0), [&](std::span<float> out) {
        return hierarchical::integrate_zonal(pyramid, table, whole, {threshold, integral, finest}, targets,
                                             view(theta_o), out);
    });
}

py::tuple descend_isotropic(const Pyramid& pyramid, const Array<float>& envelope, const Array<float>& ratio,
                            const Array<double>& caps, double threshold, double integral, double finest,
                            const Array<double>& normals, const Array<double>& views, double above,
                            double below) {
    if (!(above >= 0)) refuse("above", "be at least 0", above);
    require_positive("below", below);
    const auto ranges = caps_of(caps, ratio.shape(0));
    const auto table = isotropic_of(envelope, ratio, ranges, true);
    const auto n = unit_vectors(normals, "normals"), v = unit_vectors(views, "views");
    require_shape(views, "views", {normals.shape(0), 3});
    return descended(normals.shape(0), [&](std::span<float> out) {
        return hierarchical::integrate_isotropic(pyramid, table, {above, below},
                                                 {threshold, integral, finest}, n, v, out);
    });
}

}  // namespace

void bind_hierarchical(py::module_& module) {
    using namespace py::literals;
    py::class_<Pyramid>(module, "Pyramid")
        .def(py::init(&pyramid_of), "pixels"_a.noconvert(), py::pos_only())
        .def_property_readonly("levels", &Pyramid::levels);
    module.attr("HIERARCHICAL_BLOCK") = hierarchical::block;
    module.def("hierarchical_radial", descend_radial, py::kw_only(), "pyramid"_a, "profile"_a.noconvert(),
               "shift"_a, "scale"_a, "support"_a, "outer"_a, "threshold"_a, "integral"_a, "finest"_a,
               "centers"_a.noconvert());
    module.def("hierarchical_zonal", descend_zonal, py::kw_only(), "pyramid"_a, "profiles"_a.noconvert(),
               "bands"_a.noconvert(), "supports"_a.noconvert(), "threshold"_a, "integral"_a, "finest"_a,
               "axes"_a.noconvert(), "theta_o"_a.noconvert());
    module.def("hierarchical_isotropic", descend_isotropic, py::kw_only(), "pyramid"_a,
               "envelope"_a.noconvert(), "ratio"_a.noconvert(), "caps"_a.noconvert(), "threshold"_a,
               "integral"_a, "finest"_a, "normals"_a.noconvert(), "views"_a.noconvert(), "above"_a = 0.0,
               "below"_a = std::numeric_limits<double>::infinity());
}

}  // namespace shrm::bindings
