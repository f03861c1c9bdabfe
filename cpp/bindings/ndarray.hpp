// Between numpy arrays and the core: shape checks with readable messages, nothing else.
// A wrong dtype or a non-contiguous array is a TypeError (pybind11, noconvert), a wrong shape
// a ValueError. Python has checked its users' input already; this ring guards memory.
#pragma once

#include <initializer_list>
#include <stdexcept>
#include <string>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

namespace shrm::bindings {

namespace py = pybind11;

template <class T>
using Array = py::array_t<T, py::array::c_style>;

inline constexpr py::ssize_t any = -1;

// Throws ValueError unless array has exactly this shape; `any` leaves an extent open.
template <class T>
void require_shape(const Array<T>& array, const char* name, std::initializer_list<py::ssize_t> shape) {
    bool fits = array.ndim() == static_cast<py::ssize_t>(shape.size());
    py::ssize_t axis = 0;
    for (py::ssize_t extent : shape) {
        fits = fits && (extent == any || array.shape(axis) == extent);
        ++axis;
    }
    if (fits) return;
    const auto text = [](auto begin, auto end) {
        std::string s = "(";
        for (auto it = begin; it != end; ++it) s += (it == begin ? "" : ", ") + (*it < 0 ? std::string("n") : std::to_string(*it));
        return s + ")";
    };
    throw py::value_error(std::string(name) + " has shape " + text(array.shape(), array.shape() + array.ndim()) +
                          ", but needs " + text(shape.begin(), shape.end()));
}

template <class T>
Array<T> allocate(std::initializer_list<py::ssize_t> shape) {
    return Array<T>(std::vector<py::ssize_t>(shape));
}

inline int extent(const py::array& array, int axis) {
    return static_cast<int>(array.shape(axis));
}

}  // namespace shrm::bindings
