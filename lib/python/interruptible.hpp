#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <future>
#include <stop_token>

namespace armukf::python {

/// Does a job without the GIL, and returns what it returns. It is asked to stop when Ctrl-C comes,
/// and what it returns is then dropped; signals reach Python's main thread alone, so that the job
/// has one of its own.
template <class Job>
auto interruptible(const Job& job) {
  constexpr std::chrono::milliseconds kBetweenSignals{50};
  std::stop_source stop;
  auto found = std::async(std::launch::async, [&] { return job(stop.get_token()); });
  for (;;) {
    {
      const pybind11::gil_scoped_release unlocked;
      if (found.wait_for(kBetweenSignals) == std::future_status::ready) break;
    }
    if (PyErr_CheckSignals() == 0) continue;
    const pybind11::error_already_set interrupted;
    stop.request_stop();
    {
      const pybind11::gil_scoped_release unlocked;
      found.wait();
    }
    throw interrupted;
  }
  return found.get();
}

}  // namespace armukf::python
