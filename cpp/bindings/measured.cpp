#include <array>
#include <memory>

#include <pybind11/stl.h>

#include "ndarray.hpp"
#include "shrm/brdf/adaptive_parameterization.hpp"
#include "shrm/brdf/angle_table.hpp"

namespace shrm::bindings {
namespace {

// (n, 3) of any strides: an analysis has the three components apart.
using Directions = py::array_t<double, 0>;

StridedVectors strided(const Directions& array, const char* name) {
    require_shape(array, name, {any, 3});
    const py::ssize_t row = array.strides(0), component = array.strides(1);
    constexpr py::ssize_t width = sizeof(double);
    if (row % width != 0 || component % width != 0)
        refuse(name, "have strides in whole numbers", shape_text({array.strides(), 2}) + " bytes");
    return {array.data(), row / width, component / width};
}

DirectionPairs pairs_of(const Directions& wi, const Directions& wo) {
    const StridedVectors i = strided(wi, "wi"), o = strided(wo, "wo");
    require_shape(wo, "wo", {wi.shape(0), 3});
    return {i, o, static_cast<std::size_t>(wi.shape(0))};
}

AngleAxes axes_of(const std::string& axes, const std::array<int, 3>& shape, bool square_root, bool centers) {
    for (int n : shape) require_at_least("the number of the table's nodes", n, 2);
    if (axes != "angles" && axes != "half-angle") refuse("axes", "be angles or half-angle", axes);
    return {axes == "angles" ? Angles::difference : Angles::half,
            {shape[0], shape[1], shape[2]},
            square_root,
            centers};
}

template <class T>
Array<double> interpolate_angles(const Array<T>& table, const std::string& axes, bool square_root,
                                 bool centers, const Directions& wi, const Directions& wo) {
    require_shape(table, "table", {any, any, any, any});
    const int channels = require_channels(table.shape(3), "table");
    const AngleAxes of_table =
        axes_of(axes, {extent(table, 0), extent(table, 1), extent(table, 2)}, square_root, centers);
    const DirectionPairs pairs = pairs_of(wi, wo);
    return filled<double>({wi.shape(0), channels}, [&](std::span<double> values) {
        shrm::interpolate<T>(of_table, channels, view(table), pairs, values);
    });
}

Array<std::int64_t> nearest_angles(const std::array<int, 3>& shape, const std::string& axes, bool square_root,
                                   bool centers, const Directions& wi, const Directions& wo) {
    const AngleAxes of_table = axes_of(axes, shape, square_root, centers);
    const DirectionPairs pairs = pairs_of(wi, wo);
    return filled<std::int64_t>(
        {wi.shape(0)}, [&](std::span<std::int64_t> nodes) { nearest_nodes(of_table, pairs, nodes); });
}

AdaptiveParameterization::Square square(const py::array& array, const char* name, int rows, int columns) {
    const AdaptiveParameterization::Square extents{extent(array, rows), extent(array, columns)};
    if (extents.rows < 2 || extents.columns < 2)
        refuse(name, "have at least two rows and two columns", shape_text(array));
    return extents;
}

std::unique_ptr<AdaptiveParameterization> adaptive_parameterization(const Array<double>& theta_i,
                                                                    const Array<float>& vndf,
                                                                    const Array<float>& values,
                                                                    const Array<float>& ndf,
                                                                    const Array<float>& sigma) {
    require_shape(theta_i, "theta_i", {any});
    require_at_least("the number of theta_i", theta_i.shape(0), 1);
    require_shape(vndf, "vndf", {theta_i.shape(0), any, any});
    require_shape(values, "values", {theta_i.shape(0), any, any, 3});
    require_shape(ndf, "ndf", {any, any});
    require_shape(sigma, "sigma", {any});
    const bool has_ndf = ndf.size() > 0;
    if (has_ndf) require_at_least("the number of sigma's values", sigma.shape(0), 2);
    return std::make_unique<AdaptiveParameterization>(
        view(theta_i), view(vndf), square(vndf, "vndf", 1, 2), view(values), square(values, "values", 1, 2),
        view(ndf), has_ndf ? square(ndf, "ndf", 0, 1) : AdaptiveParameterization::Square{}, view(sigma));
}

// A method of the parameterization that makes (n, 3) of n pairs.
template <void (AdaptiveParameterization::*method)(const DirectionPairs&, std::span<double>) const>
Array<double> of_pairs(const AdaptiveParameterization& table, const Directions& wi, const Directions& wo) {
    const DirectionPairs pairs = pairs_of(wi, wo);
    return filled<double>({wi.shape(0), 3},
                          [&](std::span<double> values) { (table.*method)(pairs, values); });
}

}  // namespace

void bind_measured(py::module_& module) {
    using namespace py::literals;
    module.def("interpolate_angles", &interpolate_angles<float>, py::kw_only(), "table"_a.noconvert(),
               "axes"_a, "square_root"_a, "centers"_a, "wi"_a.noconvert(), "wo"_a.noconvert());
    module.def("interpolate_angles", &interpolate_angles<double>, py::kw_only(), "table"_a.noconvert(),
               "axes"_a, "square_root"_a, "centers"_a, "wi"_a.noconvert(), "wo"_a.noconvert());
    module.def("nearest_angles", &nearest_angles, py::kw_only(), "shape"_a, "axes"_a, "square_root"_a,
               "centers"_a, "wi"_a.noconvert(), "wo"_a.noconvert());
    py::class_<AdaptiveParameterization>(module, "AdaptiveParameterization")
        .def(py::init(&adaptive_parameterization), py::kw_only(), "theta_i"_a.noconvert(),
             "vndf"_a.noconvert(), "values"_a.noconvert(), "ndf"_a.noconvert(), "sigma"_a.noconvert())
        .def("evaluate", &of_pairs<&AdaptiveParameterization::evaluate>, py::kw_only(), "wi"_a.noconvert(),
             "wo"_a.noconvert())
        .def("samples", &of_pairs<&AdaptiveParameterization::samples>, py::kw_only(), "wi"_a.noconvert(),
             "wo"_a.noconvert());
}

}  // namespace shrm::bindings
