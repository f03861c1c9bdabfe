#include "shrm/sh.hpp"

#include "ndarray.hpp"
#include "shrm/core.hpp"

namespace shrm::bindings {
namespace {

Array<double> analysis(const Array<float>& pixels, int F, bool areas) {
    require_shape(pixels, "pixels", {any, any, any});
    require_degree("F", F);
    const int H = extent(pixels, 0), W = extent(pixels, 1), channels = extent(pixels, 2);
    auto coefficients = allocate<double>({ssize(basis_size(F)), channels});
    const auto in = view(pixels);
    const auto out = view(coefficients);
    const py::gil_scoped_release release;
    shrm::analysis(in, H, W, channels, F, areas ? Texel::area : Texel::sample, out);
    return coefficients;
}

Array<float> synthesis(const Array<double>& coefficients, int H, int W) {
    const int F = degree_of(coefficients, "coefficients");
    const int channels = extent(coefficients, 1);
    require_positive("H", H);
    require_positive("W", W);
    auto rings = allocate<float>({H, channels, W});
    const auto in = view(coefficients);
    const auto out = view(rings);
    const py::gil_scoped_release release;
    shrm::synthesis(in, channels, F, H, W, out);
    return rings;
}

template <class Real>
Array<Real> evaluate(const Array<double>& coefficients, const Array<double>& directions) {
    const int F = degree_of(coefficients, "coefficients");
    require_shape(directions, "directions", {any, 3});
    const int channels = extent(coefficients, 1);
    auto values = allocate<Real>({directions.shape(0), channels});
    const auto in = view(coefficients);
    const auto at = vectors(directions);
    const auto out = view(values);
    const py::gil_scoped_release release;
    shrm::evaluate<Real>(in, channels, F, at, out);
    return values;
}

}  // namespace

void bind_sh(py::module_& module) {
    using namespace py::literals;
    module.def("analysis", &analysis, py::kw_only(), "pixels"_a.noconvert(), "F"_a, "areas"_a);
    module.def("synthesis", &synthesis, py::kw_only(), "coefficients"_a.noconvert(), "H"_a, "W"_a);
    module.def("evaluate", &evaluate<double>, py::kw_only(), "coefficients"_a.noconvert(),
               "directions"_a.noconvert());
    module.def("evaluate_float", &evaluate<float>, py::kw_only(), "coefficients"_a.noconvert(),
               "directions"_a.noconvert());
    module.def(
        "fejer_weights",
        [](int H) {
            require_positive("H", H);
            const std::vector<double> weights = fejer_weights(H);
            return Array<double>(ssize(weights.size()), weights.data());
        },
        py::kw_only(), "H"_a);
}

}  // namespace shrm::bindings
