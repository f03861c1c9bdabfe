#include "ndarray.hpp"

namespace shrm::bindings {

void bind_wigner(py::module_&) {}

}  // namespace shrm::bindings
