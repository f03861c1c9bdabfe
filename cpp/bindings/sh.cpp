#include <memory>
#include <mutex>

#include "ndarray.hpp"
#include "shrm/core.hpp"
#include "shrm/pictures/cube.hpp"
#include "shrm/sh/analysis.hpp"
#include "shrm/sh/cube_synthesis.hpp"
#include "shrm/sh/evaluation.hpp"
#include "shrm/sh/synthesis.hpp"

namespace shrm::bindings {
namespace {

Texel texel(bool areas) {
    return areas ? Texel::area : Texel::sample;
}

Array<double> analysis(const Array<float>& pixels, int F, bool areas) {
    require_shape(pixels, "pixels", {any, any, any});
    require_at_least("F", F, 0);
    const int H = extent(pixels, 0), W = extent(pixels, 1), channels = extent(pixels, 2);
    return filled<double>({ssize(basis_size(F)), channels}, [&](std::span<double> coefficients) {
        Analysis(H, W, channels, F, texel(areas), Tables::transient).run(view(pixels), coefficients);
    });
}

Array<float> synthesis(const Array<double>& coefficients, int H, int W) {
    const int F = degree_of(coefficients, "coefficients");
    const int channels = extent(coefficients, 1);
    require_at_least("H", H, 1);
    require_at_least("W", W, 1);
    return filled<float>({H, channels, W}, [&](std::span<float> rings) {
        Synthesis(H, W, channels, F, Tables::transient).run(view(coefficients), rings);
    });
}

void require_sizes(int H, int W, int channels) {
    require_at_least("H", H, 1);
    require_at_least("W", W, 1);
    require_at_least("channels", channels, 1);
}

void require_even(const char* name, int value) {
    require_at_least(name, value, 2);
    if (value % 2) refuse(name, "be even", value);
}

Array<float> cube_synthesis(const Array<double>& coefficients, int N) {
    const int F = degree_of(coefficients, "coefficients");
    const int channels = extent(coefficients, 1), side = N + 2 * cube_border;
    require_even("N", N);
    return filled<float>({6 * side, channels, side}, [&](std::span<float> rings) {
        CubeSynthesis(N, channels, F).run(view(coefficients), rings);
    });
}

// An array that a plan reads or writes: its name and its shape.
struct Argument {
    const char* name;
    std::vector<py::ssize_t> shape;
};

// A transform with its arguments; runs for one caller at a time, since it works in memory of its own.
template <class Transform, class In, class Out>
struct Plan {
    Transform transform;
    Argument input, output;
    std::mutex busy;

    void run(const Array<In>& from, Array<Out>& to) {
        require_shape(from, input.name, input.shape);
        require_shape(to, output.name, output.shape);
        const auto in = view(from);
        const auto out = view(to);
        const py::gil_scoped_release release;
        const std::lock_guard lock(busy);
        transform.run(in, out);
    }
};
using AnalysisPlan = Plan<Analysis, float, double>;
using SynthesisPlan = Plan<Synthesis, double, float>;
using CubeSynthesisPlan = Plan<CubeSynthesis, double, float>;

Argument coefficients_argument(int F, int channels) {
    return {"coefficients", {ssize(basis_size(F)), channels}};
}

std::unique_ptr<AnalysisPlan> analysis_plan(int H, int W, int channels, int F, bool areas) {
    require_sizes(H, W, channels);
    require_at_least("F", F, 0);
    return std::unique_ptr<AnalysisPlan>(new AnalysisPlan{{H, W, channels, F, texel(areas), Tables::kept},
                                                          {"pixels", {H, W, channels}},
                                                          coefficients_argument(F, channels),
                                                          {}});
}

std::unique_ptr<SynthesisPlan> synthesis_plan(int H, int W, int channels, int F) {
    require_sizes(H, W, channels);
    require_at_least("F", F, 0);
    return std::unique_ptr<SynthesisPlan>(new SynthesisPlan{{H, W, channels, F, Tables::kept},
                                                            coefficients_argument(F, channels),
                                                            {"rings", {H, channels, W}},
                                                            {}});
}

std::unique_ptr<CubeSynthesisPlan> cube_synthesis_plan(int N, int channels, int F) {
    require_even("N", N);
    require_at_least("channels", channels, 1);
    require_at_least("F", F, 0);
    const int side = N + 2 * cube_border;
    return std::unique_ptr<CubeSynthesisPlan>(new CubeSynthesisPlan{
        {N, channels, F}, coefficients_argument(F, channels), {"rings", {6 * side, channels, side}}, {}});
}

Array<double> evaluate(const Array<double>& coefficients, const Array<double>& directions) {
    const int F = degree_of(coefficients, "coefficients");
    require_shape(directions, "directions", {any, 3});
    const int channels = extent(coefficients, 1);
    return filled<double>({directions.shape(0), channels}, [&](std::span<double> values) {
        shrm::evaluate(view(coefficients), channels, F, vectors(directions), values);
    });
}

}  // namespace

void bind_sh(py::module_& module) {
    using namespace py::literals;
    module.def("analysis", &analysis, py::kw_only(), "pixels"_a.noconvert(), "F"_a, "areas"_a);
    module.def("synthesis", &synthesis, py::kw_only(), "coefficients"_a.noconvert(), "H"_a, "W"_a);
    module.def("cube_synthesis", &cube_synthesis, py::kw_only(), "coefficients"_a.noconvert(), "N"_a);
    py::class_<AnalysisPlan>(module, "Analysis")
        .def(py::init(&analysis_plan), py::kw_only(), "H"_a, "W"_a, "channels"_a, "F"_a, "areas"_a)
        .def("run", &AnalysisPlan::run, "pixels"_a.noconvert(), "coefficients"_a.noconvert(), py::pos_only());
    py::class_<SynthesisPlan>(module, "Synthesis")
        .def(py::init(&synthesis_plan), py::kw_only(), "H"_a, "W"_a, "channels"_a, "F"_a)
        .def("run", &SynthesisPlan::run, "coefficients"_a.noconvert(), "rings"_a.noconvert(), py::pos_only());
    py::class_<CubeSynthesisPlan>(module, "CubeSynthesis")
        .def(py::init(&cube_synthesis_plan), py::kw_only(), "N"_a, "channels"_a, "F"_a)
        .def("run", &CubeSynthesisPlan::run, "coefficients"_a.noconvert(), "rings"_a.noconvert(),
             py::pos_only());
    module.def("evaluate", &evaluate, py::kw_only(), "coefficients"_a.noconvert(),
               "directions"_a.noconvert());
    module.def(
        "fejer_weights",
        [](int H) {
            require_at_least("H", H, 1);
            const std::vector<double> weights = fejer_weights(H);
            return Array<double>(ssize(weights.size()), weights.data());
        },
        py::kw_only(), "H"_a);
}

}  // namespace shrm::bindings
