#include <glog/logging.h>

#include "armukf/core/build.hpp"
#include "armukf/core/error.hpp"
#include "bindings.hpp"

PYBIND11_MODULE(_core, module) {
  namespace py = pybind11;
  using namespace armukf::python;
  // A step that Ceres cannot solve for is shortened; its warnings would stand in the notebook.
  FLAGS_minloglevel = google::GLOG_FATAL;
  py::register_exception<armukf::InputError>(module, "InputError", PyExc_ValueError);
  module.attr("version") = armukf::library_version();
  module.attr("processor") = armukf::build_processor();
  bind_model(module);
  bind_session(module);
  bind_track(module);
  bind_recursion(module);
  bind_batch(module);
  bind_diagnosis(module);
}
