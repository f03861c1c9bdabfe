#include "shrm/reflection_map.hpp"

#include "ndarray.hpp"
#include "shrm/core.hpp"

namespace shrm::bindings {
namespace {

struct Orders {
    int F, P, channels;
};

Orders require_orders(const Array<double>& light, const Array<double>& rho) {
    const int F = degree_of(light, "light");
    require_shape(rho, "rho", {F + 1, any, rho.ndim() == 4 ? rho.shape(1) : any, light.shape(1)});
    return {F, extent(rho, 1) - 1, extent(light, 1)};
}

Array<float> local_reflection_map(const Array<double>& light, const Array<double>& rho, int H, int W) {
    const auto [F, P, channels] = require_orders(light, rho);
    require_positive("H", H);
    require_positive("W", W);
    auto rings = allocate<float>({H, ssize(basis_size(P)), channels, W});
    const auto L = view(light), r = view(rho);
    const auto out = view(rings);
    const py::gil_scoped_release release;
    shrm::local_reflection_map(L, r, F, P, channels, H, W, out);
    return rings;
}

Array<float> global_from_local(const Array<float>& local) {
    require_shape(local, "local", {any, any, any, any});
    const int H = extent(local, 0), W = extent(local, 3), channels = extent(local, 2);
    const int P = static_cast<int>(std::lround(std::sqrt(static_cast<double>(local.shape(1))))) - 1;
    if (P < 0 || basis_size(P) != static_cast<std::size_t>(local.shape(1)))
        throw py::value_error("local has " + std::to_string(local.shape(1)) + " maps, but needs (P+1)^2");
    auto global = allocate<float>({H, local.shape(1), channels, W});
    const auto in = view(local);
    const auto out = view(global);
    const py::gil_scoped_release release;
    shrm::global_from_local(in, P, channels, H, W, out);
    return global;
}

Array<double> global_coefficients(const Array<double>& light, const Array<double>& rho) {
    const auto [F, P, channels] = require_orders(light, rho);
    auto coefficients = allocate<double>({ssize(basis_size(F + P)), ssize(basis_size(P)), channels});
    const auto L = view(light), r = view(rho);
    const auto out = view(coefficients);
    const py::gil_scoped_release release;
    shrm::global_coefficients(L, r, F, P, channels, out);
    return coefficients;
}

}  // namespace

void bind_reflection_map(py::module_& module) {
    using namespace py::literals;
    module.def("local_reflection_map", &local_reflection_map, py::kw_only(), "light"_a.noconvert(), "rho"_a.noconvert(),
               "H"_a, "W"_a);
    module.def("global_from_local", &global_from_local, py::kw_only(), "local"_a.noconvert());
    module.def("global_coefficients", &global_coefficients, py::kw_only(), "light"_a.noconvert(), "rho"_a.noconvert());
}

}  // namespace shrm::bindings
