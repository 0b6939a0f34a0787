#include "armukf/batch/identify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>

#include "armukf/batch/jackknife.hpp"
#include "armukf/batch/output_error.hpp"
#include "armukf/batch/searches.hpp"
#include "armukf/batch/stopped.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/error.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/core/statistics.hpp"
#include "armukf/fit/loss.hpp"
#include "armukf/model/coordinates.hpp"

namespace armukf {
namespace {

/// Searches whose costs differ by less ended in the same minimum, relative.
constexpr double kSameMinimum = 1e-4;

/// Beyond so many deviations Huber's loss turns from squares to magnitudes: 95 % efficient where
/// the residuals are normal.
constexpr double kHuber = 1.345;

void check_length(const OutputError& error, const std::vector<Record>& records) {
  if (error.measured() > error.variables()) return;
  throw InputError(records.empty() ? "fit" : records.front().name, 0, "y",
                   fmt::format("{} measurements cannot determine {} unknowns", error.measured(),
                               error.variables()));
}

/// Times in another unit would make a search of hours.
void check_interval(const std::vector<Record>& records) {
  constexpr double kLongest = 0.2;  // s; nothing of an arm's resonances shows any more
  for (const Record& record : records) {
    const std::vector<Sample>& samples = record.samples;
    const double usual =
        (samples.back().t - samples.front().t) / static_cast<double>(samples.size());
    if (usual > kLongest)
      throw InputError(
          record.name, 0, "t",
          fmt::format("samples are {:.3g} s apart, too far for any arm: is t in s?", usual));
  }
}

/// Start values drawn from the parameters' prior, inside their bounds.
Model drawn(const Model& model, std::mt19937_64& generator) {
  const FreeCoordinates coordinates(model);
  std::vector<double> z = coordinates.from_physical(model.values());
  std::normal_distribution<double> normal;
  for (int k = 0; k < coordinates.size(); ++k)
    z[k] += normal(generator) * model.parameters[coordinates.unknowns()[k]].spread;
  coordinates.keep_inside(z.data());
  std::vector<double> p(kMaxParameters);
  coordinates.to_physical(z.data(), p.data());
  Model start = model;
  for (const int i : coordinates.unknowns()) start.parameters[i].value = p[i];
  return start;
}

using SearchFrom = FoundMinimum (*)(const Model&, const StatesOfPieces&, const SearchTask&);

/// Of what is unknown only the usual unknowns of an arm, and maybe what effects bring; the rest is
/// taken for known as it is.
Model with_fewer_unknowns(Model model, bool with_effects) {
  const Model usual = published_arm();
  for (const int i : model.unknowns()) {
    const bool of_the_arm = i < kArmParameters;
    model.parameters[i].known = of_the_arm ? usual.parameters[i].known : !with_effects;
  }
  return model;
}

/// First of the arm's usual unknowns alone, from where that ends of what effects bring as well, and
/// then of friction and all else. All at once may lead to a minimum above that with fewer of them.
/// Nothing where the model has no others, or only those.
std::optional<FoundMinimum> searched_step_by_step(SearchFrom search, const Model& model,
                                                  const StatesOfPieces& x0,
                                                  const SearchTask& task) {
  const Model arm = with_fewer_unknowns(model, false);
  const Model with_effects = with_fewer_unknowns(model, true);
  std::optional<FoundMinimum> found;
  for (const Model* step : {&arm, &with_effects, &model}) {
    const std::vector<int> unknowns = step->unknowns();
    if (unknowns.empty() || (found && unknowns == found->model.unknowns())) continue;
    if (!found && unknowns.size() == model.unknowns().size()) return {};
    Model start = *step;
    if (found) {
      for (const int i : found->model.unknowns())
        start.parameters[i].value = found->model.parameters[i].value;
    }
    found = search(start, found ? found->x0 : x0, task);
    if (!std::isfinite(found->loss)) return {};
  }
  return found;
}

/// Searches from several starts; the best minimum first.
std::vector<FoundMinimum> search_all(const Model& model, const SearchTask& task,
                                     const IdentifySettings& settings) {
  std::mt19937_64 generator(settings.seed);
  std::vector<Model> starts{model};
  while (static_cast<int>(starts.size()) < settings.starts)
    starts.push_back(drawn(model, generator));
  const auto count = static_cast<int>(starts.size());
  std::vector<FoundMinimum> found(starts.size());
  std::optional<FoundMinimum> by_steps;
  const StatesOfPieces x0 = settings.first_states.empty()
                                ? phased_states(model, task.records, task.propagation)
                                : settings.first_states;
  const SearchFrom search = settings.criterion == Criterion::kPrediction ? searched_for_predictions
                                                                         : searched_for_simulation;
  for_each_job(settings.step_by_step ? count + 1 : count, [&](int k) {
    if (k < count) {
      found[k] = search(starts[k], x0, task);
    } else {
      by_steps = searched_step_by_step(search, model, x0, task);
    }
  });
  if (by_steps && by_steps->loss < found.front().loss) found.front() = std::move(*by_steps);
  std::ranges::stable_sort(found, {}, &FoundMinimum::loss);
  return found;
}

/// Covariances of all variables: as if the residuals were white, and whatever their colour.
struct Spread {
  Eigen::MatrixXd white;
  Eigen::MatrixXd coloured;
};

Spread spread_at(const OutputError& error, const OutputError::Evaluation& at, double huber_scale) {
  if (!at.valid) {
    const int n = error.variables();
    const Eigen::MatrixXd unknown = Eigen::MatrixXd::Constant(n, n, kInfinite);
    return {unknown, unknown};
  }
  const HuberScore score = huber_score(huber_scale, at.r, at.J, error.measured());
  const Eigen::MatrixXd bread = inverse_information(score.inner);
  const double freedom = error.measured() - error.variables();
  return {score.psi.squaredNorm() / freedom / score.share * bread,
          coloured_covariance(at.J, score.psi, bread, error.stretches(), error.unknowns())};
}

bool on_bound(const Parameter& p) {
  constexpr double kClose = 1e-6;  // of the parameter's scale
  return p.value - p.lower < kClose * p.scale || p.upper - p.value < kClose * p.scale;
}

double correlation(const Eigen::MatrixXd& covariance, int i, int j) {
  return covariance(i, j) / std::sqrt(covariance(i, i) * covariance(j, j));
}

/// block_sd: of the unknowns; empty if nobody asked for them.
void report_parameters(const Spread& spread, const std::vector<double>& block_sd,
                       Identification& result) {
  const std::vector<int> unknowns = result.model.unknowns();
  const int n = static_cast<int>(unknowns.size());
  for (int i = 0; i < n; ++i) {
    const Parameter& p = result.model.parameters[unknowns[i]];
    ParameterEstimate estimate{.position = unknowns[i],
                               .value = p.value,
                               .sd = 0.0,
                               .white_sd = std::sqrt(spread.white(i, i)),
                               .coloured_sd = std::sqrt(spread.coloured(i, i)),
                               .block_sd = block_sd.empty() ? kNaN : block_sd[i],
                               .on_bound = on_bound(p)};
    estimate.sd = std::fmax(estimate.coloured_sd, estimate.block_sd);
    result.parameters.push_back(estimate);
  }
  result.correlation = SquareMatrix(n);
  result.covariance = SquareMatrix(n);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) {  // the other half would differ by rounding
      result.correlation(i, j) = result.correlation(j, i) = correlation(spread.white, i, j);
      result.covariance(i, j) = result.covariance(j, i) =
          result.parameters[i].sd * result.parameters[j].sd *
          (i == j ? 1.0 : correlation(spread.coloured, i, j));
    }
  }
}

InitialStates initial_states(const OutputError& error, const std::vector<int>& free,
                             const std::vector<double>& v, int record, const Spread& spread) {
  InitialStates initial;
  initial.x0 = error.initial_states_at(v.data(), record);
  initial.sd.assign(initial.x0.size(), kNaN);
  for (int j = 0; j < error.free_states(); ++j) {
    const int k = error.first_state(record) + j;
    initial.sd[free[j]] = std::sqrt(spread.coloured(k, k));
  }
  return initial;
}

/// How the model simulates the records; where its states came from a filter, from those that fit a
/// record's beginning best.
void report_experiments(const std::vector<Record>& records, const IdentifySettings& settings,
                        const std::vector<InitialStates>& initial, Identification& result) {
  ErrorSums all;
  for (std::size_t e = 0; e < records.size(); ++e) {
    const std::vector<Sample>& samples = records[e].samples;
    const InitialStates from =
        settings.criterion == Criterion::kSimulation
            ? initial[e]
            : fit_initial_states(result.model, all_free(result.model),
                                 beginning(samples, kBeginning), settings.propagation);
    result.experiments.push_back(
        {records[e].name, samples.front().t, samples.size(),
         simulation_fit(result.model, from, samples, settings.propagation)});
    all += error_sums(speeds_of(samples), result.experiments.back().fit.y);
    add_free(result.experiments.back().fit.free, result.free);
  }
  result.fit_percent = fit_percent(all);
  result.mse = mean_square_error(all);
}

/// See Identification::left_by_free_states.
double left_by_free_states(const Identification& found, const std::vector<Record>& records,
                           const IdentifySettings& settings) {
  const InitialChoice all = all_free(found.model);
  if (settings.criterion == Criterion::kPrediction || settings.initial.free == all.free) return 1.0;
  ErrorSums as_fitted;
  ErrorSums freed;
  for (std::size_t e = 0; e < records.size(); ++e) {
    const std::vector<Sample> part = beginning(records[e].samples, kBeginning);
    const std::vector<double> y = speeds_of(part);
    const auto error_from = [&](const InitialStates& initial) {
      return error_sums(y, simulation_fit(found.model, initial, part, settings.propagation).y);
    };
    as_fitted += error_from(found.experiments[e].fit.initial);
    freed += error_from(fit_initial_states(found.model, all, part, settings.propagation));
  }
  const double left = mean_square_error(freed) / mean_square_error(as_fitted);
  return left < 1.0 ? left : 1.0;
}

/// Criteria that weigh a better fit against d free variables, as MATLAB defines them.
void report_criteria(double measurements, double d, Identification& result) {
  const double share = d / measurements;
  const double mse = result.noise ? std::pow(result.noise->rmse, 2) : result.mse;
  result.fpe = mse * (1.0 + share) / (1.0 - share);
  const double likelihood =  // -2 ln L
      result.noise ? -2.0 * result.noise->log_likelihood
                   : measurements * (std::log(2.0 * std::numbers::pi * mse) + 1.0);
  result.aic = likelihood + 2.0 * d;
  result.bic = likelihood + d * std::log(measurements);
}

/// What the predictions at that search's end say of the noise.
PredictionNoise noise_of(const FoundMinimum& found, const OutputError& error,
                         const OutputError::Evaluation& at) {
  PredictionNoise noise;
  if (!at.valid) return noise;
  const double n = error.measured();
  noise.sensor_sd = std::sqrt(at.r.squaredNorm() / n);
  noise.torque_density = found.noise->density * found.model.heaviness() * noise.sensor_sd;
  noise.sensor_pole = found.noise->sensor_pole;
  noise.torque_pole = found.noise->torque_pole;
  noise.motor_alone = found.noise->motor_alone;
  noise.correlation = largest_correlation(at.r);
  noise.log_likelihood =
      -0.5 * n * (std::log(2.0 * std::numbers::pi * std::pow(noise.sensor_sd, 2)) + 1.0) -
      log_innovation_sd(found.gains);
  double sum = 0.0;
  Eigen::Index row = 0;
  for (const Gains& gains : found.gains)
    for (const double sd : gains.innovation_sd) {
      if (std::isfinite(sd)) sum += std::pow(at.r[row] * sd, 2);
      ++row;
    }
  noise.rmse = std::sqrt(sum / n);
  return noise;
}

/// Initial states that a search is to find: where a filter corrects the states as it goes, only
/// those that it does not. The others would hardly change what is weighed, and so run away.
InitialChoice to_be_found(const Model& model, const IdentifySettings& settings) {
  InitialChoice initial = settings.initial;
  if (settings.criterion == Criterion::kSimulation) return initial;
  const std::vector<int> uncorrected = prediction_choice(model).free;
  std::erase_if(initial.free, [&](int state) {
    return std::ranges::find(uncorrected, state) == uncorrected.end();
  });
  return initial;
}

/// Searches with Huber's loss from the model's values. Outliers may have spoilt the fit by squares,
/// from which the first scale comes, so that the scale is taken again from what each search left.
Minimum robust_search(const OutputError& error, Variables variables, Minimum found,
                      const SearchLimits& limits, double& huber_scale) {
  constexpr int kRounds = 3;  // the scale no longer changes after
  int iterations = 0;
  int evaluations = 0;
  for (int round = 0; round < kRounds; ++round) {
    const OutputError::Evaluation at = error.evaluate(found.z.data());
    const double bulk = at.valid ? bulk_deviation(at.r) : 0.0;
    if (!(bulk > 0.0)) break;  // nothing to weigh against
    huber_scale = kHuber * bulk;
    found = search(error, variables, huber_scale, limits);
    stop_if_asked(limits.stop);
    variables.start = found.z;
    iterations += found.iterations;
    evaluations += found.evaluations;
  }
  found.iterations = iterations;
  found.evaluations = evaluations;
  return found;
}

}  // namespace

Identification identify(const Model& model, const std::vector<Record>& records,
                        const IdentifySettings& settings) {
  return identify_pieces(model, split_at_gaps(records, settings.longest_gap_s), settings);
}

Identification identify_pieces(const Model& model, const std::vector<Record>& records,
                               const IdentifySettings& asked) {
  IdentifySettings settings = asked;
  settings.initial = to_be_found(model, asked);
  const Crew crew(settings.threads);
  const OutputError unfitted(model, records, settings.initial, settings.propagation);
  check_length(unfitted, records);
  check_interval(records);
  SearchTask task{records, settings.initial, settings.propagation, limits_for(unfitted),
                  settings.derivatives};
  task.limits.iterations = settings.iterations;
  task.limits.stop = settings.stop;
  const std::vector<FoundMinimum> all = search_all(model, task, settings);
  const FoundMinimum& found = all.front();
  Minimum best = found.minimum;
  const OutputError error(found.model, records, settings.initial, settings.propagation,
                          found.gains);

  Identification result;
  result.starts = static_cast<int>(all.size());
  const double same = found.loss + 0.5 * error.measured() * std::log1p(kSameMinimum);
  result.agreeing = static_cast<int>(std::ranges::count_if(
      all, [&](const FoundMinimum& f) { return std::isfinite(f.minimum.cost) && f.loss <= same; }));
  result.huber_scale = kInfinite;
  for (const FoundMinimum& f : all) {
    result.iterations += f.minimum.iterations;
    result.evaluations += f.minimum.evaluations;
  }
  if (settings.robust) {
    const Variables start = unfitted.variables_of_model(settings.first_states);
    best = robust_search(error, start, best, task.limits, result.huber_scale);
    result.iterations += best.iterations;
    result.evaluations += best.evaluations;
  }
  result.converged = best.converged;
  result.termination = best.termination;
  result.model = error.model_at(best.z.data());
  const OutputError::Evaluation at = error.evaluate(best.z.data());
  const Spread spread = spread_at(error, at, result.huber_scale);
  std::vector<InitialStates> initial;
  for (std::size_t e = 0; e < records.size(); ++e)
    initial.push_back(
        initial_states(error, settings.initial.free, best.z, static_cast<int>(e), spread));
  if (found.noise) result.noise = noise_of(found, error, at);
  std::vector<double> block_sd;
  if (settings.jackknife && error.unknowns() > 0 && std::isfinite(best.cost) && at.valid)
    block_sd = jackknife_deviations({error, best.z, at, records, !found.gains.empty(),
                                     settings.propagation, result.huber_scale});
  report_parameters(spread, block_sd, result);
  report_experiments(records, settings, initial, result);
  report_criteria(error.measured(), error.variables(), result);
  result.left_by_free_states = left_by_free_states(result, records, settings);
  return result;
}

}  // namespace armukf
