#include "ndarray.hpp"

namespace shrm::bindings {

void bind_angular(py::module_&) {}

}  // namespace shrm::bindings
