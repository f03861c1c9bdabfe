#include "shrm/hierarchical.hpp"

#include <memory>

#include "ndarray.hpp"
#include "radial_profile.hpp"

namespace shrm::bindings {
namespace {

std::unique_ptr<Pyramid> pyramid_of(const Array<float>& pixels) {
    require_shape(pixels, "pixels", {any, any, 3});
    if (pixels.size() == 0) throw py::value_error("pixels are none");
    const auto in = view(pixels);
    const py::gil_scoped_release release;
    return std::make_unique<Pyramid>(in, extent(pixels, 0), extent(pixels, 1));
}

py::tuple radial(const Pyramid& pyramid, const Array<float>& profile, int shift, double scale, double support,
                 double integral, double threshold, double outer, double finest,
                 const Array<double>& centres) {
    const auto table = profile_of(profile, shift, scale, support);
    const auto targets = directions(centres, "centres");
    Array<float> out = allocate<float>({centres.shape(0), 3});
    const auto result = view(out);
    hierarchical::Effort effort{};
    {
        const py::gil_scoped_release release;
        effort = hierarchical::integrate_radial(pyramid, table, integral, {threshold, outer, finest}, targets,
                                                result);
    }
    return py::make_tuple(out, effort.evaluations);
}

}  // namespace

void bind_hierarchical(py::module_& module) {
    using namespace py::literals;
    py::class_<Pyramid>(module, "Pyramid")
        .def(py::init(&pyramid_of), "pixels"_a.noconvert(), py::pos_only())
        .def_property_readonly("levels", &Pyramid::levels);
    module.attr("HIERARCHICAL_BLOCK") = hierarchical::block;
    module.def("hierarchical_radial", radial, py::kw_only(), "pyramid"_a, "profile"_a.noconvert(), "shift"_a,
               "scale"_a, "support"_a, "integral"_a, "threshold"_a, "outer"_a, "finest"_a,
               "centres"_a.noconvert());
}

}  // namespace shrm::bindings
