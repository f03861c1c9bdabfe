#include "ndarray.hpp"

namespace shrm::bindings {

void bind_grid(py::module_&) {}

}  // namespace shrm::bindings
