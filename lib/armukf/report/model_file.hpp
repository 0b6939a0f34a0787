#pragma once

#include <string>
#include <vector>

#include "armukf/batch/identify.hpp"
#include "armukf/core/square_matrix.hpp"
#include "armukf/model/model.hpp"
#include "armukf/online/recursion.hpp"
#include "armukf/online/settings.hpp"

namespace armukf {

/// All that a model file says.
struct ModelFile {
  Model model = published_arm();
  EstimatorSettings settings;
};

/// What a recursive estimate goes on from after a fit that has found these of a model: of the noise
/// it knows nothing, nor of what the records did not determine. covariance: of the estimates.
ParameterBelief belief_of(const Model& model, const std::vector<ParameterEstimate>& estimates,
                          const SquareMatrix& covariance);

/// What a later estimate goes on from: the model with the values, and what is believed of them.
ModelFile to_go_on_from(Model model, EstimatorSettings settings, ParameterBelief belief);

/// The same of an estimate; what a watch has found of the drive stands in it as known effects, of
/// the sensor it can hold nothing.
ModelFile to_go_on_from(const RecursiveEstimate& estimate, EstimatorSettings settings);

/// The TOML file at `path` ("-" is standard input), over the built-in defaults: what it leaves out
/// keeps its default. A parameter has `value`, `known`, `lower`, `upper`, `scale` and `spread`; the
/// tables [filter], [propagation], [noise], [prior], [gate] and [race] mirror EstimatorSettings;
/// [limits] has `lower` and `upper` of whatever may change.
/// Throws InputError, `FILE:LINE: KEY: what is wrong`.
ModelFile read_model_file(const std::string& path);

/// The same from text, over `before` in place of the defaults; `name` stands for the file in
/// messages.
ModelFile parse_model_file(const std::string& text, const std::string& name, ModelFile before = {});

/// The complete file, with units and meanings in comments. It reads back to the same numbers
/// exactly.
std::string model_file_text(const ModelFile& content);

/// Writes that text; the file takes its name only when complete.
void write_model_file(const std::string& path, const ModelFile& content);

}  // namespace armukf
