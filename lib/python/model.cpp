#include "armukf/model/model.hpp"

#include <pybind11/stl.h>

#include <string>
#include <vector>

#include "armukf/model/catalogue.hpp"
#include "armukf/report/model_file.hpp"
#include "bindings.hpp"

namespace py = pybind11;

namespace armukf::python {
namespace {

using Names = std::vector<std::string>;

py::list parameters_of(const ModelFile& file) {
  py::list all;
  for (const Parameter& p : file.model.parameters)
    all.append(
        py::make_tuple(p.name, p.unit, p.value, p.lower, p.upper, p.scale, p.known, p.spread));
  return all;
}

Names units_of(const Model& model) {
  Names units;
  for (const Coordinate& state : model.states) units.push_back(state.unit);
  for (const int i : model.unknowns()) units.push_back(model.parameters[i].unit);
  return units;
}

}  // namespace

void bind_model(py::module_& module) {
  py::class_<ModelFile>(module, "Model")
      .def(py::init<>())
      .def(py::init<const ModelFile&>())
      .def(py::init(&read_model_file))
      .def_static("parsed", [](const std::string& text,
                               const std::string& name) { return parse_model_file(text, name); })
      .def_static("published_estimate",
                  [] {
                    return ModelFile{published_estimate(), {}};
                  })
      .def("update", [](ModelFile& file, const std::string& text,
                        const std::string& name) { file = parse_model_file(text, name, file); })
      .def("remove_effect",
           [](ModelFile& file, const std::string& name) { file.model.remove_effect(name); })
      .def("text", &model_file_text)
      .def("save",
           [](const ModelFile& file, const std::string& path) { write_model_file(path, file); })
      .def("parameters", &parameters_of)
      .def("states",
           [](const ModelFile& file) {
             Names names;
             for (const Coordinate& state : file.model.states) names.push_back(state.name);
             return names;
           })
      .def("units", [](const ModelFile& file) { return units_of(file.model); })
      .def("effects", [](const ModelFile& file) {
        Names names;
        for (const EffectSlot& slot : file.model.effects) names.push_back(slot.name());
        return names;
      });
  module.def("effect_names", &effect_names);
}

}  // namespace armukf::python
