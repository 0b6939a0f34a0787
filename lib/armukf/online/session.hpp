#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/core/square_matrix.hpp"
#include "armukf/model/model.hpp"
#include "armukf/online/condition.hpp"
#include "armukf/online/settings.hpp"

namespace armukf {

/// What became of a sample's measurement.
enum class Status { kOk, kMissing, kRejected, kGap, kReset };
std::string_view name_of(Status status);

/// What is believed after a sample. The spans stay valid until the next step.
struct Estimate {
  Sample sample;
  double predicted;       // rad/s, y before the measurement was seen
  double innovation;      // rad/s, y - predicted; NaN if missing
  double innovation_sd;   // rad/s
  double nis;             // innovation^2 / innovation_sd^2; NaN if missing
  double log_likelihood;  // of this measurement, given those before; 0 if it was not used
  Status status;
  std::span<const double> values;      // states, then unknown parameters, physical
  std::span<const double> deviations;  // one standard deviation of each
};

/// A recursive estimate of states and unknown parameters: a sample in, what is believed out.
/// Nothing is allocated per sample: only once more, when the start has been decided and the
/// beginning is looked at again.
class Session {
 public:
  Session(const Model& model, const EstimatorSettings& settings);
  ~Session();
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;

  /// Takes the next sample. Whatever it holds, the belief stays sound: one whose time is not later
  /// than the last one's, or no number, is passed over (kRejected); an infinite speed, or one that
  /// no machine has, is rejected; a torque that is no number is taken for the last one.
  Estimate step(const Sample& sample);

  /// The clock was set: how much time lies between the last sample and the next is not known, and
  /// the next one's time, whatever it is, goes on from there. A gap to the filter.
  void expect_new_clock();

  /// The whole belief as bytes: filters and their noise, race, clock. A session made of the same
  /// model and settings goes on from there with the same numbers, to the last bit if it is the same
  /// build on the same processor.
  ///
  /// Format: a seal (core/sealed.hpp: magic `armukf_s`, version, checksum, length); a text that
  /// describes model and settings; how many filters there are (64 bits), and each of them: mean
  /// and covariance (or its root), the last interval, parameters, model error, noise factors,
  /// clocks, likelihood; then samples for a second look, whether the race is over and its best,
  /// last time and torque, values and deviations; what a watch has found of the known parameters,
  /// drive and sensor, and the last torques. See core/archive.hpp for how numbers stand.
  std::string save() const;

  /// Takes such a belief for its own. InputError, saying why, where the bytes are damaged, cut
  /// short, something else, of another version, or of another model, filter or setting; the session
  /// is then as it was.
  void load(std::string_view bytes);

  /// Whether the race of the starts is over, and which of them (starts_of, in race.hpp) has won it.
  bool decided() const;
  std::size_t start() const;

  /// Whether it will soon go over the samples of its beginning again, from what it has found by
  /// then, has done so less than a second ago, or still has rivals that might take the lead: what
  /// it believes of the parameters may change by more than samples can tell.
  bool may_change_its_mind() const;

  /// The same, or whether what it believes hangs on how much of the noise is the torque's, which
  /// the samples do not tell: the deviations are a guide.
  bool is_settling() const;

  /// The model with the unknown parameters as believed now; before the first sample, as at the
  /// start.
  Model model() const;

  /// One standard deviation of each parameter of the model; 0 for a known one. It is the one to be
  /// believed, whatever the noise: that of the belief, or more where stretches of the samples
  /// contradict each other (ScoreSpread), and until the second look, while start values are left.
  std::vector<double> parameter_deviations() const;

  /// The same as the belief has it, which takes model and noise at their word.
  std::vector<double> model_deviations() const;

  /// Covariance of the unknown parameters, in their order, to go with parameter_deviations().
  SquareMatrix parameter_covariance() const;

  /// Names of the unknown parameters of which the samples told hardly anything: more than 0.7 of
  /// the deviation is left that they began with, relative to the value where that has no upper
  /// bound.
  std::vector<std::string> hardly_told() const;

  /// The noise that was learnt, and how much of the innovations is none.
  LearntNoise noise() const;

  /// What an estimate goes on from, with model().
  ParameterBelief belief() const;

  /// The same and all parameters' values, into what has taken them before: nothing is allocated.
  void remember(std::vector<double>& values, ParameterBelief& belief) const;

  /// Believes of the parameters, known or unknown, what this says (one value per parameter of the
  /// model), and goes on from where the states are. From now on drive and sensor are taken to be as
  /// in the condition: what comes in is corrected for them, and what is predicted is not. Nothing
  /// is allocated.
  void believe(const std::vector<double>& values, const ParameterBelief& belief,
               const Condition& condition);

  /// What it has seen lately was of a machine that has changed since: the noise is learnt anew.
  void begin_noise_anew();

  /// What drive and sensor are taken to be; of the rest the parameters tell.
  const Condition& condition() const;

 private:
  struct State;
  void covariance_into(SquareMatrix& covariance) const;

  std::unique_ptr<State> state_;
};

}  // namespace armukf
