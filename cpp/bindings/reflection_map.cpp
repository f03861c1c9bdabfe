#include "shrm/reflection/local_form.hpp"

#include <memory>
#include <mutex>

#include "ndarray.hpp"
#include "shrm/core.hpp"
#include "shrm/pictures/cube.hpp"
#include "shrm/reflection/explicit_maps.hpp"
#include "shrm/reflection/map_coefficients.hpp"
#include "shrm/reflection/radiance.hpp"
#include "shrm/reflection/view_map.hpp"
#include "shrm/sh/view_harmonics.hpp"

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
    const Orders orders = require_orders(light, rho);
    const int F = orders.F, P = orders.P, channels = orders.channels;
    require_at_least("H", H, 1);
    require_at_least("W", W, 1);
    return filled<float>({H, ssize(basis_size(P)), channels, W}, [&](std::span<float> rings) {
        shrm::local_reflection_map(view(light), view(rho), F, P, channels, H, W, rings);
    });
}

Array<float> global_from_local(const Array<float>& local) {
    require_shape(local, "local", {any, any, any, any});
    const int H = extent(local, 0), W = extent(local, 3), channels = extent(local, 2);
    const int P = static_cast<int>(std::lround(std::sqrt(static_cast<double>(local.shape(1))))) - 1;
    if (P < 0 || basis_size(P) != static_cast<std::size_t>(local.shape(1)))
        refuse("local", "have (P+1)^2 maps", local.shape(1));
    return filled<float>({H, local.shape(1), channels, W}, [&](std::span<float> global) {
        shrm::global_from_local(view(local), P, channels, H, W, global);
    });
}

Array<double> global_coefficients(const Array<double>& light, const Array<double>& rho) {
    const Orders orders = require_orders(light, rho);
    const int F = orders.F, P = orders.P, channels = orders.channels;
    const py::ssize_t rows = ssize(basis_size(F + P)), maps = ssize(basis_size(P));
    return filled<double>({rows, maps, channels}, [&](std::span<double> coefficients) {
        MapCoefficients map(F, P, channels, false);
        map.set_material(view(rho));
        map.run(view(light), coefficients);
    });
}

// Runs for one caller at a time: it works in memory of its own.
struct MapCoefficientsPlan {
    int F, P, channels;
    MapCoefficients product;
    std::mutex busy;

    void set_material(const Array<double>& rho) {
        require_shape(rho, "rho", {F + 1, P + 1, P + 1, channels});
        const auto in = view(rho);
        const py::gil_scoped_release release;
        const std::lock_guard lock(busy);
        product.set_material(in);
    }
    void run(const Array<double>& light, Array<double>& coefficients) {
        require_shape(light, "light", {ssize(basis_size(F)), channels});
        require_shape(coefficients, "coefficients",
                      {ssize(basis_size(product.degree())), product.maps(), channels});
        const auto in = view(light);
        const auto out = view(coefficients);
        const py::gil_scoped_release release;
        const std::lock_guard lock(busy);
        product.run(in, out);
    }
};

std::unique_ptr<MapCoefficientsPlan> map_coefficients_plan(int F, int P, int channels, bool zonal) {
    require_at_least("F", F, 0);
    require_at_least("P", P, 0);
    require_at_least("channels", channels, 1);
    return std::unique_ptr<MapCoefficientsPlan>(
        new MapCoefficientsPlan{F, P, channels, {F, P, channels, zonal}, {}});
}

bool is_half(const py::array& array) {
    return array.dtype().kind() == 'f' && array.itemsize() == 2;
}

// Values from one row, along the last axis, to the next; what lies between rows belongs to none.
int require_rows(const py::array& array, const char* name) {
    const py::ssize_t last = array.ndim() - 1;
    bool regular = last >= 0 && (array.shape(last) <= 1 || array.strides(last) == array.itemsize());
    py::ssize_t pitch = 0, rows = 1;
    for (py::ssize_t axis = last - 1; axis >= 0; --axis) {
        if (array.shape(axis) == 1) continue;  // its stride means nothing
        if (pitch == 0) pitch = array.strides(axis) / array.itemsize();
        regular = regular && array.strides(axis) == rows * pitch * array.itemsize();
        rows *= array.shape(axis);
    }
    if (pitch == 0 && last >= 0) pitch = array.shape(last);
    regular = regular && pitch >= array.shape(last);
    if (!regular) refuse_type(name, "be contiguous, or in rows equally far apart", array);
    return static_cast<int>(pitch);
}

ReflectionMapView require_map(const py::array& rings, bool cube, bool zonal) {
    const bool half = is_half(rings);
    if (!half && !py::isinstance<Array<float>>(rings))
        refuse_type("rings", "be a contiguous array of float32, or rows of float16", rings);
    require_shape(rings, "rings", {any, any, 3, any});
    const int pitch = require_rows(rings, "rings");
    const int H = extent(rings, 0), W = extent(rings, 3), maps = extent(rings, 1);
    const int P = zonal ? maps - 1 : static_cast<int>(std::lround(std::sqrt(maps))) - 1;
    ReflectionMapView map{cube ? MapLayout::cube : MapLayout::latlong, H, W, pitch, P, zonal, {}, {}};
    if (P < 0 || P > largest_P || map.maps() != maps)
        refuse("rings",
               std::string("have ") + (zonal ? "P+1" : "(P+1)^2") + " maps, P at most " +
                   std::to_string(largest_P),
               maps);
    if (cube ? W <= 2 * cube_border || H != 6 * W : H < 2 || W < 4 || W % 2 != 0)
        refuse("rings",
               cube ? "have six bordered faces of square texels" : "have rows of an even number of texels",
               shape_text(rings));
    const auto count = static_cast<std::size_t>(rings.size() / W * pitch);
    if (half)
        map.halves = {static_cast<const std::uint16_t*>(rings.data()), count};
    else
        map.rings = {static_cast<const float*>(rings.data()), count};
    return map;
}

Center center_of(const std::string& name) {
    if (name == "reflection") return Center::reflection;
    if (name == "normal") return Center::normal;
    if (name == "tangent") return Center::tangent;
    if (name == "lobe") return Center::lobe;
    refuse("center", "be reflection, normal, tangent or lobe", name);
}

void add_radiance(const py::array& rings, bool cube, bool zonal, const std::string& center,
                  const Array<double>& gamma, const Array<double>& axes, const Array<double>& views,
                  bool bilinear, Array<float>& radiance) {
    const ReflectionMapView map = require_map(rings, cube, zonal);
    const Center about = center_of(center);
    require_shape(gamma, "gamma", {any});
    if (about == Center::lobe) require_at_least("the number of gamma's nodes", gamma.shape(0), 2);
    require_shape(axes, "axes", {any, 3});
    require_shape(views, "views", {views.ndim() == 2 && views.shape(0) == 1 ? 1 : axes.shape(0), 3});
    require_shape(radiance, "radiance", {axes.shape(0), 3});
    const auto table = view(gamma);
    const auto N = vectors(axes), V = vectors(views);
    const auto out = view(radiance);
    const py::gil_scoped_release release;
    shrm::add_radiance(map, about, table, N, V, bilinear, out);
}

Array<float> look_up(const py::array& rings, bool cube, bool zonal, const Array<double>& C,
                     const Array<double>& views, bool bilinear) {
    const ReflectionMapView map = require_map(rings, cube, zonal);
    require_shape(C, "C", {any, 3});
    require_shape(views, "views", {views.ndim() == 2 && views.shape(0) == 1 ? 1 : C.shape(0), 3});
    return filled<float>({C.shape(0), 3}, [&](std::span<float> radiance) {
        std::ranges::fill(radiance, 0.f);
        add_looked_up(map, vectors(C), vectors(views), bilinear, radiance);
    });
}

void view_map(const py::array& rings, bool cube, bool zonal, const Array<double>& direction,
              Array<float>& pixels) {
    const ReflectionMapView map = require_map(rings, cube, zonal);
    require_shape(direction, "direction", {1, 3});
    const int N = map.W - 2 * cube_border;
    if (cube)
        require_shape(pixels, "pixels", {6, N, N, 3});
    else
        require_shape(pixels, "pixels", {map.H, map.W, 3});
    const auto V = vectors(direction);
    const auto out = view(pixels);
    const py::gil_scoped_release release;
    shrm::view_map(map, V[0], out);
}

Array<float> explicit_maps(const Array<float>& rings, bool cube, int T) {
    const ReflectionMapView map = require_map(rings, cube, false);
    require_at_least("T", T, 1);
    const int N = map.W - 2 * cube_border;
    const auto fill = [&](std::span<float> pixels) { shrm::explicit_maps(map, T, pixels); };
    return cube ? filled<float>({T, T, 6, N, N, 3}, fill) : filled<float>({T, T, map.H, map.W, 3}, fill);
}

void to_half(const Array<float>& rings, py::array& halves) {
    if (!is_half(halves)) refuse_type("halves", "be an array of float16", halves);
    require_shape(halves, "halves", {rings.shape(), rings.shape() + rings.ndim()});
    const int pitch = require_rows(halves, "halves");
    if (rings.size() == 0) return;
    const int W = extent(rings, static_cast<int>(rings.ndim()) - 1);
    const auto in = view(rings);
    auto* out = static_cast<std::uint16_t*>(halves.mutable_data());
    const py::gil_scoped_release release;
    shrm::to_half(in, W, out, pitch);
}

float largest_magnitude(const Array<float>& rings) {
    const auto in = view(rings);
    const py::gil_scoped_release release;
    return shrm::largest_magnitude(in);
}

Array<double> cube_directions(int N) {
    require_at_least("N", N, 1);
    const int bordered = N + 2 * cube_border;
    auto result = allocate<double>({6 * bordered, bordered, 3});
    const auto out = vectors(result);
    const py::gil_scoped_release release;
    cube_texel_directions(N, out);
    return result;
}

}  // namespace

void bind_reflection_map(py::module_& module) {
    using namespace py::literals;
    module.def("local_reflection_map", &local_reflection_map, py::kw_only(), "light"_a.noconvert(),
               "rho"_a.noconvert(), "H"_a, "W"_a);
    module.def("global_from_local", &global_from_local, py::kw_only(), "local"_a.noconvert());
    module.def("global_coefficients", &global_coefficients, py::kw_only(), "light"_a.noconvert(),
               "rho"_a.noconvert());
    py::class_<MapCoefficientsPlan>(module, "MapCoefficients")
        .def(py::init(&map_coefficients_plan), py::kw_only(), "F"_a, "P"_a, "channels"_a, "zonal"_a)
        .def("set_material", &MapCoefficientsPlan::set_material, "rho"_a.noconvert(), py::pos_only())
        .def("run", &MapCoefficientsPlan::run, "light"_a.noconvert(), "coefficients"_a.noconvert(),
             py::pos_only());
    module.def("add_radiance", &add_radiance, py::kw_only(), "rings"_a, "cube"_a, "zonal"_a, "center"_a,
               "gamma"_a.noconvert(), "axes"_a.noconvert(), "views"_a.noconvert(), "bilinear"_a,
               "radiance"_a.noconvert());
    module.def("look_up", &look_up, py::kw_only(), "rings"_a, "cube"_a, "zonal"_a, "C"_a.noconvert(),
               "views"_a.noconvert(), "bilinear"_a);
    module.def("view_map", &view_map, py::kw_only(), "rings"_a, "cube"_a, "zonal"_a,
               "direction"_a.noconvert(), "pixels"_a.noconvert());
    module.def("explicit_maps", &explicit_maps, py::kw_only(), "rings"_a.noconvert(), "cube"_a, "T"_a);
    module.def("to_half", &to_half, "rings"_a.noconvert(), "halves"_a, py::pos_only());
    module.def("largest_magnitude", &largest_magnitude, "rings"_a.noconvert(), py::pos_only());
    module.def("cube_directions", &cube_directions, py::kw_only(), "N"_a);
    module.attr("CUBE_BORDER") = cube_border;
}

}  // namespace shrm::bindings
