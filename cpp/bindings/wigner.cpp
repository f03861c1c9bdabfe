#include "shrm/sh/wigner.hpp"

#include <memory>
#include <mutex>

#include "ndarray.hpp"
#include "shrm/core.hpp"
#include "shrm/sh/rotation.hpp"

namespace shrm::bindings {
namespace {

glm::dmat3 matrix(const Array<double>& R) {
    require_shape(R, "R", {3, 3});
    glm::dmat3 columns;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) columns[column][row] = R.at(row, column);
    return columns;
}

Array<double> rotate(const Array<double>& coefficients, const Array<double>& R) {
    const int F = degree_of(coefficients, "coefficients");
    const int channels = extent(coefficients, 1);
    const glm::dmat3 rotation = matrix(R);
    return filled<double>({coefficients.shape(0), channels}, [&](std::span<double> rotated) {
        Rotation(F, channels).run(view(coefficients), rotation, rotated);
    });
}

// Runs for one caller at a time: it works in memory of its own.
struct RotationPlan {
    int F, channels;
    Rotation rotation;
    std::mutex busy;

    void run(const Array<double>& coefficients, const Array<double>& R, Array<double>& rotated) {
        require_shape(coefficients, "coefficients", {ssize(basis_size(F)), channels});
        require_shape(rotated, "rotated", {ssize(basis_size(F)), channels});
        const glm::dmat3 by = matrix(R);
        const auto in = view(coefficients);
        const auto out = view(rotated);
        const py::gil_scoped_release release;
        const std::lock_guard lock(busy);
        rotation.run(in, by, out);
    }
};

std::unique_ptr<RotationPlan> rotation_plan(int F, int channels) {
    require_at_least("F", F, 0);
    require_at_least("channels", channels, 1);
    return std::unique_ptr<RotationPlan>(new RotationPlan{F, channels, {F, channels}, {}});
}

// d^l_{mq}(alpha), one value per l from 0 to F (zero below max(|m|, |q|)): for tests of the recurrence.
Array<double> wigner_d(int m, int q, int F, double alpha) {
    require_at_least("F", F, 0);
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
    py::class_<RotationPlan>(module, "Rotation")
        .def(py::init(&rotation_plan), py::kw_only(), "F"_a, "channels"_a)
        .def("run", &RotationPlan::run, "coefficients"_a.noconvert(), "R"_a.noconvert(),
             "rotated"_a.noconvert(), py::pos_only());
    module.def("wigner_d", &wigner_d, py::kw_only(), "m"_a, "q"_a, "F"_a, "alpha"_a);
}

}  // namespace shrm::bindings
