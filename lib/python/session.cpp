#include "armukf/online/session.hpp"

#include <pybind11/stl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "armukf/online/recursion.hpp"
#include "armukf/report/model_file.hpp"
#include "arrays.hpp"
#include "bindings.hpp"

namespace armukf::python {
namespace {

constexpr std::size_t kMany = 1 << 14;  // samples, from which a second thread fetches memory
constexpr std::size_t kBetweenSignals = 1 << 16;  // samples, a tenth of a second

/// The memory of an array.
std::span<std::byte> memory_of(py::array array) {
  return {static_cast<std::byte*>(array.mutable_data()), static_cast<std::size_t>(array.nbytes())};
}

/// Asks the kernel for the arrays' pages, from their first rows to their last, ahead of who fills
/// them: each page's first touch costs the loop a microsecond, a tenth of its time in all.
void fetch_pages(const std::stop_token& stop, const std::vector<std::span<std::byte>>& arrays) {
  constexpr std::size_t kParts = 64;  // a millisecond each for a million samples
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  for (std::size_t part = 0; part < kParts; ++part) {
    for (const std::span<std::byte> array : arrays) {
      if (stop.stop_requested()) return;
      const std::size_t first = page - reinterpret_cast<std::uintptr_t>(array.data()) % page;
      const std::size_t pages = (std::max(array.size(), first) - first) / page;
      const std::size_t begin = pages * part / kParts;
      const std::size_t end = pages * (part + 1) / kParts;
      ::madvise(array.data() + first + begin * page, (end - begin) * page, MADV_POPULATE_WRITE);
    }
  }
}

/// Results of a run.
struct Estimates {
  Estimates(std::size_t rows, std::size_t columns)
      : innovations(room_for<double>({4, rows})),
        status(room_for<std::uint8_t>({rows})),
        values(room_for<double>({rows, columns})),
        deviations(room_for<double>({rows, columns})) {}

  std::vector<std::span<std::byte>> memory() const {
    std::vector<std::span<std::byte>> all{memory_of(status), memory_of(values),
                                          memory_of(deviations)};
    const std::span<std::byte> rows = memory_of(innovations);
    for (std::size_t k = 0; k < 4; ++k)
      all.push_back(rows.subspan(k * rows.size() / 4, rows.size() / 4));
    return all;
  }

  py::array_t<double> innovations;  // rows: predicted, innovation, innovation_sd, nis
  py::array_t<std::uint8_t> status;
  py::array_t<double> values, deviations;  // a row per sample
};

/// Where they lie; needs no GIL.
struct Rows {
  explicit Rows(Estimates& e)
      : count(static_cast<std::size_t>(e.status.size())),
        innovations(e.innovations.mutable_data()),
        status(e.status.mutable_data()),
        values(e.values.mutable_data()),
        deviations(e.deviations.mutable_data()) {}

  void put(std::size_t k, const Estimate& e) const {
    innovations[k] = e.predicted;
    innovations[count + k] = e.innovation;
    innovations[2 * count + k] = e.innovation_sd;
    innovations[3 * count + k] = e.nis;
    status[k] = static_cast<std::uint8_t>(e.status);
    std::ranges::copy(e.values, values + k * e.values.size());
    std::ranges::copy(e.deviations, deviations + k * e.deviations.size());
  }

  std::size_t count;
  double* innovations;
  std::uint8_t* status;
  double* values;
  double* deviations;
};

py::array_t<double> rows_of(const SquareMatrix& matrix) {
  py::array_t<double> rows({matrix.size(), matrix.size()});
  for (int i = 0; i < matrix.size(); ++i)
    for (int j = 0; j < matrix.size(); ++j) rows.mutable_at(i, j) = matrix(i, j);
  return rows;
}

/// A session that works for one thread at a time. All but the steps of a run happens under the GIL.
class OneAtATime {
 public:
  explicit OneAtATime(const ModelFile& start)
      : settings_(start.settings),
        columns_(start.model.states.size() + start.model.unknowns().size()),
        session_(start.model, start.settings) {}

  py::tuple step(double t, double u, double y) {
    Session& session = idle();
    const Sample sample{.t = t, .u = u, .y = y};
    check({&sample, 1}, "sample", last_t_);
    const Estimate e = session.step(sample);
    last_t_ = t;
    return py::make_tuple(e.predicted, e.innovation, e.innovation_sd, e.nis,
                          static_cast<int>(e.status), copied(e.values), copied(e.deviations));
  }

  py::tuple run(const py::object& rows) {
    Session& session = idle();
    const std::span<const Sample> samples = samples_in({"samples", rows}, last_t_);
    Estimates estimates(samples.size(), columns_);
    const Rows found(estimates);
    const Working working(*this);
    const std::jthread fetching =
        samples.size() < kMany ? std::jthread() : std::jthread(fetch_pages, estimates.memory());
    for (std::size_t begin = 0; begin < samples.size(); begin += kBetweenSignals) {
      const std::size_t end = std::min(begin + kBetweenSignals, samples.size());
      {
        const py::gil_scoped_release unlocked;
        for (std::size_t k = begin; k < end; ++k) found.put(k, session.step(samples[k]));
      }
      last_t_ = samples[end - 1].t;
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    }
    return py::make_tuple(estimates.innovations, estimates.status, estimates.values,
                          estimates.deviations);
  }

  void expect_new_clock() {
    idle().expect_new_clock();
    last_t_ = kNoTime;
  }

  py::bytes save() { return idle().save(); }

  void load(const std::string& bytes) {
    idle().load(bytes);
    last_t_ = kNoTime;
  }

  ModelFile model() {
    return to_go_on_from(result_of(idle(), settings_.filter, {}, 0.0), settings_);
  }
  py::array_t<double> sd() { return as_array(idle().parameter_deviations()); }
  py::array_t<double> model_sd() { return as_array(idle().model_deviations()); }
  py::array_t<double> covariance() { return rows_of(idle().parameter_covariance()); }
  bool decided() { return idle().decided(); }

 private:
  struct Working {
    explicit Working(OneAtATime& s) : session(s) { session.working_ = true; }
    ~Working() { session.working_ = false; }
    Working(const Working&) = delete;
    Working& operator=(const Working&) = delete;
    OneAtATime& session;
  };

  Session& idle() {
    if (working_) throw std::runtime_error("the session runs in another thread");
    return session_;
  }

  EstimatorSettings settings_;
  std::size_t columns_;
  Session session_;
  double last_t_ = kNoTime;  // s, of the last sample
  bool working_ = false;     // without the GIL
};

std::vector<std::string> status_names() {
  std::vector<std::string> names;
  for (const Status status :
       {Status::kOk, Status::kMissing, Status::kRejected, Status::kGap, Status::kReset})
    names.emplace_back(name_of(status));
  return names;
}

}  // namespace

void bind_session(py::module_& module) {
  py::class_<OneAtATime>(module, "Session")
      .def(py::init<const ModelFile&>())
      .def("step", &OneAtATime::step)
      .def("run", &OneAtATime::run)
      .def("expect_new_clock", &OneAtATime::expect_new_clock)
      .def("save", &OneAtATime::save)
      .def("load", &OneAtATime::load)
      .def("model", &OneAtATime::model)
      .def("sd", &OneAtATime::sd)
      .def("model_sd", &OneAtATime::model_sd)
      .def("covariance", &OneAtATime::covariance)
      .def("decided", &OneAtATime::decided);
  module.def("status_names", &status_names);
}

}  // namespace armukf::python
