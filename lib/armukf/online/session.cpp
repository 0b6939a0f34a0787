#include "armukf/online/session.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <variant>

#include "armukf/core/archive.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/error.hpp"
#include "armukf/model/plant.hpp"
#include "armukf/online/description.hpp"
#include "armukf/online/filters.hpp"
#include "armukf/online/held_shapes.hpp"
#include "armukf/online/race.hpp"
#include "armukf/online/runner.hpp"
#include "armukf/online/seals.hpp"
#include "armukf/online/widening.hpp"

namespace armukf {
namespace {

/// A runner of any filter of the registries.
template <class... F>
std::variant<Runner<F>...> runner_of(TypeList<F...>);
using AnyRunner = decltype(runner_of(FilterTypes<PublishedShape>() + FilterTypes<ColouredShape>() +
                                     FilterTypes<CompletedShape>() + FilterTypes<AnyShape>()));

/// Whether the noises, which have colours, are to be learnt.
bool learns_noise(const EstimatorSettings& settings) {
  return !is_adaptive(settings.filter) && settings.noise.model_error.gain > 0.0 &&
         settings.noise.learning.most_torque != 0.0;
}

AnyRunner make_runner(const Model& model, const FreeCoordinates& coordinates,
                      const EstimatorSettings& settings) {
  return with_shape(model, coordinates, learns_noise(settings), [&](auto shape) {
    return with_filter("an estimate", Filters<decltype(shape)>(), kind_of(settings.filter), shape,
                       settings.spread, [&](auto filter) -> AnyRunner {
                         return Runner(Engine(model, coordinates, settings, filter), settings.gate);
                       });
  });
}

template <class... F>
std::vector<std::string_view> names_of(TypeList<F...> /*registry*/) {
  return {F::name...};
}

/// s; what is taken to lie between two clocks, at least: a gap by any measure.
constexpr double kLeastPause = 10.0;
constexpr double kPauseInIntervals = 100.0;

double log_likelihood(const AnyRunner& runner) {
  return std::visit([](const auto& r) { return r.log_likelihood(); }, runner);
}

/// A second look at the samples of the beginning, from that start, with the noise that a first one
/// has learnt, or that part of the torque's. Likelihood counts from their end on.
AnyRunner second_look(const AnyRunner& first, const Start& start, std::span<const Sample> samples,
                      double part_of_torque = 1.0) {
  return std::visit(
      [&](const auto& runner) -> AnyRunner {
        auto again = runner.anew();
        again.engine().look_again(runner.engine(), start.values, part_of_torque);
        again.engine().begin_at(start.places);
        for (const Sample& sample : samples) again.step(sample);
        again.forget_likelihood();
        return again;
      },
      first);
}

/// What a runner believes of the unknown parameters: all parameters of the model, and of the
/// unknown ones the deviations.
struct BelievedParameters {
  std::array<double, kMaxParameters> values;
  std::array<double, kMaxParameters> deviations;
};

BelievedParameters parameters_of(const AnyRunner& runner) {
  BelievedParameters believed{};
  std::visit(
      [&](const auto& r) {
        std::copy_n(r.engine().parameters(), kMaxParameters, believed.values.begin());
        r.engine().deviations(believed.deviations.data());
      },
      runner);
  return believed;
}

}  // namespace

std::string_view name_of(Status status) {
  constexpr std::array<std::string_view, 5> kNames{"ok", "missing", "rejected", "gap", "reset"};
  return kNames[static_cast<int>(status)];
}

constexpr std::string_view kAdaptive = "adaptive";

bool is_adaptive(std::string_view filter) { return filter.starts_with(kAdaptive); }

std::string_view kind_of(std::string_view filter) {
  if (!is_adaptive(filter)) return filter;
  filter.remove_prefix(kAdaptive.size());
  if (filter.empty()) return names_of(Filters<PublishedShape>()).front();
  filter.remove_prefix(1);  // the underscore
  return filter;
}

std::vector<std::string> filter_names() {
  const std::vector<std::string_view> kinds = names_of(Filters<PublishedShape>());
  std::vector<std::string> names(kinds.begin(), kinds.end());
  names.emplace_back(kAdaptive);
  for (std::size_t i = 1; i < kinds.size(); ++i)
    names.push_back(fmt::format("{}_{}", kAdaptive, kinds[i]));
  return names;
}

std::vector<std::string> smoothing_filter_names() {
  const std::vector<std::string_view> names = names_of(SmoothingFilters<PublishedShape>());
  return {names.begin(), names.end()};
}

std::string find_filter(std::string_view name) {
  const std::vector<std::string> names = filter_names();
  if (std::ranges::find(names, name) != names.end()) return std::string(name);
  throw InputError(fmt::format("unknown filter '{}'; known are: {}", name, fmt::join(names, ", ")));
}

/// Samples that are kept for a second look: 4 s at 2 kHz.
constexpr std::size_t kMostBeginning = 8192;
/// s, watched, before the second look, unless so many samples come sooner: the longer it is, the
/// more of what a start far off has spoilt is learnt anew; beyond that the first look has learnt
/// too much to be thrown away.
constexpr double kLookBackS = 3.0;

/// Runners of the race that look again.
constexpr std::size_t kFinalists = 2;
/// Nats by which a rival of the leader may be less likely since the second look.
constexpr double kLessLikely = 12.0;
/// s, watched, by which the leader goes on alone in any case.
constexpr double kRivalsS = 20.0;
/// Of the torque's noise that was learnt, what a filter that doubts it begins with.
constexpr double kDoubtedPart = 0.1;

struct Session::State {
  State(const Model& m, const EstimatorSettings& s);

  Estimate step(const Sample& sample);
  Estimate pass_over(const Sample& sample) const;
  Sample usable(Sample sample);
  void report(const AnyRunner& leader);
  bool leaves_start() const;
  double unsettled(int k, double sd) const;
  double spread(const AnyRunner& leader, int k) const;
  void decide();
  void end_race();
  void look_back();
  void give_up_rivals(double watched);
  bool agree(const BelievedParameters& a, const BelievedParameters& b) const;
  bool is_hardly_told(const AnyRunner& runner, int k) const;
  bool is_told_anything(const AnyRunner& runner) const;
  std::size_t most_runners() const;
  void keep(const Sample& sample);
  const AnyRunner& leader() const;
  template <class Visit>
  void visit_all(const Visit& visit);
  const Moment& moment() const;
  double session_time(double t) const;
  double usual_interval() const { return last_interval > 0.0 ? last_interval : 1.0; }
  void as_measured(Estimate& estimate) const;

  template <class Archive>
  void archive(Archive& archive);

  std::string described;  // model and settings as they were given
  Model model;
  FreeCoordinates coordinates;
  EstimatorSettings settings;
  std::vector<AnyRunner> runners;
  std::optional<AnyRunner> doubter;  // of the noise that was learnt; never leads
  bool raced = false;
  std::array<std::size_t, kFinalists> finalists{};  // the race's best, positions in starts_of
  std::optional<double> last_time;  // s, session's, of the last sample that was taken
  double last_interval = 0.0;       // s
  double clock_offset = 0.0;        // s, from the samples' clock to the session's, which goes on
  bool new_clock = false;           // of the next sample
  double last_torque = 0.0;         // N.m
  Condition wiring;                 // of drive and sensor, where a change has been found
  TorqueMemory torques;
  std::vector<Sample> beginning;  // for a second look
  bool keeps_beginning = false;
  std::vector<double> values;
  std::vector<double> deviations;
  std::vector<double> first_variances;   // of the free coordinates, before the first sample
  std::vector<double> first_deviations;  // of the unknowns, as reported
};

Session::State::State(const Model& m, const EstimatorSettings& s)
    : described(description(m, s)), model(m), coordinates(m), settings(s) {
  find_filter(s.filter);
  if (settings.belief) {  // nothing to race for, nor to be annealed
    settings.race.starts = {{}};
    settings.noise.parameter_walk.start = settings.noise.parameter_walk.floor;
  }
  const double n = static_cast<double>(model.states.size()) + coordinates.size();
  if (!(s.spread.alpha > 0.0 && n + s.spread.kappa > 0.0))
    throw InputError(fmt::format(
        "kappa: {} is too small: alpha and n + kappa must be above 0, n = {} states and unknowns",
        s.spread.kappa, n));
  if (s.adaptation.least > s.adaptation.most)
    throw InputError(fmt::format("adaptation: least, {}, is above most, {}", s.adaptation.least,
                                 s.adaptation.most));
  runners.reserve(most_runners());
  std::vector<int> held;
  if (settings.belief) held = held_shapes(model, *settings.belief);
  for (const Start& start : starts_of(model, settings.race)) {
    runners.push_back(make_runner(model, coordinates, settings));
    std::visit(
        [&](auto& r) {
          r.engine().believe_parameters(start.values);
          r.engine().begin_at(start.places);
          if (settings.belief) r.engine().go_on_from(*settings.belief, held);
        },
        runners.back());
  }
  raced = runners.size() == 1;
  if (learns_noise(settings) && !settings.belief) {
    beginning.reserve(kMostBeginning);
    keeps_beginning = true;
  }
  values.resize(model.states.size() + coordinates.size());
  deviations.resize(values.size());
  std::visit(
      [&](const auto& r) {
        for (int k = 0; k < coordinates.size(); ++k)
          first_variances.push_back(r.engine().free_variance(k));
        first_deviations.resize(coordinates.size());
        r.engine().deviations(first_deviations.data());
      },
      runners.front());
  report(runners.front());
}

/// How many there may be at a time.
std::size_t Session::State::most_runners() const {
  return std::max(starts_of(model, settings.race).size(),
                  kFinalists + settings.race.starts.size() - 1);
}

/// Ends the race once its time is over: the likeliest runner goes on, and later looks at the
/// beginning again, beside rivals until these are given up.
void Session::State::decide() {
  const double watched = moment().watched;
  if (watched < settings.race.duration_s) return;
  if (!raced) end_race();
  if (watched >= kLookBackS || beginning.size() == kMostBeginning) look_back();
  if ((runners.size() > 1 || doubter) && !keeps_beginning) give_up_rivals(watched);
}

/// Leaves the likeliest of all, and the next one where it may look again.
void Session::State::end_race() {
  const std::size_t count = keeps_beginning ? kFinalists : 1;
  std::vector<std::size_t> start(runners.size());
  std::iota(start.begin(), start.end(), std::size_t{0});
  for (std::size_t i = 0; i < count; ++i) {
    const auto best = std::ranges::max_element(std::span(runners).subspan(i), {}, log_likelihood);
    const std::size_t at =
        i + static_cast<std::size_t>(best - std::span(runners).subspan(i).begin());
    std::swap(runners[i], runners[at]);
    std::swap(start[i], start[at]);
    finalists[i] = start[i];
  }
  runners.resize(count, runners.front());
  raced = true;
}

/// Looks at the beginning again once the noise is known; until it is the winner goes on alone, and
/// where it is not known in time does not look at all.
/// A motion may tell the right arm from a wrong one only later, when a filter would be too sure of
/// the wrong one to leave it: so the next best of the race looks again as well, and the winner from
/// its own parameters times each start's factors.
/// The torque's noise was learnt with parameters that were still far off, and where a controller
/// brings the sensor's noise into the torque, too much of it bends what tells the motor's share,
/// which again looks like that noise. A filter that begins with less of it goes on beside them, to
/// tell how much hangs on it.
void Session::State::look_back() {
  if (beginning.empty()) return;
  if (!std::visit([](const auto& r) { return r.engine().has_learnt(); }, runners.front())) {
    if (runners.size() > 1) runners.resize(1, runners.front());
    return;
  }
  const AnyRunner first = runners.front();
  const std::vector<Start> starts = starts_of(model, settings.race);
  const auto with_parameters_of = [&](const AnyRunner& runner) {
    Model found = model;
    const BelievedParameters believed = parameters_of(runner);
    for (std::size_t i = 0; i < found.parameters.size(); ++i)
      found.parameters[i].value = believed.values[i];
    return found;
  };
  const auto look = [&](const std::vector<double>& from, std::size_t finalist, double part = 1.0) {
    return second_look(first, {from, starts[finalists[finalist]].places}, beginning, part);
  };
  for (std::size_t i = 0; i < runners.size(); ++i)
    runners[i] = look(with_parameters_of(runners[i]).values(), i);
  for (const StartFactors& factors : settings.race.starts)
    if (!factors.empty())
      runners.push_back(look(start_values(with_parameters_of(first), factors), 0));
  doubter = look(with_parameters_of(first).values(), 0, kDoubtedPart);
  beginning.clear();
  keeps_beginning = false;
}

/// Whether two have come to the same arm: no unknown off by more than the smaller of its
/// deviations.
bool Session::State::agree(const BelievedParameters& a, const BelievedParameters& b) const {
  for (int k = 0; k < coordinates.size(); ++k) {
    const int i = coordinates.unknowns()[k];
    if (!(std::abs(a.values[i] - b.values[i]) < std::min(a.deviations[k], b.deviations[k])))
      return false;
  }
  return true;
}

/// Whether the samples have told hardly anything of an unknown. A share of inertia is told where
/// its own deviation is, though its coordinate holds another mass' as well.
bool Session::State::is_hardly_told(const AnyRunner& runner, int k) const {
  constexpr double kLeft = 0.7;  // of the deviation: half of the variance
  return std::visit(
      [&](const auto& r) {
        if (!(r.engine().free_variance(k) > kLeft * kLeft * first_variances[k])) return false;
        if (model.parameters[coordinates.unknowns()[k]].upper == kUnbounded) return true;
        std::array<double, kMaxParameters> sd;
        r.engine().deviations(sd.data());
        return sd[k] > kLeft * first_deviations[k];
      },
      runner);
}

/// Whether it still leaves the start values, which it will look at again.
bool Session::State::leaves_start() const {
  return (!raced || keeps_beginning) && settings.noise.model_error.gain > 0.0;
}

/// By what the deviation of an unknown is multiplied until the second look. While the start values
/// are being left, what a wrong arm leaves of the samples is alike over tens of them; a filter
/// takes each for as much as if it were noise, and is too sure of an arm that it only happens to
/// pass.
double Session::State::unsettled(int k, double sd) const {
  constexpr double kAlike = 30.0;  // samples that tell as much as one
  const double first = first_deviations[k];
  if (!leaves_start() || !(sd > 0.0 && sd < first)) return 1.0;
  return std::sqrt(kAlike / (1.0 + (kAlike - 1.0) * std::pow(sd / first, 2)));
}

/// How far the filters that go on beside the leader are from its k-th unknown: each counts the
/// less, the less likely it is, down to where it is given up. What little motion tells, as slow
/// motion does of masses and springs, several arms explain nearly as well, and each is too sure of
/// its own.
double Session::State::spread(const AnyRunner& leader, int k) const {
  if (!raced || keeps_beginning || (runners.size() == 1 && !doubter)) return 0.0;
  const auto value = [&](const AnyRunner& runner) {
    return std::visit(
        [&](const auto& r) { return r.engine().parameters()[coordinates.unknowns()[k]]; }, runner);
  };
  const double its = value(leader);
  const auto weight = [&](const AnyRunner& runner) {
    const double behind = log_likelihood(leader) - log_likelihood(runner);
    return std::exp(-std::max(0.0, behind) / kLessLikely);
  };
  const auto apart = [&](const AnyRunner& runner) {
    const double difference = value(runner) - its;
    return weight(runner) * difference * difference;
  };
  double sum = 0.0;
  double weights = 0.0;
  for (const AnyRunner& runner : runners) {
    sum += apart(runner);
    weights += weight(runner);
  }
  return std::sqrt(sum / weights + (doubter ? apart(*doubter) : 0.0));
}

bool Session::State::is_told_anything(const AnyRunner& runner) const {
  for (int k = 0; k < coordinates.size(); ++k)
    if (!is_hardly_told(runner, k)) return true;
  return false;
}

/// The likeliest leads. Rivals that are much less likely or have come to the same arm are given up,
/// and all of them where the samples tell of no unknown which arm it is.
void Session::State::give_up_rivals(double watched) {
  const auto likeliest = std::ranges::max_element(runners, {}, log_likelihood);
  if (likeliest != runners.begin()) std::iter_swap(runners.begin(), likeliest);
  const AnyRunner& leader = runners.front();
  const bool over = watched > kRivalsS || !is_told_anything(leader);
  const double least = log_likelihood(leader) - kLessLikely;
  const BelievedParameters arm = parameters_of(leader);
  const auto hopeless = [&](const AnyRunner& rival) {
    return over || log_likelihood(rival) < least || agree(arm, parameters_of(rival));
  };
  runners.erase(std::remove_if(runners.begin() + 1, runners.end(), hopeless), runners.end());
  if (doubter && hopeless(*doubter)) doubter.reset();
}

/// What becomes of a sample whose time cannot be: nothing.
Estimate Session::State::pass_over(const Sample& sample) const {
  return {.sample = sample,
          .predicted = kNaN,
          .innovation = kNaN,
          .innovation_sd = kNaN,
          .nis = kNaN,
          .log_likelihood = 0.0,
          .status = Status::kRejected,
          .values = values,
          .deviations = deviations};
}

/// The time of the samples' clock by the session's.
double Session::State::session_time(double t) const {
  if (!new_clock || !last_time) return t + clock_offset;
  return *last_time + std::max({kLeastPause, 2.0 * settings.gate.longest_gap_s,
                                kPauseInIntervals * last_interval});
}

/// The sample as filters can take it: by the session's clock, no speed that no machine has, and the
/// last torque where there is none.
Sample Session::State::usable(Sample sample) {
  const double t = session_time(sample.t);
  if (new_clock) {
    clock_offset = last_time ? t - sample.t : 0.0;
    new_clock = false;
  } else if (last_time) {
    last_interval = t - *last_time;
  }
  sample.t = t;
  if (!(std::abs(sample.y) < kRunawaySpeed)) sample.y = kNaN;
  if (!std::isfinite(sample.u)) sample.u = last_torque;
  last_torque = sample.u;
  last_time = sample.t;
  return at_the_arm(sample, usual_interval(), wiring, torques);
}

/// Keeps a sample of the beginning, which begins with motion; one that is too long cannot be looked
/// at again.
void Session::State::keep(const Sample& sample) {
  if (!keeps_beginning) return;
  std::visit(
      [&](const auto& r) {
        if (r.moment().at_rest && r.still() + 1 >= static_cast<int>(beginning.size()))
          beginning.clear();
      },
      runners.front());
  if (beginning.size() == kMostBeginning) {
    keeps_beginning = false;
    beginning.clear();
    return;
  }
  beginning.push_back(sample);
}

Estimate Session::State::step(const Sample& raw) {
  if (!std::isfinite(raw.t) || (last_time && session_time(raw.t) <= *last_time))
    return pass_over(raw);
  const Sample sample = usable(raw);
  keep(sample);
  Estimate estimate{};
  const AnyRunner* leader = nullptr;
  for (AnyRunner& runner : runners) {
    std::visit(
        [&](auto& r) {
          const RunnerStep step = r.step(sample);
          if (leader != nullptr && r.log_likelihood() <= log_likelihood(*leader)) return;
          leader = &runner;
          estimate = step.estimate(raw);
        },
        runner);
  }
  if (doubter) std::visit([&](auto& r) { r.step(sample); }, *doubter);
  report(*leader);
  as_measured(estimate);
  if (estimate.status == Status::kMissing && !std::isnan(raw.y))
    estimate.status = Status::kRejected;
  estimate.values = values;
  estimate.deviations = deviations;
  decide();
  return estimate;
}

/// What the sensor shows of what is predicted.
void Session::State::as_measured(Estimate& e) const {
  const double gain = 1.0 + wiring.sensor_gain;
  e.predicted = gain * e.predicted + wiring.sensor_bias;
  e.innovation *= gain;
  e.innovation_sd *= gain;
}

/// When the last sample came.
const Moment& Session::State::moment() const {
  return std::visit([](const auto& r) -> const Moment& { return r.moment(); }, runners.front());
}

/// The likeliest of those that still race.
const AnyRunner& Session::State::leader() const {
  return *std::ranges::max_element(runners, {}, log_likelihood);
}

template <class Visit>
void Session::State::visit_all(const Visit& visit) {
  for (AnyRunner& runner : runners) std::visit(visit, runner);
  if (doubter) std::visit(visit, *doubter);
}

/// Writes the leader's belief in physical terms. While start values are being left, what a state
/// has of the unknowns (each as if it were alone) is as much wider as they are.
void Session::State::report(const AnyRunner& leader) {
  std::visit(
      [&](const auto& runner) {
        const auto& engine = runner.engine();
        const auto& filter = engine.filter();
        const int own = static_cast<int>(model.states.size());
        for (int i = 0; i < own; ++i) {
          values[i] = filter.mean()[i];
          deviations[i] = filter.deviation(i);
        }
        engine.deviations(deviations.data() + own);
        const bool states_too = leaves_start();
        const int first = filter.shape().states();
        Widening widening;
        for (int k = 0; k < coordinates.size(); ++k) {
          values[own + k] = engine.parameters()[coordinates.unknowns()[k]];
          const double factor = unsettled(k, deviations[own + k]);
          if (states_too) widening.add(factor, filter.covariance(first + k, first + k));
          deviations[own + k] = std::hypot(factor * deviations[own + k], spread(leader, k));
        }
        for (int i = 0; i < own && states_too; ++i)
          deviations[i] = std::sqrt(widening.variance(
              filter.covariance(i, i), [&](int k) { return filter.covariance(i, first + k); }));
      },
      leader);
}

template <class Archive>
void Session::State::archive(Archive& archive) {
  std::uint64_t running = runners.size();
  archive(running);
  if constexpr (Archive::kLoads) {
    if (running == 0 || running > most_runners())
      throw InputError(fmt::format("has {} filters, where there are {}", running, most_runners()));
    runners.resize(running, runners.front());
  }
  for (AnyRunner& runner : runners) std::visit([&](auto& r) { archive(r); }, runner);
  bool doubts = doubter.has_value();
  archive(doubts);
  if constexpr (Archive::kLoads) doubter = doubts ? std::optional(runners.front()) : std::nullopt;
  if (doubter) std::visit([&](auto& r) { archive(r); }, *doubter);
  archive(beginning, keeps_beginning);
  if (beginning.size() > kMostBeginning)
    throw InputError("keeps a longer beginning than there may be");
  const std::size_t size = values.size();
  archive(raced, finalists, last_time, last_interval, clock_offset, new_clock, last_torque, values,
          deviations);
  if constexpr (Archive::kLoads)
    for (const std::size_t start : finalists)
      if (start >= starts_of(model, settings.race).size())
        throw InputError(fmt::format("has start {} among the best, which there is not", start));
  if (values.size() != size || deviations.size() != size)
    throw InputError("has another number of states and unknowns");
  for (Parameter& p : model.parameters)
    if (p.known) archive(p.value);
  archive(wiring, torques);
  if constexpr (Archive::kLoads) coordinates = FreeCoordinates(model);
}

Session::Session(const Model& model, const EstimatorSettings& settings)
    : state_(std::make_unique<State>(model, settings)) {}
Session::~Session() = default;
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;

Estimate Session::step(const Sample& sample) { return state_->step(sample); }

void Session::expect_new_clock() { state_->new_clock = true; }

std::string Session::save() const {
  OutArchive archive;
  archive(state_->described, *state_);
  return sealed(kSessionSeal, archive.bytes());
}

void Session::load(std::string_view bytes) {
  InArchive archive(unsealed(kSessionSeal, bytes));
  std::string described;
  archive(described);
  check_same(described, state_->described);
  auto loaded = std::make_unique<State>(state_->model, state_->settings);
  archive(*loaded);
  state_ = std::move(loaded);
}

bool Session::decided() const { return state_->raced; }

bool Session::is_settling() const { return state_->doubter || may_change_its_mind(); }

bool Session::may_change_its_mind() const {
  constexpr double kSettledS = 1.0;
  const double watched = state_->moment().watched;
  if (state_->settings.belief) return false;
  if (state_->runners.size() > 1) return true;
  if (watched >= kLookBackS + kSettledS) return false;
  return noise().known || (state_->keeps_beginning && watched < kLookBackS);
}

std::size_t Session::start() const { return state_->finalists.front(); }

Model Session::model() const {
  Model model = state_->model;
  const std::vector<int>& unknowns = state_->coordinates.unknowns();
  for (std::size_t k = 0; k < unknowns.size(); ++k)
    model.parameters[unknowns[k]].value = state_->values[model.states.size() + k];
  return model;
}

std::vector<double> Session::parameter_deviations() const {
  std::vector<double> sd(state_->model.parameters.size(), 0.0);
  const std::size_t states = state_->model.states.size();
  for (int k = 0; k < state_->coordinates.size(); ++k)
    sd[state_->coordinates.unknowns()[k]] = state_->deviations[states + k];
  return sd;
}

template <class Visit>
void Session::visit_leader(const Visit& visit) const {
  std::visit([&](const auto& runner) { visit(runner.engine()); }, state_->leader());
}

std::vector<double> Session::model_deviations() const {
  const FreeCoordinates& coordinates = state_->coordinates;
  std::vector<double> of_unknowns(coordinates.size());
  visit_leader([&](const auto& engine) { engine.model_deviations(of_unknowns.data()); });
  std::vector<double> sd(state_->model.parameters.size(), 0.0);
  for (int k = 0; k < coordinates.size(); ++k) sd[coordinates.unknowns()[k]] = of_unknowns[k];
  return sd;
}

SquareMatrix Session::parameter_covariance() const {
  SquareMatrix covariance(state_->coordinates.size());
  covariance_into(covariance);
  return covariance;
}

void Session::covariance_into(SquareMatrix& covariance) const {
  visit_leader([&](const auto& engine) {
    std::array<double, kMaxParameters> factor;
    for (int i = 0; i < covariance.size(); ++i) {
      const double sd = std::sqrt(engine.covariance(i, i));
      factor[i] = sd > 0.0 ? state_->deviations[state_->model.states.size() + i] / sd : 1.0;
    }
    for (int i = 0; i < covariance.size(); ++i)
      for (int j = 0; j <= i; ++j)  // the other half would differ by rounding
        covariance(i, j) = covariance(j, i) = factor[i] * factor[j] * engine.covariance(i, j);
  });
}

std::vector<std::string> Session::hardly_told() const {
  const std::vector<int>& unknowns = state_->coordinates.unknowns();
  std::vector<std::string> names;
  for (int k = 0; k < static_cast<int>(unknowns.size()); ++k)
    if (state_->is_hardly_told(state_->leader(), k))
      names.push_back(state_->model.parameters[unknowns[k]].name);
  return names;
}

ParameterBelief Session::belief() const {
  std::vector<double> values;
  ParameterBelief belief;
  remember(values, belief);
  return belief;
}

void Session::remember(std::vector<double>& values, ParameterBelief& belief) const {
  const FreeCoordinates& coordinates = state_->coordinates;
  if (static_cast<int>(belief.names.size()) != coordinates.size()) {
    belief.covariance = SquareMatrix(coordinates.size());
    belief.names.clear();
    for (const int i : coordinates.unknowns())
      belief.names.push_back(state_->model.parameters[i].name);
  }
  covariance_into(belief.covariance);
  belief.noise = noise();
  values.clear();
  for (const Parameter& p : state_->model.parameters) values.push_back(p.value);
  for (int k = 0; k < coordinates.size(); ++k)
    values[coordinates.unknowns()[k]] = state_->values[state_->model.states.size() + k];
}

void Session::believe(const std::vector<double>& values, const ParameterBelief& belief,
                      const Condition& condition) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (Parameter& p = state_->model.parameters[i]; p.known) p.value = values[i];
  state_->coordinates.take_known(values);
  state_->wiring = condition;
  state_->visit_all([&](auto& r) {
    r.engine().believe_parameters(values);
    r.engine().believe(belief);
  });
}

void Session::begin_noise_anew() {
  state_->visit_all([](auto& r) { r.engine().begin_noise_anew(); });
}

const Condition& Session::condition() const { return state_->wiring; }

LearntNoise Session::noise() const {
  LearntNoise found;
  visit_leader([&](const auto& engine) {
    found.sought = engine.has_sought();
    found.known = engine.has_learnt();
    found.sample_s = engine.usual_dt();
    found.not_noise = engine.not_noise();
    if (!found.known) return;
    const ColouredNoise torque = engine.torque_noise();
    const ColouredNoise& sensor = engine.noise().sensor;
    found.torque_sd = torque.sd;
    found.torque_pole = torque.pole;
    found.sensor_sd = sensor.sd;
    found.sensor_pole = sensor.pole;
  });
  return found;
}

}  // namespace armukf
