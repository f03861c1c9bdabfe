#include "ndarray.hpp"

namespace shrm::bindings {

void bind_brdf_analysis(py::module_&) {}

}  // namespace shrm::bindings
