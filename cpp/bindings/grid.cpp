#include <string>

#include "ndarray.hpp"
#include "shrm/pictures/grid.hpp"

namespace shrm::bindings {

namespace {

py::tuple rays(const std::string& layout, int height, int width, const Array<double>& positions) {
    require_shape(positions, "positions", {any, 2});
    const Layout map = make_layout(layout, height, width);
    const py::ssize_t n = positions.shape(0);
    auto directions = allocate<double>({n, 3});
    auto densities = allocate<double>({n});
    const auto p = positions.unchecked<2>();
    auto d = directions.mutable_unchecked<2>();
    auto density = densities.mutable_unchecked<1>();
    {
        const py::gil_scoped_release release;
        for (py::ssize_t k = 0; k < n; ++k) {
            const Ray ray = std::visit([&](const auto& m) { return m.ray(p(k, 0), p(k, 1)); }, map);
            for (int c = 0; c < 3; ++c) d(k, c) = ray.direction[c];
            density(k) = ray.density;
        }
    }
    return py::make_tuple(directions, densities);
}

Array<double> positions(const std::string& layout, int height, int width, const Array<double>& directions) {
    require_shape(directions, "directions", {any, 3});
    const Layout map = make_layout(layout, height, width);
    const py::ssize_t n = directions.shape(0);
    auto result = allocate<double>({n, 2});
    const auto d = directions.unchecked<2>();
    auto p = result.mutable_unchecked<2>();
    {
        const py::gil_scoped_release release;
        for (py::ssize_t k = 0; k < n; ++k) {
            const glm::dvec3 direction{d(k, 0), d(k, 1), d(k, 2)};
            const glm::dvec2 at = std::visit([&](const auto& m) { return m.position(direction); }, map);
            p(k, 0) = at.x;
            p(k, 1) = at.y;
        }
    }
    return result;
}

Array<double> texel_solid_angles(const std::string& layout, int height, int width) {
    const Layout map = make_layout(layout, height, width);
    auto result = allocate<double>({height, width});
    const py::gil_scoped_release release;
    const std::vector<double> areas = solid_angles(map, height, width);
    std::copy(areas.begin(), areas.end(), result.mutable_data());
    return result;
}

py::tuple convert(const Array<float>& pixels, const std::string& source, const std::string& target,
                  int height, int width, const Array<double>& rotation) {
    require_shape(pixels, "pixels", {any, any, any});
    require_shape(rotation, "rotation", {3, 3});
    const int h = extent(pixels, 0), w = extent(pixels, 1), channels = extent(pixels, 2);
    const Picture from{make_layout(source, h, w), h, w},
        to{make_layout(target, height, width), height, width};
    glm::dmat3 target_from_source;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) target_from_source[column][row] = rotation.at(row, column);
    auto result = allocate<float>({height, width, channels});
    const std::span<const float> in(pixels.data(), static_cast<std::size_t>(pixels.size()));
    const std::span<float> out(result.mutable_data(), static_cast<std::size_t>(result.size()));
    double residual = 0;
    {
        const py::gil_scoped_release release;
        const Conversion conversion(from, to, target_from_source);
        conversion.apply(in, channels, out);
        residual = conversion.residual();
    }
    return py::make_tuple(result, residual);
}

}  // namespace

void bind_grid(py::module_& module) {
    using py::arg;
    module.def("rays", &rays, py::kw_only(), arg("layout"), arg("height"), arg("width"),
               arg("positions").noconvert(),
               "(n, 2) positions (x, y) -> (n, 3) directions, (n,) sr per texel");
    module.def("positions", &positions, py::kw_only(), arg("layout"), arg("height"), arg("width"),
               arg("directions").noconvert(), "(n, 3) unit directions -> (n, 2) positions (x, y)");
    module.def("solid_angles", &texel_solid_angles, py::kw_only(), arg("layout"), arg("height"), arg("width"),
               "(H, W) steradians");
    module.def("convert", &convert, py::kw_only(), arg("pixels").noconvert(), arg("source"), arg("target"),
               arg("height"), arg("width"), arg("rotation").noconvert(),
               "Area-exact: ((H', W', C) pixels, residual of the energy of any one texel)");
}

}  // namespace shrm::bindings
