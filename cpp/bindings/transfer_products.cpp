#include "shrm/transfer/products.hpp"

#include <optional>

#include <pybind11/stl.h>

#include "ndarray.hpp"
#include "shrm/core.hpp"

namespace shrm::bindings {
namespace {

py::ssize_t rotation_size(py::ssize_t terms) {
    py::ssize_t first = 0, count = 0;
    for (py::ssize_t extent = 1; first < terms; first += extent, extent += 2) count += extent * extent;
    if (first != terms) refuse("harmonics", "have n^2 columns", terms);
    return count;
}

Array<float> sum_visible(const Array<float>& rays, const Array<float>& harmonics, const Array<bool>& visible,
                         const std::optional<Array<float>>& rotations) {
    require_shape(rays, "rays", {any, any});
    require_shape(harmonics, "harmonics", {rays.shape(1), any});
    require_shape(visible, "visible", {any, rays.shape(1)});
    const py::ssize_t vertices = visible.shape(0), terms = harmonics.shape(1);
    if (rotations) require_shape(*rotations, "rotations", {vertices, rotation_size(terms)});
    auto products = allocate<float>({vertices, rays.shape(0), terms});
    const VisibleSizes sizes{extent(visible, 0), extent(rays, 0), extent(rays, 1), extent(harmonics, 1)};
    const std::span<const std::uint8_t> seen(reinterpret_cast<const std::uint8_t*>(visible.data()),
                                             static_cast<std::size_t>(visible.size()));
    const auto Q = view(rays), Y = view(harmonics);
    const auto R = rotations ? view(*rotations) : std::span<const float>();
    const auto out = view(products);
    const py::gil_scoped_release release;
    if (!out.empty()) sum_over_visible(sizes, Q, Y, seen, R, out);
    return products;
}

}  // namespace

void bind_transfer_products(py::module_& module) {
    using namespace py::literals;
    module.def("sum_over_visible", &sum_visible, py::kw_only(), "rays"_a.noconvert(),
               "harmonics"_a.noconvert(), "visible"_a.noconvert(), "rotations"_a.noconvert() = py::none());
}

}  // namespace shrm::bindings
