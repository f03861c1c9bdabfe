#include "shrm/transfer/tent_basis.hpp"

#include "ndarray.hpp"
#include "shrm/core.hpp"

namespace shrm::bindings {
namespace {

Array<double> directions_of(const Array<double>& positions) {
    require_shape(positions, "positions", {any, 2});
    auto directions = allocate<double>({positions.shape(0), 3});
    for (py::ssize_t k = 0; k < positions.shape(0); ++k) {
        const glm::dvec3 w = hemisphere_from_square({positions.at(k, 0), positions.at(k, 1)});
        for (int c = 0; c < 3; ++c) directions.mutable_at(k, c) = w[c];
    }
    return directions;
}

py::tuple tents_at(const Array<double>& directions, int M) {
    require_shape(directions, "directions", {any, 3});
    require_at_least("M", M, 2);
    auto indices = allocate<std::int64_t>({directions.shape(0), 4});
    auto weights = allocate<double>({directions.shape(0), 4});
    const auto at = vectors(directions);
    const auto index = view(indices);
    const auto weight = view(weights);
    for (std::size_t k = 0; k < at.size(); ++k) {
        const FourTents four = four_tents(M, at[k]);
        for (std::size_t corner = 0; corner < 4; ++corner) {
            index[4 * k + corner] = static_cast<std::int64_t>(four.indices(M)[corner]);
            weight[4 * k + corner] = four.weights[corner];
        }
    }
    return py::make_tuple(indices, weights);
}

Array<double> sum_of_tents(const Array<double>& coefficients, const Array<double>& directions, int M) {
    require_at_least("M", M, 2);
    require_shape(coefficients, "coefficients", {py::ssize_t(M) * M, any});
    require_shape(directions, "directions", {any, 3});
    const int channels = extent(coefficients, 1);
    return filled<double>({directions.shape(0), channels}, [&](std::span<double> values) {
        evaluate_tents(view(coefficients), channels, M, vectors(directions), values);
    });
}

Array<double> accumulate(const Array<double>& values, const Array<double>& directions, int M) {
    require_at_least("M", M, 2);
    require_shape(directions, "directions", {any, 3});
    require_shape(values, "values", {directions.shape(0), any});
    const int channels = extent(values, 1);
    return filled<double>({py::ssize_t(M) * M, channels}, [&](std::span<double> sums) {
        accumulate_tents(view(values), channels, M, vectors(directions), sums);
    });
}

}  // namespace

void bind_tent_basis(py::module_& module) {
    using namespace py::literals;
    module.def("hemisphere_from_square", &directions_of, py::kw_only(), "positions"_a.noconvert());
    module.def("tents", &tents_at, py::kw_only(), "directions"_a.noconvert(), "M"_a);
    module.def("evaluate_tents", &sum_of_tents, py::kw_only(), "coefficients"_a.noconvert(),
               "directions"_a.noconvert(), "M"_a);
    module.def("accumulate_tents", &accumulate, py::kw_only(), "values"_a.noconvert(),
               "directions"_a.noconvert(), "M"_a);
}

}  // namespace shrm::bindings
