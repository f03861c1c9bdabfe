#include "shrm/transfer/lighting.hpp"

#include <memory>
#include <mutex>
#include <optional>

#include <pybind11/stl.h>

#include "ndarray.hpp"
#include "shrm/core.hpp"

namespace shrm::bindings {
namespace {

constexpr int most_order = 10, most_tents = 33;

// Floats or halves, in C order.
TransferValues require_values(const py::array& array, const char* name,
                              const std::vector<py::ssize_t>& shape) {
    require_shape(array, name, shape);
    const auto count = static_cast<std::size_t>(array.size());
    if (py::isinstance<Array<float>>(array)) return {{static_cast<const float*>(array.data()), count}, {}};
    const bool half = array.dtype().kind() == 'f' && array.itemsize() == 2;
    if (!half || !(array.flags() & py::array::c_style))
        refuse_type(name, "be a contiguous array of float32 or float16", array);
    return {{}, {static_cast<const std::uint16_t*>(array.data()), count}};
}

int require_root(py::ssize_t square, const char* name, const char* needed, int least, int most) {
    const int root = static_cast<int>(std::lround(std::sqrt(static_cast<double>(square))));
    if (py::ssize_t(root) * root != square || root < least || root > most)
        refuse(name,
               std::string("have ") + needed + " in [" + std::to_string(least) + ", " + std::to_string(most) +
                   "]",
               square);
    return root;
}

// n^2, which the light's rows must be.
int require_terms(py::ssize_t terms, const char* name) {
    const int n = require_root(terms, name, "n^2 terms, n", 1, most_order);
    return n * n;
}

int require_M(py::ssize_t tents, const char* name) {
    return require_root(tents, name, "M^2 tents, M", 2, most_tents);
}

Eye eye_of(const Array<float>& at, bool distant) {
    require_shape(at, "eye", {3});
    return {{at.at(0), at.at(1), at.at(2)}, distant};
}

TransferSurface surface_of(const Array<float>& vertices, const Array<float>& frames) {
    require_shape(vertices, "vertices", {any, 3});
    require_shape(frames, "frames", {vertices.shape(0), 3, 3});
    return {view(vertices), view(frames)};
}

void tents(const TransferSurface& surface, const py::array& matrices, const Array<float>& light,
           const Array<float>& eye, bool distant, Array<float>& radiance) {
    const py::ssize_t vertices = surface.vertices();
    require_shape(matrices, "matrices", {vertices, any, any, any});
    const auto values = require_values(matrices, "matrices", {vertices, any, any, any});
    const int M = require_M(matrices.shape(1), "matrices");
    const int channels = require_channels(matrices.shape(2), "matrices");
    require_shape(light, "light", {require_terms(matrices.shape(3), "matrices"), 3});
    require_shape(radiance, "radiance", {vertices, 3});
    const auto in = view(light);
    const auto out = view(radiance);
    const Eye at = eye_of(eye, distant);
    const py::gil_scoped_release release;
    light_tents(surface, values, M, channels, in, at, out);
}

void fixed_tents(const TransferSurface& surface, const Array<float>& coefficients, const Array<float>& eye,
                 bool distant, Array<float>& radiance) {
    require_shape(coefficients, "coefficients", {surface.vertices(), any, 3});
    require_shape(radiance, "radiance", {surface.vertices(), 3});
    const int M = require_M(coefficients.shape(1), "coefficients");
    const auto in = view(coefficients);
    const auto out = view(radiance);
    const Eye at = eye_of(eye, distant);
    const py::gil_scoped_release release;
    light_fixed_tents(surface, in, M, at, out);
}

void rows_of_vertices(const py::array& rows, const Array<float>& light, Array<float>& radiance) {
    const auto values = require_values(rows, "rows", {any, any, any});
    const int channels = require_channels(rows.shape(1), "rows");
    require_shape(light, "light", {require_terms(rows.shape(2), "rows"), 3});
    require_shape(radiance, "radiance", {rows.shape(0), 3});
    const int vertices = extent(rows, 0);
    const auto in = view(light);
    const auto out = view(radiance);
    const py::gil_scoped_release release;
    light_rows(values, vertices, channels, in, out);
}

// Runs for one caller at a time: it works in memory of its own.
struct CompressedPlan {
    CompressedTransfer transfer;
    std::mutex busy;

    void run(const TransferSurface& surface, const Array<float>& light, const Array<float>& eye, bool distant,
             Array<float>& radiance) {
        require_shape(light, "light", {transfer.terms(), 3});
        require_shape(radiance, "radiance", {transfer.vertices(), 3});
        if (surface.vertices() != transfer.vertices())
            refuse("surface", "have " + std::to_string(transfer.vertices()) + " vertices",
                   surface.vertices());
        const auto in = view(light);
        const auto out = view(radiance);
        const Eye at = eye_of(eye, distant);
        const py::gil_scoped_release release;
        const std::lock_guard lock(busy);
        transfer.light(surface, in, at, out);
    }
};

std::unique_ptr<CompressedPlan> compressed_plan(const py::array& weights, const Array<float>& components,
                                                const std::optional<Array<std::int32_t>>& clusters, int K) {
    const auto values = require_values(weights, "weights", {any, any});
    require_shape(components, "components", {any, weights.shape(1), any, any, any});
    const int vertices = extent(weights, 0), Q = extent(components, 0);
    const int M = require_M(components.shape(2), "components");
    const int channels = require_channels(components.shape(3), "components");
    const int terms = require_terms(components.shape(4), "components");
    require_in("K", K, 1, weights.shape(1));
    std::span<const std::int32_t> of_vertices;
    if (clusters) {
        require_shape(*clusters, "clusters", {vertices});
        of_vertices = view(*clusters);
    }
    for (const std::int32_t q : of_vertices) require_in("clusters", q, 0, Q - 1);
    return std::unique_ptr<CompressedPlan>(new CompressedPlan{
        {values, of_vertices, view(components), vertices, Q, extent(weights, 1), K, M, channels, terms}, {}});
}

TransferValues optional_transfer(const std::optional<py::array>& transfer, py::ssize_t vertices, int terms) {
    return transfer ? require_values(*transfer, "transfer", {vertices, terms, terms}) : TransferValues{};
}

void projected(const TransferSurface& surface, const Array<float>& samples, bool parabolic,
               const std::optional<Array<float>>& rotations, const std::optional<py::array>& transfer,
               const Array<float>& light, const Array<float>& eye, bool distant, Array<float>& radiance) {
    require_shape(samples, "samples", {any, any, any, any});
    require_shape(samples, "samples", {samples.shape(0), samples.shape(0), any, any});
    const int side = extent(samples, 0), channels = require_channels(samples.shape(2), "samples");
    require_at_least("the side of the samples", side, 2);
    const int terms = require_terms(samples.shape(3), "samples");
    std::span<const float> bands;
    if (rotations) {
        int values = 0;
        for (int l = 0; l * l < terms; ++l) values += (2 * l + 1) * (2 * l + 1);
        require_shape(*rotations, "rotations", {py::ssize_t(surface.vertices()) * values + rotation_room});
        bands = view(*rotations);
    }
    const TransferValues matrices = optional_transfer(transfer, surface.vertices(), terms);
    require_shape(light, "light", {terms, 3});
    require_shape(radiance, "radiance", {surface.vertices(), 3});
    const auto rows = view(samples), in = view(light);
    const auto out = view(radiance);
    const Eye at = eye_of(eye, distant);
    const py::gil_scoped_release release;
    light_projected(surface, rows, side, parabolic, channels, bands, matrices, in, at, out);
}

void convolved(const TransferSurface& surface, const Array<float>& kernel, bool about_normal,
               const std::optional<py::array>& transfer, const Array<float>& light, const Array<float>& eye,
               bool distant, Array<float>& radiance) {
    require_shape(kernel, "kernel", {any, any});
    const int channels = require_channels(kernel.shape(1), "kernel");
    const int terms = require_terms(kernel.shape(0) * kernel.shape(0), "kernel");
    const TransferValues matrices = optional_transfer(transfer, surface.vertices(), terms);
    require_shape(light, "light", {terms, 3});
    require_shape(radiance, "radiance", {surface.vertices(), 3});
    const auto rho = view(kernel), in = view(light);
    const auto out = view(radiance);
    const Eye at = eye_of(eye, distant);
    const py::gil_scoped_release release;
    light_convolved(surface, rho, channels, about_normal, matrices, in, at, out);
}

}  // namespace

void bind_transfer_lighting(py::module_& module) {
    using namespace py::literals;
    py::class_<TransferSurface>(module, "TransferSurface")
        .def(py::init(&surface_of), py::kw_only(), "vertices"_a.noconvert(), "frames"_a.noconvert());
    module.def("light_tents", &tents, py::kw_only(), "surface"_a, "matrices"_a.noconvert(),
               "light"_a.noconvert(), "eye"_a.noconvert(), "distant"_a, "radiance"_a.noconvert());
    module.def("light_fixed_tents", &fixed_tents, py::kw_only(), "surface"_a, "coefficients"_a.noconvert(),
               "eye"_a.noconvert(), "distant"_a, "radiance"_a.noconvert());
    module.def("light_rows", &rows_of_vertices, py::kw_only(), "rows"_a.noconvert(), "light"_a.noconvert(),
               "radiance"_a.noconvert());
    py::class_<CompressedPlan>(module, "CompressedTransfer")
        .def(py::init(&compressed_plan), py::kw_only(), "weights"_a.noconvert(), "components"_a.noconvert(),
             "clusters"_a.noconvert().none(true), "K"_a)
        .def("run", &CompressedPlan::run, py::kw_only(), "surface"_a, "light"_a.noconvert(),
             "eye"_a.noconvert(), "distant"_a, "radiance"_a.noconvert());
    module.def("light_projected", &projected, py::kw_only(), "surface"_a, "samples"_a.noconvert(),
               "parabolic"_a, "rotations"_a.noconvert().none(true), "transfer"_a.noconvert().none(true),
               "light"_a.noconvert(), "eye"_a.noconvert(), "distant"_a, "radiance"_a.noconvert());
    module.def("light_convolved", &convolved, py::kw_only(), "surface"_a, "kernel"_a.noconvert(),
               "about_normal"_a, "transfer"_a.noconvert().none(true), "light"_a.noconvert(),
               "eye"_a.noconvert(), "distant"_a, "radiance"_a.noconvert());
}

}  // namespace shrm::bindings
