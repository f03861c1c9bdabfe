// The table of contents of shrm._core, in the order the data flows.
#include <omp.h>
#include <pthread.h>
#include <pybind11/pybind11.h>

namespace shrm::bindings {
void bind_grid(pybind11::module_& module);
void bind_sh(pybind11::module_& module);
void bind_wigner(pybind11::module_& module);
void bind_measured(pybind11::module_& module);
void bind_brdf_analysis(pybind11::module_& module);
void bind_reflection_map(pybind11::module_& module);
void bind_angular(pybind11::module_& module);
void bind_hierarchical(pybind11::module_& module);
void bind_tent_basis(pybind11::module_& module);
void bind_transfer_products(pybind11::module_& module);
void bind_transfer_lighting(pybind11::module_& module);
}  // namespace shrm::bindings

namespace {

void define(pybind11::module_& module) {
    using namespace shrm::bindings;
    // A forked child has none of its parent's OpenMP threads, and GNU's library would wait for them for ever.
    pthread_atfork(nullptr, nullptr, [] { omp_set_num_threads(1); });
    module.doc() =
        "The C++ core of shrm. Use the modules of the package; this one checks memory, not meaning.";
    bind_grid(module);
    bind_sh(module);
    bind_wigner(module);
    bind_measured(module);
    bind_brdf_analysis(module);
    bind_reflection_map(module);
    bind_angular(module);
    bind_hierarchical(module);
    bind_tent_basis(module);
    bind_transfer_products(module);
    bind_transfer_lighting(module);
}

}  // namespace

// Each build of the core is linked with all of these, and is imported as the one that it is named after.
PYBIND11_MODULE(portable, module) {
    define(module);
}
#ifdef SHRM_X86
PYBIND11_MODULE(x86_64_v3, module) {
    define(module);
}
PYBIND11_MODULE(x86_64_v4, module) {
    define(module);
}
#endif
