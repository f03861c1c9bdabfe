// Which builds of the core this processor can run; compiled for any processor.
#include <Python.h>

namespace {

// Instruction sets, the best first. SHRM_X86 says that the builds for x86-64-v3 and v4 exist.
PyObject* instruction_sets(PyObject*, PyObject*) {
#ifdef SHRM_X86
    __builtin_cpu_init();
    if (__builtin_cpu_supports("x86-64-v4"))
        return Py_BuildValue("[sss]", "x86-64-v4", "x86-64-v3", "portable");
    if (__builtin_cpu_supports("x86-64-v3")) return Py_BuildValue("[ss]", "x86-64-v3", "portable");
#endif
    return Py_BuildValue("[s]", "portable");
}

PyMethodDef functions[] = {
    {"instruction_sets", instruction_sets, METH_NOARGS, "The builds of the core, best first."}, {}};

PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "processor", nullptr, 0, functions, nullptr, nullptr, nullptr, nullptr};

}  // namespace

PyMODINIT_FUNC PyInit_processor() {
    return PyModule_Create(&definition);
}
