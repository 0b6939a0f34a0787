#pragma once

#include <pybind11/pybind11.h>

/// The module `armukf._core`: C++ jobs on NumPy arrays. Reports cross as the JSON that the program
/// prints; lib/python/armukf makes of them what people work with, and says what each argument is.
/// A job without the GIL is given a model of its own, which nobody changes meanwhile.
namespace armukf::python {

void bind_model(pybind11::module_& module);
void bind_session(pybind11::module_& module);
void bind_track(pybind11::module_& module);
void bind_recursion(pybind11::module_& module);
void bind_batch(pybind11::module_& module);
void bind_diagnosis(pybind11::module_& module);

}  // namespace armukf::python
