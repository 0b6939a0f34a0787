#include "armukf/batch/frequency_start.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "armukf/batch/frequency_response.hpp"
#include "armukf/batch/identify.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/error.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/core/segments.hpp"
#include "armukf/fit/least_squares.hpp"
#include "armukf/model/coordinates.hpp"
#include "armukf/model/plant.hpp"
#include "armukf/model/resonances.hpp"

namespace armukf {
namespace {

constexpr int kFewestLines = 30;
constexpr int kGridFrequencies = 18;      // over the excited band, in equal ratios
constexpr double kGuessedDamping = 0.02;  // ratio of both springs, in the grid
constexpr int kRefined = 40;              // candidates of the grid
constexpr int kVerified = 5;              // candidates that are simulated
constexpr int kRefinement = 25;           // iterations, on the lines
constexpr int kShortSearch = 30;          // iterations
/// Hardening of the gear's spring at its usual twist, relative to k_g1: the frequency response does
/// not tell it, but the way down to the minimum depends on it.
constexpr std::array kHardenings{0.0, 0.03, 0.1};
/// A simulation error within this factor of the least does not tell a wrong candidate from a right
/// one where the model lacks something; the frequency response then decides.
constexpr double kAlike = 1.25;
constexpr double kSameMisfit = 1e-3;  // relative; closer ones are one candidate
constexpr double kLongestMove = 1.5;  // of a logarithm, when a candidate is refined
constexpr double kDifference = 1e-5;  // of a coordinate, for a derivative

struct Candidate {
  Model model;
  double misfit;
};

/// How far the model is from the lines: (speed - G torque) / (|speed| + |G torque|), at most 1, so
/// that no sharp peak outweighs the rest; weighted so that every octave counts alike. Two numbers
/// per line.
void add_misfits(const Model& model, const std::vector<Line>& lines, double* r) {
  const FrequencyResponse response(model);
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const std::complex<double> expected = response(lines[k].w) * lines[k].torque;
    const std::complex<double> misfit = std::sqrt(lines.front().w / lines[k].w) *
                                        (lines[k].speed - expected) /
                                        (std::abs(lines[k].speed) + std::abs(expected));
    r[2 * k] = misfit.real();
    r[2 * k + 1] = misfit.imag();
  }
}

double misfit_of(const Model& model, const std::vector<Line>& lines) {
  std::vector<double> r(2 * lines.size());
  add_misfits(model, lines, r.data());
  double sum = 0.0;
  for (const double v : r) sum += v * v;
  return std::isfinite(sum) ? sum : kInfinite;
}

Model with_resonances(Model model, const Resonances& resonances) {
  set_resonances(model, resonances, kGuessedDamping);
  return model;
}

/// Every choice of two zeros and two poles that take turns on a grid over the lines' band; the best
/// first.
std::vector<Candidate> grid(const Model& model, const std::vector<Line>& lines) {
  const double ratio = lines.back().w / lines.front().w;
  std::array<double, kGridFrequencies> w;
  for (int i = 0; i < kGridFrequencies; ++i)
    w[i] = lines.front().w * std::pow(ratio, i / (kGridFrequencies - 1.0));
  std::vector<Candidate> candidates;
  for (int a = 0; a < kGridFrequencies; ++a)
    for (int b = a + 1; b < kGridFrequencies; ++b)
      for (int c = b + 1; c < kGridFrequencies; ++c)
        for (int d = c + 1; d < kGridFrequencies; ++d) {
          const Model tried = with_resonances(model, {{w[a], w[c]}, {w[b], w[d]}});
          candidates.push_back({tried, misfit_of(tried, lines)});
        }
  std::ranges::sort(candidates, {}, &Candidate::misfit);
  return candidates;
}

/// The model with just the sought parameters unknown, within no bounds but their signs.
Model for_search(Model model) {
  for (Parameter& p : model.parameters) p.known = true;
  for (const int i : kResonantParameters) {
    Parameter& p = model.parameters[i];
    p.known = false;
    p.lower = 0.0;
    p.upper = p.share ? 1.0 : kUnbounded;
  }
  return model;
}

/// The candidate moved to the nearest minimum of its misfit.
Candidate refined(const Candidate& candidate, const std::vector<Line>& lines) {
  const Model searched = for_search(candidate.model);
  const FreeCoordinates coordinates(searched);
  const std::vector<double> p = searched.values();
  const auto model_at = [&](const double* z) {
    Model model = candidate.model;
    std::vector<double> physical(kMaxParameters);
    coordinates.to_physical(z, physical.data());
    for (const int i : coordinates.unknowns()) model.parameters[i].value = physical[i];
    return model;
  };
  const int residuals = static_cast<int>(2 * lines.size());
  const Residuals f = [&](const double* z, double* r, double* gradient) {
    add_misfits(model_at(z), lines, r);
    std::vector<double> at(z, z + coordinates.size());
    std::vector<double> above(residuals);
    std::vector<double> below(residuals);
    for (int j = 0; gradient != nullptr && j < coordinates.size(); ++j) {
      at[j] = z[j] + kDifference;
      add_misfits(model_at(at.data()), lines, above.data());
      at[j] = z[j] - kDifference;
      add_misfits(model_at(at.data()), lines, below.data());
      at[j] = z[j];
      for (int i = 0; i < residuals; ++i)
        gradient[i * coordinates.size() + j] = (above[i] - below[i]) / (2.0 * kDifference);
    }
    return std::all_of(r, r + residuals, [](double v) { return std::isfinite(v); });
  };
  Variables variables{coordinates.from_physical(p), {}, {}};
  for (const double z : variables.start) {
    variables.lower.push_back(z - kLongestMove);
    variables.upper.push_back(z + kLongestMove);
  }
  const Minimum found = least_squares(variables, residuals, f, {kRefinement, 1e-6});
  return {model_at(found.z.data()), 2.0 * found.cost};
}

/// The best few refined candidates, each minimum once.
std::vector<Candidate> distinct_minima(const std::vector<Candidate>& candidates,
                                       const std::vector<Line>& lines) {
  std::vector<Candidate> minima;
  for (int i = 0; i < std::min<int>(kRefined, static_cast<int>(candidates.size())); ++i)
    minima.push_back(refined(candidates[i], lines));
  std::ranges::sort(minima, {}, &Candidate::misfit);
  const auto same = [](const Candidate& a, const Candidate& b) {
    return b.misfit - a.misfit < kSameMisfit * a.misfit;
  };
  minima.erase(std::unique(minima.begin(), minima.end(), same), minima.end());
  if (minima.size() > kVerified) minima.erase(minima.begin() + kVerified, minima.end());
  return minima;
}

/// A short output-error search over the model's own unknowns, with all initial states free: what
/// is fixed wrongly there makes side valleys of its own. Infinite where the start cannot be
/// simulated.
Candidate searched(const Model& model, const Record& record, const Propagation& propagation) {
  IdentifySettings settings;
  settings.propagation = propagation;
  settings.initial = all_free(model);
  settings.iterations = kShortSearch;
  settings.derivatives = Precision::kSingle;
  settings.step_by_step = false;
  settings.jackknife = false;  // only where it ends counts
  const Identification found = identify(model, {record}, settings);
  return {found.model, found.mse};
}

/// The usual twist (rad) of the gear's spring, as if it carried all of the torque.
double usual_twist(const Model& model, const std::vector<Sample>& samples) {
  double sum = 0.0;
  for (const Sample& s : samples) sum += s.u * s.u;
  return std::sqrt(sum / static_cast<double>(samples.size())) /
         model.parameters[kHardenedStiffness].value;
}

/// Where a candidate's searches begin, each at another hardening.
std::vector<Model> starts_of(const Model& candidate, const Record& record) {
  if (candidate.parameters[kHardening].known) return {candidate};
  const double twist = usual_twist(candidate, record.samples);
  std::vector<Model> starts;
  for (const double hardening : kHardenings) {
    starts.push_back(candidate);
    starts.back().parameters[kHardening].value =
        hardening * candidate.parameters[kHardenedStiffness].value / (twist * twist);
  }
  return starts;
}

/// Where the lowest of each candidate's searches ended; infinite where none of them could be
/// simulated.
std::vector<Candidate> verified(const std::vector<Candidate>& candidates, const Record& record,
                                const Propagation& propagation) {
  std::vector<Model> starts;
  std::vector<std::size_t> candidate_of;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    for (Model& start : starts_of(candidates[i].model, record)) {
      starts.push_back(std::move(start));
      candidate_of.push_back(i);
    }
  std::vector<Candidate> found(starts.size());
  for_each_job(static_cast<int>(starts.size()),
               [&](int i) { found[i] = searched(starts[i], record, propagation); });
  std::vector<Candidate> best;
  best.reserve(candidates.size());
  for (const Candidate& candidate : candidates) best.push_back({candidate.model, kInfinite});
  for (std::size_t i = 0; i < found.size(); ++i)
    if (found[i].misfit < best[candidate_of[i]].misfit) best[candidate_of[i]] = std::move(found[i]);
  return best;
}

/// The longest piece of the record without a gap.
Record longest_piece(const Record& record) {
  std::vector<Record> pieces = split_at_gaps({record});
  return *std::ranges::max_element(pieces, {}, [](const Record& r) { return r.samples.size(); });
}

}  // namespace

Model from_frequency_response(Model model, const Record& record, const Propagation& propagation) {
  const Record piece = longest_piece(record);
  const std::vector<Line> lines = excited_lines(model, piece.samples);
  if (lines.size() < kFewestLines)
    throw InputError(record.name, 0, "u",
                     fmt::format("excites {} frequencies; {} are needed for a frequency response",
                                 lines.size(), kFewestLines));
  const std::vector<Candidate> searches =
      verified(distinct_minima(grid(model, lines), lines), piece, propagation);
  const double least = std::ranges::min_element(searches, {}, &Candidate::misfit)->misfit;
  if (!std::isfinite(least))
    throw InputError(record.name, 0, "y",
                     "cannot be simulated with any values that its frequency response suggests");
  const Candidate& best = *std::ranges::find_if(
      searches, [&](const Candidate& c) { return c.misfit <= kAlike * least; });
  for (int i = 0; i < kArmParameters; ++i)
    if (!model.parameters[i].known) model.parameters[i].value = best.model.parameters[i].value;
  return model;
}

}  // namespace armukf
