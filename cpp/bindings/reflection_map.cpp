#include "ndarray.hpp"

namespace shrm::bindings {

void bind_reflection_map(py::module_&) {}

}  // namespace shrm::bindings
