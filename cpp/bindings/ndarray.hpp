// Between numpy arrays and the core: shape checks with readable messages, nothing else.
// A wrong dtype or a non-contiguous array is a TypeError (pybind11, noconvert), a wrong shape
// a ValueError. Python has checked its users' input already; this ring guards memory.
#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <glm/vec3.hpp>

namespace shrm::bindings {

namespace py = pybind11;

template <class T>
using Array = py::array_t<T, py::array::c_style>;

inline constexpr py::ssize_t any = -1;

inline std::string shape_text(std::span<const py::ssize_t> shape) {
    std::string text = "(";
    for (const py::ssize_t& extent : shape)
        text += (&extent == shape.data() ? "" : ", ") + (extent == any ? "n" : std::to_string(extent));
    return text + (shape.size() == 1 ? ",)" : ")");
}
inline std::string shape_text(const py::array& array) {
    return shape_text({array.shape(), static_cast<std::size_t>(array.ndim())});
}

// Every refusal says what an argument must be, and what it was: "`name` must `be or have`, got `value`".
[[noreturn]] inline void refuse(const char* name, const std::string& must, const std::string& got) {
    throw py::value_error(std::string(name) + " must " + must + ", got " + got);
}
template <class Number>
[[noreturn]] void refuse(const char* name, const std::string& must, Number got) {
    refuse(name, must, py::str(py::cast(got)).template cast<std::string>());
}

[[noreturn]] inline void refuse_type(const char* name, const std::string& must, const py::array& got) {
    throw py::type_error(std::string(name) + " must " + must + ", got " +
                         py::str(got.dtype()).cast<std::string>() + " in strides of " +
                         shape_text({got.strides(), static_cast<std::size_t>(got.ndim())}) + " bytes");
}

// Throws ValueError unless array has exactly this shape; `any` leaves an extent open.
inline void require_shape(const py::array& array, const char* name, const std::vector<py::ssize_t>& shape) {
    const std::span<const py::ssize_t> found(array.shape(), static_cast<std::size_t>(array.ndim()));
    const auto fits = [](py::ssize_t extent, py::ssize_t needed) {
        return needed == any || extent == needed;
    };
    if (!std::ranges::equal(found, shape, fits))
        refuse(name, "have the shape " + shape_text(shape), shape_text(found));
}

template <class T>
Array<T> allocate(std::initializer_list<py::ssize_t> shape) {
    return Array<T>(std::vector<py::ssize_t>(shape));
}

// The array's memory as the core sees it.
template <class T>
std::span<const T> view(const Array<T>& array) {
    return {array.data(), static_cast<std::size_t>(array.size())};
}
template <class T>
std::span<T> view(Array<T>& array) {
    return {array.mutable_data(), static_cast<std::size_t>(array.size())};
}
// (..., 3) as vectors.
static_assert(sizeof(glm::dvec3) == 3 * sizeof(double));
inline std::span<const glm::dvec3> vectors(const Array<double>& array) {
    return {reinterpret_cast<const glm::dvec3*>(array.data()), static_cast<std::size_t>(array.size()) / 3};
}
inline std::span<glm::dvec3> vectors(Array<double>& array) {
    return {reinterpret_cast<glm::dvec3*>(array.mutable_data()), static_cast<std::size_t>(array.size()) / 3};
}

// A new array of this shape, which fill(its memory) fills while other threads of Python run.
template <class T, class Fill>
Array<T> filled(std::initializer_list<py::ssize_t> shape, const Fill& fill) {
    Array<T> array = allocate<T>(shape);
    const auto values = view(array);
    const py::gil_scoped_release release;
    fill(values);
    return array;
}

inline py::ssize_t ssize(std::size_t n) {
    return static_cast<py::ssize_t>(n);
}

inline int extent(const py::array& array, int axis) {
    return static_cast<int>(array.shape(axis));
}

inline void require_at_least(const char* name, py::ssize_t value, py::ssize_t least) {
    if (value < least) refuse(name, "be at least " + std::to_string(least), value);
}

inline void require_in(const char* name, py::ssize_t value, py::ssize_t least, py::ssize_t most) {
    if (value < least || value > most)
        refuse(name, "be in [" + std::to_string(least) + ", " + std::to_string(most) + "]", value);
}

inline void require_positive(const char* name, double value) {
    if (!(value > 0)) refuse(name, "be positive", value);
}

// One channel, or red, green and blue.
inline int require_channels(py::ssize_t channels, const char* name) {
    if (channels != 1 && channels != 3) refuse(name, "have 1 or 3 channels", channels);
    return static_cast<int>(channels);
}

// F of an array of shape ((F+1)^2, channels).
inline int degree_of(const Array<double>& coefficients, const char* name) {
    require_shape(coefficients, name, {any, any});
    const auto side =
        static_cast<py::ssize_t>(std::lround(std::sqrt(static_cast<double>(coefficients.shape(0)))));
    if (side < 1 || side * side != coefficients.shape(0))
        refuse(name, "have (F+1)^2 rows", coefficients.shape(0));
    return static_cast<int>(side) - 1;
}

}  // namespace shrm::bindings
