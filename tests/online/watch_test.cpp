#include "armukf/online/watch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "armukf/batch/experiment.hpp"
#include "armukf/batch/speed_reference.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/error.hpp"
#include "armukf/model/dynamics.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagate.hpp"
#include "armukf/online/change_ring.hpp"
#include "armukf/online/change_test.hpp"

namespace armukf {
namespace {

constexpr double kDt = 5e-4;     // s
constexpr double kOnset = 15.0;  // s
constexpr double kGearRatio = 10.0;

/// x_{k+1} = pole x_k + white noise, of standard deviation sd.
class Coloured {
 public:
  Coloured(double sd, double pole, unsigned seed) : sd_(sd), pole_(pole), random_(seed) {}
  double next() {
    return value_ = pole_ * value_ + std::sqrt(1.0 - pole_ * pole_) * sd_ * normal_(random_);
  }

 private:
  double sd_;
  double pole_;
  double value_ = 0.0;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

/// What is commanded (N.m) at the n-th sample, which measures y (rad/s).
using Command = std::function<double(int n, double y)>;

/// Follows the speed of the published motion.
Command speed_control() {
  return [wanted = speed_reference(ExperimentKind::kEstimation, {}, 20000, kDt, 1), integral = 0.0](
             int n, double y) mutable {
    const double error = wanted[static_cast<std::size_t>(n) % wanted.size()] - y;
    const double u = 4.0 * error + integral;
    integral += 40.0 * kDt * error;
    return u;
  };
}

/// Sweeps from 0.8 to 45 Hz every 5 s, and hardly holds the arm. What a resonance tells is learnt
/// all at once as the sweep passes it.
Command torque_chirp() {
  return [](int n, double y) {
    constexpr double kEvery = 5.0;  // s
    constexpr double kFirst = 0.8;  // Hz
    const double growth = std::log(45.0 / kFirst);
    const double part = std::fmod(n * kDt, kEvery) / kEvery;
    const double turns = kFirst * kEvery / growth * (std::exp(growth * part) - 1.0);
    return 7.0 * std::sin(2.0 * std::numbers::pi * turns) - 0.05 * y;
  };
}

/// A record of the published arm, which from kOnset on is another, and gets another torque than it
/// is told; with coloured noise of torque and sensor. `weight` (N.m): of gravity at the motor, all
/// the while.
std::vector<Sample> record(double duration, const Model& later, double bias = 0.0,
                           double weight = 0.0, Command command = speed_control(),
                           unsigned seed = 1) {
  const int samples = static_cast<int>(duration / kDt);
  Coloured sensor(0.1, 0.5, seed);
  Coloured torque(0.05, 0.9, seed + 1);
  const Model before = published_estimate();
  std::vector<double> p = before.values();
  std::vector<double> x(kArmStates, 0.0);
  double angle = 0.0;
  std::vector<Sample> all;
  for (int n = 0; n < samples; ++n) {
    const double t = n * kDt;
    if (t >= kOnset) p = later.values();
    const double y = x[kSpeedMotor] + sensor.next();
    const double u = command(n, y);
    all.push_back({t, u, y});
    angle += kDt * x[kSpeedMotor];
    const double given =
        u + torque.next() + (t >= kOnset ? bias : 0.0) - weight * std::sin(angle / kGearRatio);
    const Coefficients<double> c(p.data());
    std::array<double, kArmStates> state;
    std::copy(x.begin(), x.end(), state.begin());
    const auto f = [&](const auto& at, auto& dx, double) {
      derivative(c, at.data(), given, dx.data());
    };
    propagate({}, f, state, t, kDt);
    x.assign(state.begin(), state.end());
  }
  return all;
}

std::vector<Event> events_of(const std::vector<Sample>& samples,
                             const EstimatorSettings& settings = {}) {
  Session session(published_arm(), settings);
  Watch watch(published_arm(), settings);
  std::vector<Event> all;
  for (const Sample& sample : samples) {
    const Estimate estimate = session.step(sample);
    for (const Event& event : watch.see(session, sample, estimate)) all.push_back(event);
  }
  return all;
}

Model with(const char* parameter, double factor) {
  Model model = published_estimate();
  model.parameter(parameter).value *= factor;
  return model;
}

/// One change, said twice: its name, onset and size.
void expect_found(const std::vector<Event>& events, const char* what, double to) {
  ASSERT_EQ(events.size(), 2U);
  EXPECT_FALSE(events[0].settled);
  EXPECT_TRUE(events[1].settled);
  for (const Event& event : events) {
    EXPECT_EQ(event.what, what);
    EXPECT_NEAR(event.onset, kOnset, 0.3);
    EXPECT_LT(event.t, kOnset + 3.0);
  }
  EXPECT_NEAR(events[1].to, to, 4.0 * events[1].sd + 0.02 * std::abs(to));
}

TEST(Watch, SaysNothingWhereNothingChanges) {
  EXPECT_TRUE(events_of(record(30.0, published_estimate())).empty());
}

/// The parameters move far from those that the predictors were frozen at, whose states and
/// signatures are bent by that: it is no change of the machine.
TEST(Watch, SaysNothingWhereParametersAreLearntLate) {
  for (const unsigned seed : {3U, 4U}) {
    const std::vector<Event> events =
        events_of(record(12.0, published_estimate(), 0.0, 0.0, torque_chirp(), seed));
    EXPECT_TRUE(events.empty()) << "seed " << seed << ": " << events[0].what << " at "
                                << events[0].onset << " s, said at " << events[0].t << " s";
  }
}

/// What arithmetic leaves of a simulated record that has no noise is no change.
TEST(Watch, SaysNothingOfARecordWithoutNoise) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    ExperimentSettings experiment;
    experiment.seed = seed;
    const Record record = simulate_experiment(published_estimate(), experiment).record;
    EXPECT_TRUE(events_of(record.samples).empty()) << "seed " << seed;
  }
}

TEST(Watch, FindsAGearThatWears) {
  expect_found(events_of(record(19.0, with("k_g1", 0.8))), "k_g1",
               0.8 * published_estimate().parameter("k_g1").value);
}

TEST(Watch, FindsAnArmThatStiffens) {
  expect_found(events_of(record(19.0, with("k_a", 1.2))), "k_a",
               1.2 * published_estimate().parameter("k_a").value);
}

/// By the first samples of so large a change it may be anything: what explains hardly any of them
/// is not the last word.
TEST(Watch, NamesAPayloadAsHeavyAsTheArm) {
  Model plant = published_estimate();
  plant.add_effect("payload_change");
  plant.parameter("payload").value = 1.0;
  plant.parameter("payload_time").value = 6.0;
  for (const std::uint64_t seed : {61, 75, 80}) {
    const Record record =
        simulate_experiment(
            plant,
            {.seed = seed, .samples = 18000, .sensor_noise = 0.1, .torque_disturbance = 0.05})
            .record;
    const std::vector<Event> events = events_of(record.samples);
    ASSERT_EQ(events.size(), 2U) << seed;
    for (const Event& event : events) EXPECT_EQ(event.what, "payload_change") << seed;
    EXPECT_NEAR(events[1].to, 1.0, 0.05) << seed;
  }
}

TEST(Watch, FindsATorqueThatNobodyCommands) {
  expect_found(events_of(record(19.0, published_estimate(), 0.08)), "torque_bias", 0.08);
}

/// The seconds before it begins are looked at too: what the arm was like is known from them.
TEST(Watch, FindsWhatChangesRightAfterItBegins) {
  constexpr double kSoon = 4.6;   // s
  constexpr double kGiven = 0.8;  // of the torque that is commanded
  ExperimentSettings experiment;
  experiment.samples = 14000;
  experiment.sensor_noise = 0.1;
  experiment.torque_disturbance = 0.1;
  Record early = simulate_experiment(published_estimate(), experiment).record;
  for (Sample& sample : early.samples)
    if (sample.t >= kSoon) sample.u /= kGiven;
  const std::vector<Event> events = events_of(early.samples);
  ASSERT_EQ(events.size(), 2U);
  EXPECT_LT(events[0].t, kSoon + 0.5);
  for (const Event& event : events) {
    EXPECT_EQ(event.what, "torque_gain");
    EXPECT_NEAR(event.onset, kSoon, 0.01);
    EXPECT_NEAR(event.to, kGiven - 1.0, 0.01);
  }
}

TEST(Watch, KeepsWhatHasNotChanged) {
  const EstimatorSettings settings;
  Session session(published_arm(), settings);
  Watch watch(published_arm(), settings);
  for (const Sample& sample : record(19.0, with("k_g1", 0.8)))
    watch.see(session, sample, session.step(sample));
  const Model truth = with("k_g1", 0.8);
  const Model found = session.model();
  const std::vector<double> sd = session.parameter_deviations();
  for (const int i : found.unknowns())
    EXPECT_NEAR(found.parameters[i].value, truth.parameters[i].value, 3.5 * sd[i])
        << found.parameters[i].name;
}

/// What was not learnt as noise may be what the model lacks, of which some is now and then large.
TEST(Watch, TakesAJoltForNoChangeOfAModelThatLacksSomething) {
  constexpr double kJoltS = 0.03;
  std::vector<Sample> samples = record(18.0, published_estimate());
  for (Sample& s : samples)
    if (const double since = s.t - kOnset; since >= 0.0 && since < kJoltS)
      s.y += std::sin(std::numbers::pi * since / kJoltS);  // rad/s, ten times the sensor's noise
  EstimatorSettings settings;
  settings.noise.learning.most_torque = 0.0;
  EXPECT_EQ(events_of(samples, settings).size(), 0U);
}

/// Gravity that the model lacks is small and slow enough to be taken for noise and for changes of
/// offset and friction, one upon the other.
TEST(Watch, DoubtsAModelOfWhichItSeesChangeUponChange) {
  const EstimatorSettings settings;
  Session session(published_arm(), settings);
  Watch watch(published_arm(), settings);
  for (const Sample& sample : record(40.0, published_estimate(), 0.0, 0.2))
    watch.see(session, sample, session.step(sample));
  EXPECT_TRUE(session.noise().known);
  EXPECT_TRUE(watch.doubts_model());
  EXPECT_LE(watch.count(), 5U);
}

/// All that a watched session says from one sample on, events and numbers.
std::vector<double> said(Session& session, Watch& watch, std::span<const Sample> samples) {
  std::vector<double> all;
  for (const Sample& sample : samples) {
    const Estimate estimate = session.step(sample);
    all.insert(all.end(), estimate.values.begin(), estimate.values.end());
    for (const Event& e : watch.see(session, sample, estimate))
      all.insert(all.end(), {e.t, e.onset, e.from, e.to, e.sd, e.p});
  }
  return all;
}

/// Before it begins, in quiet, while changes are tried, before the value has settled, and after.
TEST(Watch, GoesOnFromACheckpointToTheLastBit) {
  const std::vector<Sample> samples = record(18.0, with("k_g1", 0.8), 0.0);
  const EstimatorSettings settings;
  Session session(published_arm(), settings);
  Watch watch(published_arm(), settings);
  std::size_t done = 0;
  for (const double t : {1.0, 5.0, 15.1, 15.4, 15.6, 17.5}) {
    const auto at = static_cast<std::size_t>(t / kDt);
    said(session, watch, std::span(samples).subspan(done, at - done));
    done = at;
    const std::string bytes = watch.save();
    Session other(published_arm(), settings);
    other.load(session.save());
    Watch again(published_arm(), settings);
    again.load(bytes);
    EXPECT_TRUE(again.save() == bytes) << t;
    Session whole(published_arm(), settings);
    whole.load(session.save());
    Watch same(published_arm(), settings);
    same.load(bytes);
    const std::span<const Sample> next = std::span(samples).subspan(done, 300);
    const std::vector<double> ahead = said(other, again, next);
    EXPECT_TRUE(said(whole, same, next) == ahead) << t;
    said(session, watch, next);
    done += next.size();
    EXPECT_TRUE(watch.save() == again.save()) << t;
    EXPECT_TRUE(session.save() == other.save()) << t;
  }
  EXPECT_EQ(watch.count(), 1U);
}

TEST(Watch, RefusesAnotherCheckpoint) {
  const EstimatorSettings settings;
  Session session(published_arm(), settings);
  Watch watch(published_arm(), settings);
  said(session, watch, record(4.0, published_estimate()));
  const std::string bytes = watch.save();
  for (std::size_t size = 0; size < bytes.size(); size += 9973)
    EXPECT_THROW(watch.load(bytes.substr(0, size)), InputError) << size;
  EXPECT_THROW(watch.load(bytes + "x"), InputError);
  EXPECT_TRUE(watch.save() == bytes);
}

TEST(Watch, TellsTimesByTheSamplesClock) {
  for (const Event& event : events_of(record(18.0, with("k_g1", 0.8)))) {
    EXPECT_EQ(event.t, std::round(event.t / kDt) * kDt);
    EXPECT_EQ(event.onset, std::round(event.onset * 1e6) / 1e6);
  }
}

TEST(Watch, SaysWhatItCannotSeeAtRest) {
  const EstimatorSettings settings;
  Session session(published_arm(), settings);
  Watch watch(published_arm(), settings);
  Coloured sensor(0.1, 0.5, 3);
  for (int n = 0; n < 20000; ++n) {
    const Sample sample{n * kDt, 0.0, sensor.next()};
    EXPECT_TRUE(watch.see(session, sample, session.step(sample)).empty());
  }
  const std::vector<std::string> unseen = watch.unseen();
  EXPECT_NE(std::ranges::find(unseen, "k_a"), unseen.end());
}

TEST(ChangeRing, KeepsAllThereWasInConstantMemory) {
  ChangeRing ring(2);
  double total = 0.0;
  int most = 0;
  for (int n = 0; n < 200000; ++n) {
    Surprise surprise{.value = 1.0};
    surprise.signature[0] = 1.0;
    ring.add(surprise, n * kDt);
    if (ring.full() && ring.close()) ring.take_left(1.0);
    most = std::max(most, ring.size());
  }
  total += ring.past().samples;
  for (int i = 0; i < ring.size(); ++i) {
    total += ring.step(i).samples;
    if (i > 0) {
      EXPECT_GE(ring.step(i).begin, ring.step(i - 1).end);
    }
  }
  EXPECT_LE(most, ChangeRing::kLevels * ChangeRing::kPerLevel + 1);
  EXPECT_NEAR(total, 200000.0, 2.0 * ChangeRing::kStepS / kDt);  // the open step is not in
}

/// Of white innovations each statistic at one onset is chi-square of one degree of freedom.
TEST(ChangeTest, HasTheStatisticOfWhiteInnovations) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const std::vector<Changeable> what(2, {nullptr, 0, "", "", 1.0, 1.0, 1.0});
  constexpr int kTrials = 300;
  double sum = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    ChangeRing ring(2);
    ChangeTest test(2);
    test.believe(what);
    int n = 0;
    for (int step = 0; step < 2; ++step) {
      for (; !ring.full(); ++n) {
        Surprise surprise{.value = normal(random)};
        for (int i = 0; i < 2; ++i) surprise.signature[i] = normal(random);
        ring.add(surprise, n * kDt);
      }
      ring.close();
    }
    test.look(ring, 0.0, 10.0);
    sum += test.findings()[0].statistic;
  }
  // The larger of two onsets, of which the earlier one is all there is and says little: between one
  // and two degrees of freedom; the mean of 300 has a deviation of 0.1.
  EXPECT_GT(sum / kTrials, 0.6);
  EXPECT_LT(sum / kTrials, 2.0);
}

/// Scores of one signature and of such innovations before `kOnset`, and what follows it.
double spread_before_onset(const std::function<double(int n)>& innovation) {
  constexpr double kBeforeS = 4.0;
  const std::vector<Changeable> what(1, {nullptr, 0, "", "", 1.0, 1.0, 1.0});
  ChangeRing ring(1);
  ChangeTest test(1);
  test.believe(what);
  for (int n = 0; n * kDt < kBeforeS + 1.0; ++n) {
    Surprise surprise{.value = n * kDt < kBeforeS ? innovation(n) : 100.0};
    surprise.signature[0] = 1.0;
    ring.add(surprise, n * kDt);
    if (ring.full()) ring.close();
  }
  test.look(ring, 0.0, 10.0);
  return test.spread_before(kBeforeS, 0, ring);
}

/// White innovations have none; those that are alike for a fifth of a second look like changes by
/// chance far more often. What has changed since does not count.
TEST(ChangeTest, TellsHowFarScoresVaryBeforeAnOnset) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  double sum = 0.0;
  constexpr int kTrials = 50;
  for (int trial = 0; trial < kTrials; ++trial)
    sum += spread_before_onset([&](int) { return normal(random); });
  EXPECT_LT(sum / kTrials, 1.3);
  double alike = 0.0;
  EXPECT_GT(spread_before_onset([&](int n) {
              if (n % 400 == 0) alike = normal(random);
              return alike;
            }),
            20.0);
}

/// A drift that starts at 0 and the step that comes half a second after it are nearly alike; the
/// step of one usual size is taken for one, since no such drift is expected.
TEST(ChangeTest, TakesWhatComesAtOnceForNoDrift) {
  const std::vector<Changeable> what(1, {nullptr, 0, "", "", 1.0, 1.0, 1.0});
  ChangeRing ring(1);
  ChangeTest test(1);
  test.believe(what);
  constexpr double kStepAt = 0.5;  // s
  for (int n = 0; n * kDt < 1.0; ++n) {
    Surprise surprise{.value = n * kDt > kStepAt ? 0.3 : 0.0};
    surprise.signature[0] = 0.3;
    ring.add(surprise, n * kDt);
    if (ring.full()) ring.close();
  }
  constexpr double kAny = 1e-3;  // s, for a usual size: as good as no prior
  test.look(ring, 0.0, kAny);
  EXPECT_GT(test.drift_statistic(0), 0.5 * test.findings()[0].statistic);
  test.look(ring, 0.0, 10.0);
  EXPECT_LT(test.drift_statistic(0), 0.3 * test.findings()[0].statistic);
}

}  // namespace
}  // namespace armukf
