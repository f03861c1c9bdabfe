// Which builds of the core this processor can run; compiled for any processor.
#include <string>
#include <vector>

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

namespace {

// Best first. SHRM_X86 says that the builds for x86-64-v3 and v4 exist.
std::vector<std::string> instruction_sets() {
    std::vector<std::string> names;
#ifdef SHRM_X86
    __builtin_cpu_init();
    if (__builtin_cpu_supports("x86-64-v4")) names.push_back("x86-64-v4");
    if (__builtin_cpu_supports("x86-64-v3")) names.push_back("x86-64-v3");
#endif
    names.push_back("portable");
    return names;
}

}  // namespace

PYBIND11_MODULE(processor, module) {
    module.def("instruction_sets", &instruction_sets);
}
