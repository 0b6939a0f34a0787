#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "armukf/batch/simulation.hpp"
#include "armukf/core/record.hpp"
#include "armukf/diagnosis/base_fit.hpp"

/// What a diagnosis tells.
namespace armukf {

/// A model against a record, by simulation and one sample ahead.
struct Measures {
  double fit_percent = 0.0;       // of the simulation
  double mse = 0.0;               // (rad/s)^2, of the simulation
  std::optional<ErrorSums> free;  // as in SimulationFit; of both models where one needs it
  double one_step_rmse = 0.0;     // rad/s
  double log_likelihood = 0.0;    // of the innovations of all pieces, as predict_ahead
  double ljung_box_p = 0.0;       // of the innovations
};

/// An effect, fitted on top of the model of its round.
struct Candidate {
  std::string effect;
  std::string together_with;  // another one that was fitted at once; mostly empty
  int round = 0;
  /// By which the error of predictions falls where it falls most. Of one whose size may be chance
  /// the fit itself foretells, here and in the errors below: no blocks have been left out for it.
  double help_percent = 0.0;
  double statistic = 0.0;            // T^2, of its sizes' distance from none
  double p_value = 1.0;              // of that, corrected for all that was looked at
  double refitted_estimation = 0.0;  // (rad/s)^2, 200 samples ahead, if it was judged; else 0
  double refitted_validation = 0.0;
  bool accepted = false;
  std::string refused_because;  // empty where it was accepted
};

struct FoundEffect {
  std::string effect;
  double p_value = 1.0;                    // of its score, corrected for all that was looked at
  double mse_reduction_percent = 0.0;      // on the validation record, when it was added
  std::vector<std::string> confused_with;  // families that explain nearly as much in its stead
};

/// What several parts of the data say of a parameter of the completed model, and the chance that
/// they differ as much where it is the same in all.
struct Consistency {
  std::string parameter;
  std::string between;         // "halves" of the estimation records, or "records"
  std::vector<double> values;  // of the parameter
  std::vector<double> sd;
  double p_value = 1.0;
};

enum class Verdict { kSufficient, kFound, kUnexplained };
std::string_view name_of(Verdict verdict);

/// What a model lacks, as far as two records of the arm tell.
struct Diagnosis {
  BaseFit base;
  FittedModel after;           // on the pieces of the estimation records
  std::vector<Record> judges;  // pieces of the validation records, or the blocks left out in turn
  bool validated = false;      // by records of their own
  /// The values of `after` are those that make the validation records likeliest as well; what is
  /// told of these below is by values fitted without them.
  bool of_all_records = false;
  bool of_validation = false;   // what is missing shows in these only, and they were fitted instead
  FittedModel base_validation;  // on these
  FittedModel after_validation;
  Measures before_estimation, before_validation, after_estimation, after_validation_measures;
  std::vector<FoundEffect> effects;
  std::vector<Candidate> candidates;  // the best of each effect in each round
  std::vector<Consistency> consistency;
  Verdict verdict = Verdict::kSufficient;
  std::vector<std::string> unexplained;  // what is left looks like this
};

}  // namespace armukf
