#include "armukf/online/session.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "armukf/core/archive.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/error.hpp"
#include "armukf/model/plant.hpp"
#include "armukf/online/contender.hpp"
#include "armukf/online/description.hpp"
#include "armukf/online/held_shapes.hpp"
#include "armukf/online/race.hpp"
#include "armukf/online/seals.hpp"
#include "armukf/online/widening.hpp"

namespace armukf {
namespace {

/// s; what is taken to lie between two clocks, at least: a gap by any measure.
constexpr double kLeastPause = 10.0;
constexpr double kPauseInIntervals = 100.0;

double log_likelihood(const std::unique_ptr<Contender>& contender) {
  return contender->log_likelihood();
}

/// What a contender believes of the unknown parameters: all parameters of the model, and of the
/// unknown ones the deviations.
struct BelievedParameters {
  std::array<double, kMaxParameters> values;
  std::array<double, kMaxParameters> deviations;
};

BelievedParameters parameters_of(const Contender& contender) {
  BelievedParameters believed{};
  std::copy_n(contender.parameters(), kMaxParameters, believed.values.begin());
  contender.deviations(believed.deviations.data());
  return believed;
}

}  // namespace

std::string_view name_of(Status status) {
  constexpr std::array<std::string_view, 5> kNames{"ok", "missing", "rejected", "gap", "reset"};
  return kNames[static_cast<int>(status)];
}

/// Samples that are kept for a second look: 4 s at 2 kHz.
constexpr std::size_t kMostBeginning = 8192;
/// s, watched, before the second look, unless so many samples come sooner: the longer it is, the
/// more of what a start far off has spoilt is learnt anew; beyond that the first look has learnt
/// too much to be thrown away.
constexpr double kLookBackS = 3.0;

/// Those of the race that look again.
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
  void report(const Contender& leader);
  bool leaves_start() const;
  double unsettled(int k, double sd) const;
  double spread(const Contender& leader, int k) const;
  void decide();
  void end_race();
  void look_back();
  void give_up_rivals(double watched);
  bool agree(const BelievedParameters& a, const BelievedParameters& b) const;
  bool is_hardly_told(const Contender& contender, int k) const;
  bool is_told_anything(const Contender& contender) const;
  void leave(std::size_t count);
  std::size_t most_contenders() const;
  void keep(const Sample& sample);
  const Contender& leader() const;
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
  std::vector<std::unique_ptr<Contender>> contenders;  // at least one
  std::unique_ptr<Contender> doubter;  // if any: of the noise that was learnt; never leads
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
  std::vector<int> held;
  if (settings.belief) held = held_shapes(model, *settings.belief);
  for (const Start& start : starts_of(model, settings.race)) {
    contenders.push_back(make_contender(model, coordinates, settings));
    contenders.back()->begin(start);
    if (settings.belief) contenders.back()->go_on_from(*settings.belief, held);
  }
  raced = contenders.size() == 1;
  if (learns_noise(settings) && !settings.belief) {
    beginning.reserve(kMostBeginning);
    keeps_beginning = true;
  }
  values.resize(model.states.size() + coordinates.size());
  deviations.resize(values.size());
  const Contender& first = *contenders.front();
  for (int k = 0; k < coordinates.size(); ++k) first_variances.push_back(first.free_variance(k));
  first_deviations.resize(coordinates.size());
  first.deviations(first_deviations.data());
  report(first);
}

/// How many there may be at a time.
std::size_t Session::State::most_contenders() const {
  return std::max(starts_of(model, settings.race).size(),
                  kFinalists + settings.race.starts.size() - 1);
}

/// Of the contenders the first ones.
void Session::State::leave(std::size_t count) {
  contenders.erase(contenders.begin() + static_cast<std::ptrdiff_t>(count), contenders.end());
}

/// Ends the race once its time is over: the likeliest contender goes on, and later looks at the
/// beginning again, beside rivals until these are given up.
void Session::State::decide() {
  const double watched = moment().watched;
  if (watched < settings.race.duration_s) return;
  if (!raced) end_race();
  if (watched >= kLookBackS || beginning.size() == kMostBeginning) look_back();
  if ((contenders.size() > 1 || doubter) && !keeps_beginning) give_up_rivals(watched);
}

/// Leaves the likeliest of all, and the next one where it may look again.
void Session::State::end_race() {
  const std::size_t count = keeps_beginning ? kFinalists : 1;
  std::vector<std::size_t> start(contenders.size());
  std::iota(start.begin(), start.end(), std::size_t{0});
  for (std::size_t i = 0; i < count; ++i) {
    const auto rest = std::span(contenders).subspan(i);
    const auto best = std::ranges::max_element(rest, {}, log_likelihood);
    const std::size_t at = i + static_cast<std::size_t>(best - rest.begin());
    std::swap(contenders[i], contenders[at]);
    std::swap(start[i], start[at]);
    finalists[i] = start[i];
  }
  leave(count);
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
  if (!contenders.front()->noise().known) {
    leave(1);
    return;
  }
  const std::vector<std::unique_ptr<Contender>> raced_so_far = std::exchange(contenders, {});
  const Contender& first = *raced_so_far.front();
  const std::vector<Start> starts = starts_of(model, settings.race);
  const auto with_parameters_of = [&](const Contender& contender) {
    Model found = model;
    const BelievedParameters believed = parameters_of(contender);
    for (std::size_t i = 0; i < found.parameters.size(); ++i)
      found.parameters[i].value = believed.values[i];
    return found;
  };
  const auto look = [&](const std::vector<double>& from, std::size_t finalist, double part = 1.0) {
    return first.second_look({from, starts[finalists[finalist]].places}, beginning, part);
  };
  for (std::size_t i = 0; i < raced_so_far.size(); ++i)
    contenders.push_back(look(with_parameters_of(*raced_so_far[i]).values(), i));
  for (const StartFactors& factors : settings.race.starts)
    if (!factors.empty())
      contenders.push_back(look(start_values(with_parameters_of(first), factors), 0));
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
bool Session::State::is_hardly_told(const Contender& contender, int k) const {
  constexpr double kLeft = 0.7;  // of the deviation: half of the variance
  if (!(contender.free_variance(k) > kLeft * kLeft * first_variances[k])) return false;
  if (model.parameters[coordinates.unknowns()[k]].upper == kUnbounded) return true;
  std::array<double, kMaxParameters> sd;
  contender.deviations(sd.data());
  return sd[k] > kLeft * first_deviations[k];
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
double Session::State::spread(const Contender& leader, int k) const {
  if (!raced || keeps_beginning || (contenders.size() == 1 && !doubter)) return 0.0;
  const auto value = [&](const Contender& c) { return c.parameters()[coordinates.unknowns()[k]]; };
  const double its = value(leader);
  const auto weight = [&](const Contender& contender) {
    const double behind = leader.log_likelihood() - contender.log_likelihood();
    return std::exp(-std::max(0.0, behind) / kLessLikely);
  };
  const auto apart = [&](const Contender& contender) {
    const double difference = value(contender) - its;
    return weight(contender) * difference * difference;
  };
  double sum = 0.0;
  double weights = 0.0;
  for (const auto& contender : contenders) {
    sum += apart(*contender);
    weights += weight(*contender);
  }
  return std::sqrt(sum / weights + (doubter ? apart(*doubter) : 0.0));
}

bool Session::State::is_told_anything(const Contender& contender) const {
  for (int k = 0; k < coordinates.size(); ++k)
    if (!is_hardly_told(contender, k)) return true;
  return false;
}

/// The likeliest leads. Rivals that are much less likely or have come to the same arm are given up,
/// and all of them where the samples tell of no unknown which arm it is.
void Session::State::give_up_rivals(double watched) {
  std::iter_swap(contenders.begin(), std::ranges::max_element(contenders, {}, log_likelihood));
  const Contender& leader = *contenders.front();
  const bool over = watched > kRivalsS || !is_told_anything(leader);
  const double least = leader.log_likelihood() - kLessLikely;
  const BelievedParameters arm = parameters_of(leader);
  const auto hopeless = [&](const std::unique_ptr<Contender>& rival) {
    return over || rival->log_likelihood() < least || agree(arm, parameters_of(*rival));
  };
  contenders.erase(std::remove_if(contenders.begin() + 1, contenders.end(), hopeless),
                   contenders.end());
  if (doubter && hopeless(doubter)) doubter.reset();
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
  if (moment().at_rest && contenders.front()->still() + 1 >= static_cast<int>(beginning.size()))
    beginning.clear();
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
  const Contender* leader = nullptr;
  for (const auto& contender : contenders) {
    const Estimate its = contender->step(sample);
    if (leader != nullptr && contender->log_likelihood() <= leader->log_likelihood()) continue;
    leader = contender.get();
    estimate = its;
  }
  estimate.sample = raw;
  if (doubter) doubter->step(sample);
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
const Moment& Session::State::moment() const { return contenders.front()->moment(); }

/// The likeliest of those that still race.
const Contender& Session::State::leader() const {
  return **std::ranges::max_element(contenders, {}, log_likelihood);
}

template <class Visit>
void Session::State::visit_all(const Visit& visit) {
  for (const auto& contender : contenders) visit(*contender);
  if (doubter) visit(*doubter);
}

/// Writes the leader's belief in physical terms. While start values are being left, what a state
/// has of the unknowns (each as if it were alone) is as much wider as they are.
void Session::State::report(const Contender& leader) {
  const std::size_t own = model.states.size();
  const std::span<double> sd = std::span(deviations).first(own);
  leader.states(std::span(values).first(own), sd);
  leader.deviations(deviations.data() + own);
  const bool states_too = leaves_start();
  const int first = leader.first_unknown();
  Widening widening;
  for (int k = 0; k < coordinates.size(); ++k) {
    const std::size_t at = own + static_cast<std::size_t>(k);
    values[at] = leader.parameters()[coordinates.unknowns()[k]];
    const double factor = unsettled(k, deviations[at]);
    if (states_too) widening.add(factor, leader.covariance_of_rows(first + k, first + k));
    deviations[at] = std::hypot(factor * deviations[at], spread(leader, k));
  }
  for (int i = 0; i < static_cast<int>(own) && states_too; ++i)
    sd[i] = std::sqrt(widening.variance(leader.covariance_of_rows(i, i), [&](int k) {
      return leader.covariance_of_rows(i, first + k);
    }));
}

template <class Archive>
void Session::State::archive(Archive& archive) {
  std::uint64_t running = contenders.size();
  archive(running);
  if constexpr (Archive::kLoads) {
    if (running == 0 || running > most_contenders())
      throw InputError(
          fmt::format("has {} filters, where there are {}", running, most_contenders()));
    leave(std::min<std::size_t>(running, contenders.size()));
    while (contenders.size() < running) contenders.push_back(contenders.front()->anew());
  }
  for (const auto& contender : contenders) contender->archive(archive);
  bool doubts = doubter != nullptr;
  archive(doubts);
  if constexpr (Archive::kLoads) doubter = doubts ? contenders.front()->anew() : nullptr;
  if (doubter) doubter->archive(archive);
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
  if (state_->contenders.size() > 1) return true;
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

std::vector<double> Session::model_deviations() const {
  const FreeCoordinates& coordinates = state_->coordinates;
  std::vector<double> of_unknowns(coordinates.size());
  state_->leader().model_deviations(of_unknowns.data());
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
  const Contender& leader = state_->leader();
  std::array<double, kMaxParameters> factor;
  for (int i = 0; i < covariance.size(); ++i) {
    const double sd = std::sqrt(leader.covariance(i, i));
    factor[i] = sd > 0.0 ? state_->deviations[state_->model.states.size() + i] / sd : 1.0;
  }
  for (int i = 0; i < covariance.size(); ++i)
    for (int j = 0; j <= i; ++j)  // the other half would differ by rounding
      covariance(i, j) = covariance(j, i) = factor[i] * factor[j] * leader.covariance(i, j);
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
  state_->visit_all([&](Contender& c) { c.believe(values, belief); });
}

void Session::begin_noise_anew() {
  state_->visit_all([](Contender& c) { c.begin_noise_anew(); });
}

const Condition& Session::condition() const { return state_->wiring; }

LearntNoise Session::noise() const { return state_->leader().noise(); }

}  // namespace armukf
