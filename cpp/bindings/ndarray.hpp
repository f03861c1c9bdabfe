// Between numpy arrays and the core: shape checks with readable messages, nothing else.
// A wrong dtype or a non-contiguous array is a TypeError (pybind11, noconvert), a wrong shape
// a ValueError. Python has checked its users' input already; this ring guards memory.
#pragma once

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

// Throws ValueError unless array has exactly this shape; `any` leaves an extent open.
inline void require_shape(const py::array& array, const char* name, const std::vector<py::ssize_t>& shape) {
    bool fits = array.ndim() == static_cast<py::ssize_t>(shape.size());
    py::ssize_t axis = 0;
    for (py::ssize_t extent : shape) {
        fits = fits && (extent == any || array.shape(axis) == extent);
        ++axis;
    }
    if (fits) return;
    const auto text = [](auto begin, auto end) {
        std::string s = "(";
        for (auto it = begin; it != end; ++it)
            s += (it == begin ? "" : ", ") + (*it < 0 ? std::string("n") : std::to_string(*it));
        return s + ")";
    };
    throw py::value_error(std::string(name) + " has shape " +
                          text(array.shape(), array.shape() + array.ndim()) + ", but needs " +
                          text(shape.begin(), shape.end()));
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

inline py::ssize_t ssize(std::size_t n) {
    return static_cast<py::ssize_t>(n);
}

inline int extent(const py::array& array, int axis) {
    return static_cast<int>(array.shape(axis));
}

inline void require_positive(const char* name, int value) {
    if (value < 1)
        throw py::value_error(std::string(name) + " is " + std::to_string(value) + ", but must be positive");
}

inline void require_degree(const char* name, int value) {
    if (value < 0)
        throw py::value_error(std::string(name) + " is " + std::to_string(value) +
                              ", but must not be negative");
}

// F of an array of shape ((F+1)^2, channels).
inline int degree_of(const Array<double>& coefficients, const char* name) {
    require_shape(coefficients, name, {any, any});
    const auto side =
        static_cast<py::ssize_t>(std::lround(std::sqrt(static_cast<double>(coefficients.shape(0)))));
    if (side < 1 || side * side != coefficients.shape(0))
        throw py::value_error(std::string(name) + " has " + std::to_string(coefficients.shape(0)) +
                              " rows, but needs (F+1)^2");
    return static_cast<int>(side) - 1;
}

}  // namespace shrm::bindings
