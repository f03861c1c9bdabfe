#include "ndarray.hpp"

namespace shrm::bindings {

void bind_sh(py::module_&) {}

}  // namespace shrm::bindings
