#include "shrm/wigner.hpp"

#include "ndarray.hpp"

namespace shrm::bindings {
namespace {

Array<double> rotate(const Array<double>& coefficients, const Array<double>& R) {
    const int F = degree_of(coefficients, "coefficients");
    require_shape(R, "R", {3, 3});
    const int channels = extent(coefficients, 1);
    glm::dmat3 rotation;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) rotation[column][row] = R.at(row, column);
    auto rotated = allocate<double>({coefficients.shape(0), channels});
    const auto in = view(coefficients);
    const auto out = view(rotated);
    const py::gil_scoped_release release;
    shrm::rotate(in, channels, F, rotation, out);
    return rotated;
}

// d^l_{mq}(alpha), one value per l from 0 to F (zero below max(|m|, |q|)): for tests of the recurrence.
Array<double> wigner_d(int m, int q, int F, double alpha) {
    require_degree("F", F);
    Array<double> values(F + 1);
    double* d = values.mutable_data();
    std::fill_n(d, F + 1, 0.);
    const WignerRecurrence recurrence(m, q, F);
    const int first = recurrence.first_degree();
    if (first > F) return values;
    d[first] = recurrence.start(std::cos(alpha / 2), std::sin(alpha / 2));
    for (int l = first; l < F; ++l) {
        const auto [a, b, c] = recurrence.step(l);
        d[l + 1] = (a * std::cos(alpha) + b) * d[l] - (l > first ? c * d[l - 1] : 0);
    }
    return values;
}

}  // namespace

void bind_wigner(py::module_& module) {
    using namespace py::literals;
    module.def("rotate", &rotate, py::kw_only(), "coefficients"_a.noconvert(), "R"_a.noconvert());
    module.def("wigner_d", &wigner_d, py::kw_only(), "m"_a, "q"_a, "F"_a, "alpha"_a);
}

}  // namespace shrm::bindings
