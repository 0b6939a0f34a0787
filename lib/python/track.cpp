#include "armukf/online/track.hpp"

#include <optional>
#include <span>
#include <string>

#include "armukf/report/model_file.hpp"
#include "arrays.hpp"
#include "bindings.hpp"

namespace armukf::python {
namespace {

/// A track as Python sees it; all of it happens under the GIL. What an estimate is of is told by
/// its time, since samples may come in another order than they are given out.
class PythonTrack {
 public:
  PythonTrack(const ModelFile& start, double reorder_s)
      : settings_(start.settings), track_(start.model, start.settings, {.reorder_s = reorder_s}) {}

  int put(double t, double u, double y) {
    const Sample sample{.t = t, .u = u, .y = y};
    check({&sample, 1}, "sample", kNoTime);
    return static_cast<int>(track_.put(sample));
  }

  /// None where nothing is due.
  py::object next() {
    const std::optional<Estimate> e = track_.next();
    if (!e) return py::none();
    return py::make_tuple(e->sample.t, e->sample.u, e->sample.y, e->predicted, e->innovation,
                          e->innovation_sd, e->nis, static_cast<int>(e->status), copied(e->values),
                          copied(e->deviations));
  }

  void end() { track_.end(); }
  void expect_new_clock() { track_.expect_new_clock(); }

  /// late, repeated, astray, new clocks.
  py::tuple counts() const {
    const FateCounts fates = track_.counts().fates;
    return py::make_tuple(fates.late, fates.repeated, fates.astray, fates.new_clocks);
  }

  py::bytes save() const { return track_.save(); }
  void load(const std::string& bytes) { track_.load(bytes); }

  ModelFile model() const {
    return to_go_on_from(track_.session().model(), settings_, track_.session().belief());
  }
  py::array_t<double> sd() const { return as_array(track_.session().parameter_deviations()); }
  py::array_t<double> model_sd() const { return as_array(track_.session().model_deviations()); }

 private:
  EstimatorSettings settings_;
  Track track_;
};

}  // namespace

void bind_track(py::module_& module) {
  py::class_<PythonTrack>(module, "Track")
      .def(py::init<const ModelFile&, double>())
      .def("put", &PythonTrack::put)
      .def("next", &PythonTrack::next)
      .def("end", &PythonTrack::end)
      .def("expect_new_clock", &PythonTrack::expect_new_clock)
      .def("counts", &PythonTrack::counts)
      .def("save", &PythonTrack::save)
      .def("load", &PythonTrack::load)
      .def("model", &PythonTrack::model)
      .def("sd", &PythonTrack::sd)
      .def("model_sd", &PythonTrack::model_sd);
}

}  // namespace armukf::python
