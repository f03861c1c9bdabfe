#include "shrm/brdf/brdf_analysis.hpp"

#include "ndarray.hpp"

namespace shrm::bindings {
namespace {

Array<double> legendre(int F, int m, const Array<double>& theta) {
    require_at_least("F", F, 0);
    require_at_least("m", m, 0);
    require_shape(theta, "theta", {any});
    auto values = allocate<double>({F + 1, theta.shape(0)});
    shrm::legendre(F, m, view(theta), view(values));
    return values;
}

py::tuple directions(const Array<double>& theta_v, const Array<double>& gamma, const Array<double>& theta_i,
                     const Array<double>& arc, const Array<double>& share) {
    require_shape(theta_v, "theta_v", {any});
    require_shape(share, "share", {any});
    const py::ssize_t views = theta_v.shape(0), K = share.shape(0);
    require_shape(gamma, "gamma", {views});
    require_shape(theta_i, "theta_i", {views, any});
    const py::ssize_t I = theta_i.shape(1);
    require_shape(arc, "arc", {views, I});
    auto wi = allocate<double>({3, views, K, I}), wo = allocate<double>({3, views, K, I});
    shrm::directions({extent(theta_i, 1), view(theta_i), view(arc), view(share)}, view(theta_v), view(gamma),
                     view(wi), view(wo));
    return py::make_tuple(wi, wo);
}

py::tuple project(const Array<double>& rho_hat, const Array<double>& theta_i,
                  const Array<double>& weight_theta, const Array<double>& arc, const Array<double>& share,
                  const Array<double>& weight_share, int L, int Q) {
    require_shape(rho_hat, "rho_hat", {any, any, any, any});
    const py::ssize_t views = rho_hat.shape(0), K = rho_hat.shape(1), I = rho_hat.shape(2),
                      channels = rho_hat.shape(3);
    require_shape(theta_i, "theta_i", {views, I});
    require_shape(weight_theta, "weight_theta", {views, I});
    require_shape(arc, "arc", {views, I});
    require_shape(share, "share", {K});
    require_shape(weight_share, "weight_share", {K});
    require_at_least("L", L, 0);
    require_at_least("Q", Q, 0);
    const TransferTable table{.views = extent(rho_hat, 0),
                              .K = extent(rho_hat, 1),
                              .I = extent(rho_hat, 2),
                              .channels = extent(rho_hat, 3),
                              .rho_hat = view(rho_hat),
                              .theta_i = view(theta_i),
                              .weight_theta = view(weight_theta),
                              .arc = view(arc),
                              .share = view(share),
                              .weight_share = view(weight_share)};
    auto g = allocate<double>({channels, Q + 1, L + 1, views});
    auto energy = allocate<double>({channels, views});
    const auto g_out = view(g), energy_out = view(energy);
    {
        const py::gil_scoped_release release;
        shrm::project(table, L, Q, g_out, energy_out);
    }
    return py::make_tuple(g, energy);
}

}  // namespace

void bind_brdf_analysis(py::module_& module) {
    using namespace py::literals;
    module.def("legendre", &legendre, py::kw_only(), "F"_a, "m"_a, "theta"_a.noconvert());
    module.def("directions", &directions, py::kw_only(), "theta_v"_a.noconvert(), "gamma"_a.noconvert(),
               "theta_i"_a.noconvert(), "arc"_a.noconvert(), "share"_a.noconvert());
    module.def("project", &project, py::kw_only(), "rho_hat"_a.noconvert(), "theta_i"_a.noconvert(),
               "weight_theta"_a.noconvert(), "arc"_a.noconvert(), "share"_a.noconvert(),
               "weight_share"_a.noconvert(), "L"_a, "Q"_a);
}

}  // namespace shrm::bindings
