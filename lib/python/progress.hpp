#pragma once

#include <pybind11/pybind11.h>

namespace armukf::python {

/// Tells a Python function, or nobody where it is None, how far a job without the GIL is. Ctrl-C
/// ends the job there.
struct Progress {
  pybind11::object told;

  template <class... Words>
  void operator()(const Words&... words) const {
    const pybind11::gil_scoped_acquire locked;
    if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
    if (!told.is_none()) told(words...);
  }
};

}  // namespace armukf::python
