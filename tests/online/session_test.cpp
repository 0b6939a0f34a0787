#include "armukf/online/session.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "armukf/batch/experiment.hpp"
#include "armukf/core/error.hpp"
#include "armukf/online/condition.hpp"
#include "armukf/online/recursion.hpp"
#include "armukf/online/tally.hpp"

namespace armukf {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<Sample> record(int samples) {
  return simulate_experiment(published_estimate(), {.samples = samples, .sensor_noise = 0.05})
      .record.samples;
}

EstimatorSettings settings_of(std::string_view filter) {
  EstimatorSettings settings;
  settings.filter = filter;
  return settings;
}

/// What is believed, kept beyond the next step.
struct Belief {
  std::vector<double> values;
  std::vector<double> deviations;
  Status status = Status::kOk;
};

Belief step(Session& session, const Sample& sample) {
  const Estimate e = session.step(sample);
  return {{e.values.begin(), e.values.end()}, {e.deviations.begin(), e.deviations.end()}, e.status};
}

Belief run(Session& session, const std::vector<Sample>& samples) {
  Belief last;
  for (const Sample& sample : samples) last = step(session, sample);
  return last;
}

class Filter : public ::testing::TestWithParam<std::string> {
 protected:
  EstimatorSettings settings_ = settings_of(GetParam());
  Session session_{published_arm(), settings_};
  std::vector<Sample> samples_ = record(400);
};

TEST_P(Filter, RepeatsItselfToTheLastBit) {
  Session other(published_arm(), settings_);
  EXPECT_EQ(run(session_, samples_).values, run(other, samples_).values);
}

TEST_P(Filter, MissingMeasurementOnlyCarriesTheBeliefForward) {
  const Belief before = run(session_, samples_);
  Sample next = samples_.back();
  next.t += 5e-4;
  next.y = kNaN;
  const Belief after = step(session_, next);
  EXPECT_EQ(after.status, Status::kMissing);
  EXPECT_GT(after.deviations[kSpeedMotor], before.deviations[kSpeedMotor]);
  EXPECT_TRUE(std::ranges::equal(after.values.begin() + 5, after.values.end(),
                                 before.values.begin() + 5, before.values.end()));
}

TEST_P(Filter, SpikeIsRejectedAndForgotten) {
  Session clean(published_arm(), settings_);
  std::vector<Sample> spiked = samples_;
  spiked[200].y += 1000.0;
  Belief at_spike;
  for (int k = 0; k <= 200; ++k) at_spike = step(session_, spiked[k]);
  EXPECT_EQ(at_spike.status, Status::kRejected);
  for (int k = 201; k < 400; ++k) at_spike = step(session_, spiked[k]);
  const Belief undisturbed = run(clean, samples_);
  for (std::size_t i = 0; i < undisturbed.values.size(); ++i)
    EXPECT_NEAR(at_spike.values[i], undisturbed.values[i], 0.5 * undisturbed.deviations[i]) << i;
}

TEST_P(Filter, RestartsItsStatesAfterALongGapAndKeepsTheParameters) {
  const Belief before = run(session_, samples_);
  Sample next = samples_.back();
  next.t += 1.0;
  const Belief after = step(session_, next);
  EXPECT_EQ(after.status, Status::kGap);
  EXPECT_NEAR(after.deviations[kTwistArm], settings_.prior.twist, 0.01);
  for (std::size_t i = 5; i < after.values.size(); ++i)
    EXPECT_NEAR(after.values[i], before.values[i], 1e-9 * std::abs(before.values[i])) << i;
}

TEST_P(Filter, RestartsAfterALongRunOfRejections) {
  run(session_, samples_);
  Sample next = samples_.back();
  next.y += 500.0;
  int resets = 0;
  for (int k = 0; k < settings_.gate.patience; ++k) {
    next.t += 5e-4;
    resets += step(session_, next).status == Status::kReset;
  }
  EXPECT_EQ(resets, 1);
  next.t += 5e-4;
  EXPECT_NEAR(step(session_, next).values[kSpeedMotor], next.y, 50.0);
}

/// Torque in mN.m and speed in rpm: there is no such arm, and whatever the filter makes of it, it
/// has not learnt its parameters.
TEST_P(Filter, BelievesNoMoreForHavingFailed) {
  for (Sample& sample : samples_) {
    sample.u *= 1000.0;
    sample.y *= 9.5493;
  }
  const std::vector<double> before = session_.parameter_deviations();
  std::size_t resets = 0;
  for (int turn = 0; turn < 3; ++turn)
    for (Sample sample : samples_) {
      sample.t += 0.2 * turn;
      resets += session_.step(sample).status == Status::kReset ? 1 : 0;
    }
  const std::vector<double> after = session_.parameter_deviations();
  const std::vector<Parameter>& parameters = session_.model().parameters;
  if (resets <= 8) return;  // a filter that gets along with it
  for (const char* name : {"a_m", "a_g", "k_g1", "k_a"}) {
    const int i = session_.model().index_of(name);
    EXPECT_GT(after[i] / parameters[i].value,
              0.15 * before[i] / published_arm().parameters[i].value)
        << name;
  }
}

TEST_P(Filter, IntervalCutInTwoTellsTheSame) {
  // Half-way samples without a measurement, the torque held. With a belief so narrow that the arm
  // is nearly linear within it, only the integrator's own error remains.
  std::vector<Sample> halved;
  for (const Sample& sample : samples_) {
    halved.push_back(sample);
    halved.push_back({sample.t + 2.5e-4, sample.u, kNaN});
  }
  halved.pop_back();
  Model sure = published_estimate();
  for (Parameter& p : sure.parameters) p.spread = 0.01;
  settings_.prior = {.twist = 0.01, .speed = 0.1};
  settings_.race.starts = {{}};
  settings_.noise.parameter_walk = {};
  settings_.adaptation = {.time_s = 1e6, .settle_s = 0.3};  // learning would amplify that error
  Session once(sure, settings_);
  Session twice(sure, settings_);
  const Belief whole = run(once, samples_);
  const Belief cut = run(twice, halved);
  for (std::size_t i = 0; i < whole.values.size(); ++i)
    EXPECT_NEAR(cut.values[i], whole.values[i], 0.02 * whole.deviations[i]) << i;
}

TEST_P(Filter, StaysPhysicalWithAPriorThreeTimesTooWide) {
  Model vague = published_arm();
  for (Parameter& p : vague.parameters) p.spread *= 3.0;
  Session session(vague, settings_);
  for (const Sample& sample : record(2000)) {
    const Estimate e = session.step(sample);
    for (const double value : e.values) ASSERT_TRUE(std::isfinite(value));
    for (const double sd : e.deviations) ASSERT_TRUE(std::isfinite(sd) && sd >= 0.0);
    ASSERT_LT(e.values[5] + e.values[6], 1.0);
    for (std::size_t i = 5; i < e.values.size(); ++i) ASSERT_GE(e.values[i], 0.0);
  }
}

TEST_P(Filter, PriorTenTimesTooWideDoesNotKeepItFromWorking) {
  constexpr int kMostResets = 20;
  Model model = published_arm();
  for (Parameter& p : model.parameters) p.spread *= 10.0;
  Session session(model, settings_);
  int resets = 0;
  for (const Sample& sample : record(4000))
    resets += step(session, sample).status == Status::kReset;
  EXPECT_LE(resets, kMostResets);
}

TEST_P(Filter, NamesWhatTheSamplesDoNotTell) {
  run(session_, record(8000));  // its second look is over
  EXPECT_EQ(session_.hardly_told(), std::vector<std::string>{});
  Session still(published_arm(), settings_);
  for (int k = 0; k < 6000; ++k) still.step({.t = 5e-4 * k, .u = 0.0, .y = 1e-3 * (k % 2)});
  EXPECT_EQ(still.hardly_told().size(), 7U);
}

TEST(Session, CovarianceIsSymmetricToTheLastBit) {
  Session session(published_arm(), {});
  run(session, record(400));
  const SquareMatrix covariance = session.parameter_covariance();
  for (int i = 0; i < covariance.size(); ++i)
    for (int j = 0; j < i; ++j) EXPECT_EQ(covariance(i, j), covariance(j, i));
}

TEST_P(Filter, FindsTheArmItNeverSaw) {
  const Belief end = run(session_, record(6000));
  const Model truth = published_estimate();
  EXPECT_NEAR(end.values[5], truth.parameter("a_m").value, 0.02);
  EXPECT_NEAR(end.values[7], truth.parameter("k_g1").value, 2.0);
  EXPECT_GT(end.values[8], 5.0);  // k_g3, which started at 0
}

TEST_P(Filter, BeginsWithoutItsFirstMeasurements) {
  for (int k = 0; k < 20; ++k) samples_[k].y = kNaN;
  int rejected = 0;
  for (const Sample& sample : samples_)
    rejected += step(session_, sample).status == Status::kRejected;
  EXPECT_EQ(rejected, 0);
}

TEST_P(Filter, LetsAParameterLeaveEitherBoundOfItsInterval) {
  for (const double bound : {-20.0, 20.0}) {
    Model model = published_estimate();
    model.add_effect("torque_bias");
    model.parameter("torque_bias").value = bound;
    Session session(model, settings_);
    const Belief end = run(session, samples_);
    EXPECT_LT(std::abs(end.values.back()), 19.9);
    EXPECT_TRUE(std::isfinite(end.deviations.back()));
  }
}

TEST_P(Filter, WorksWithEveryEffectAndEveryUnknown) {
  for (const std::string_view effect : effect_names()) {
    Model model = published_arm();
    model.add_effect(effect);
    model.parameter("Fc").known = false;
    model.parameter("a_g").known = true;
    Session session(model, settings_);
    const Belief end = run(session, samples_);
    EXPECT_EQ(end.values.size(), model.states.size() + model.unknowns().size());
    for (const double value : end.values) EXPECT_TRUE(std::isfinite(value)) << effect;
  }
}

void expect_sound(const Belief& belief, const std::string& what) {
  for (const double value : belief.values) EXPECT_TRUE(std::isfinite(value)) << what;
  for (const double sd : belief.deviations) EXPECT_TRUE(std::isfinite(sd) && sd > 0.0) << what;
}

/// As much as `diagnose` may ever leave.
Model largest_model() {
  Model model = published_arm();
  for (Parameter& p : model.parameters) p.known = false;
  for (int number = 1; model.has_room_for("flexible_mode_arm"); ++number)
    model.add_effect(fmt::format("flexible_mode_arm:{}", number));
  for (const std::string_view effect : effect_names())
    if (model.has_room_for(effect)) model.add_effect(effect);
  return model;
}

TEST_P(Filter, TakesTheLargestModelThatThereIs) {
  Model model = largest_model();
  ASSERT_EQ(model.states.size(), kMaxStates);
  ASSERT_EQ(model.unknowns().size(), kMaxUnknowns);
  samples_.resize(40);
  Session session(model, settings_);
  expect_sound(run(session, samples_), "largest");
  ASSERT_FALSE(model.has_room_for("torque_gain:2"));
  model.add_effect("torque_gain:2");
  EXPECT_THROW(Session(model, settings_), InputError);
}

TEST_P(Filter, StaysSoundWhateverASampleHolds) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const Belief before = run(session_, samples_);
  const Sample last = samples_.back();
  const auto after = [&](double dt, double u, double y) {
    const Belief belief = step(session_, {last.t + dt, u, y});
    expect_sound(belief, fmt::format("dt {}, u {}, y {}", dt, u, y));
    return belief;
  };
  // Whose time cannot be: passed over, and the belief is the last one's to the last bit.
  for (const double dt : {0.0, -5e-4, -1e9, kNaN, kInfinite, -kInfinite}) {
    const Belief belief = after(dt, last.u, last.y);
    EXPECT_EQ(belief.status, Status::kRejected) << dt;
    EXPECT_EQ(belief.values, before.values) << dt;
  }
  double dt = 0.0;
  for (const double y : {kInfinite, -kInfinite, 1e300, -1e300})
    EXPECT_EQ(after(dt += 5e-4, last.u, y).status, Status::kRejected) << y;
  for (const double u : {kInfinite, -kInfinite, kNaN}) after(dt += 5e-4, u, last.y);
  after(dt += 5e-4, 1e300, last.y);  // and is held
  for (int k = 0; k < 100; ++k) after(dt += 5e-4, last.u, last.y);
}

TEST_P(Filter, StaysSoundWithNextToNoNoise) {
  // Where the sensor's variance is below the rounding of the belief's, an update may leave a
  // negative variance behind, with which the next innovation would pass any gate.
  settings_.noise.model_error = {.start = 0.0, .least = 0.0, .gain = 0.0, .time_s = 0.3};
  settings_.noise.torque = {0.0, 0.0, 0.0};
  settings_.noise.parameter_walk = {.start = 0.0, .floor = 0.0, .time_s = 1.0};
  settings_.prior.speed = 5.0;  // rad/s; parameters that are off may make three times as much of it
  const std::vector<Sample> samples = record(1000);
  for (const auto& [sensor, gate] : {std::pair{1e-6, 25.0}, {1e-12, 25.0}, {1e-6, 1e300}}) {
    SCOPED_TRACE(fmt::format("sensor {} rad/s, gate {}", sensor, gate));
    settings_.noise.sensor = sensor;
    settings_.gate.nis = gate;  // wide open, everything goes into the belief
    Session session(published_arm(), settings_);
    for (const Sample& sample : samples) {
      const Estimate e = session.step(sample);
      for (const double value : e.values) ASSERT_TRUE(std::isfinite(value)) << sample.t;
      for (const double sd : e.deviations) ASSERT_TRUE(std::isfinite(sd) && sd > 0.0) << sample.t;
      ASSERT_TRUE(e.innovation_sd > 0.0) << sample.t;
      ASSERT_LT(e.values[5] + e.values[6], 1.0);
      const double fastest = gate < 1e6 ? 100.0 : kRunawaySpeed;
      ASSERT_LT(std::abs(e.values[kSpeedMotor]), fastest) << sample.t;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(EveryFilter, Filter, ::testing::ValuesIn(filter_names()),
                         [](const auto& test) { return test.param; });

TEST(SquareRootFilter, IsTheUkfWhereThatIsWellConditioned) {
  Session root(published_arm(), settings_of("srukf"));
  Session plain(published_arm(), settings_of("ukf"));
  for (const Sample& sample : record(4000)) {
    const Belief a = step(root, sample);
    const Belief b = step(plain, sample);
    for (std::size_t i = 0; i < a.values.size(); ++i) {
      ASSERT_NEAR(a.values[i], b.values[i], 1e-6 * std::max(1.0, std::abs(b.values[i])));
      ASSERT_NEAR(a.deviations[i] / b.deviations[i], 1.0, 1e-6);
    }
  }
}

TEST(AdaptiveFilter, FindsTheSizeOfTheNoise) {
  ExperimentSettings experiment;
  experiment.samples = 12000;
  experiment.sensor_noise = 0.5;
  experiment.torque_disturbance = 1.0;
  const std::vector<Sample> samples =
      simulate_experiment(published_estimate(), experiment).record.samples;
  for (const std::string_view filter : filter_names()) {
    if (!is_adaptive(filter)) continue;
    EstimatorSettings settings = settings_of(filter);
    settings.noise.sensor = 0.05;
    settings.noise.torque[kMotor] = 1e-3;
    settings.noise.torque[kGear] = 0.0;
    Session session(published_arm(), settings);
    Tally late;
    for (const Sample& sample : samples) {
      const Estimate estimate = session.step(sample);
      if (sample.t > 3.0) late.add(estimate);
    }
    // 6000 samples: the mean of the chi-square has a deviation of 0.018.
    EXPECT_NEAR(late.innovations().mean_nis(), 1.0, 0.06) << filter;
    EXPECT_EQ(late.count(Status::kRejected), 0u) << filter;
  }
}

TEST(Session, BelievesItsStartBeforeTheFirstSample) {
  const Model published = published_arm();
  const Session session(published, {});
  const Model model = session.model();
  const std::vector<double> sd = session.parameter_deviations();
  for (std::size_t i = 0; i < sd.size(); ++i) {
    const Parameter& start = published.parameters[i];
    // k_g3 starts on its bound, of which it has no logarithm.
    const double believed = start.value > start.lower ? start.value : start.lower + start.scale;
    EXPECT_NEAR(model.parameters[i].value, believed, 1e-12 * believed) << start.name;
    EXPECT_EQ(sd[i] > 0.0, !start.known) << start.name;
  }
}

/// A session that goes on from an earlier estimate of the arm's stiffness alone, so many times the
/// true one, with a deviation of such a part of that. All else is known.
struct GoingOn {
  Model model = published_estimate();
  int at = model.index_of("k_a");
  double true_one = model.parameters[at].value;
  EstimatorSettings settings;

  GoingOn(std::string_view filter, double times, double part) : settings(settings_of(filter)) {
    for (Parameter& p : model.parameters) p.known = p.name != "k_a";
    model.parameters[at].value = times * true_one;
    settings.belief = ParameterBelief{{"k_a"}, SquareMatrix(1), {}};
    settings.belief->covariance(0, 0) = std::pow(part * times * true_one, 2);
  }
};

TEST(Session, DoubtsWhatContradictsAnEarlierEstimate) {
  for (const char* filter : {"ukf", "ekf"}) {
    std::vector<double> sd;
    for (const double times : {1.0, 1.1}) {
      const GoingOn on(filter, times, 0.02);
      Session session(on.model, on.settings);
      run(session, record(16000));
      sd.push_back(session.parameter_deviations()[on.at]);
      EXPECT_NEAR(session.model().parameters[on.at].value, on.true_one, 2.0 * sd.back()) << filter;
    }
    EXPECT_GT(sd[1], 4.0 * sd[0]) << filter;
  }
}

/// What many parameters have told together may be known exactly; rounding leaves less than nothing.
TEST(Session, BelievesParametersThatHangTogetherEntirely) {
  Model model = published_estimate();
  for (Parameter& p : model.parameters) p.known = p.name != "k_a" && p.name != "d_a";
  const double k_a = 0.2;   // N.m/rad, its deviation
  const double d_a = 1e-4;  // N.m.s/rad
  ParameterBelief earlier{{"k_a", "d_a"}, SquareMatrix(2), {}};
  earlier.covariance(0, 0) = k_a * k_a;
  earlier.covariance(1, 1) = d_a * d_a;
  earlier.covariance(0, 1) = earlier.covariance(1, 0) = k_a * d_a;
  EstimatorSettings settings;
  settings.belief = earlier;
  const std::vector<double> sd = Session(model, settings).parameter_deviations();
  EXPECT_NEAR(sd[model.index_of("k_a")], k_a, 1e-6 * k_a);
  EXPECT_NEAR(sd[model.index_of("d_a")], d_a, 1e-6 * d_a);
}

/// An earlier estimate that knows next to nothing of a logarithm is no reason to try arms that
/// nobody has built.
TEST(Session, DoubtsAnEarlierEstimateOnlySoFar) {
  const GoingOn on("ukf", 1.0, 100.0);
  EXPECT_NEAR(Session(on.model, on.settings).parameter_deviations()[on.at], 3.0 * on.true_one,
              1e-9);
}

/// Settings under which a measurement that is believed costs likelihood: what is rejected and did
/// not count would be the better start.
EstimatorSettings costly_race(const std::vector<StartFactors>& starts) {
  EstimatorSettings settings;
  settings.noise.sensor = 1.0;
  settings.noise.model_error = {.start = 0.0, .least = 0.0, .gain = 0.0, .time_s = 0.3};
  settings.noise.torque = {0.0, 0.0, 0.0};
  settings.noise.parameter_walk = {};
  settings.race = {.duration_s = 0.3, .starts = starts};
  return settings;
}

TEST(Race, IsNotWonByRefusingToLook) {
  ExperimentSettings experiment;
  experiment.samples = 800;
  experiment.sensor_noise = 1.0;
  const std::vector<Sample> samples =
      simulate_experiment(published_estimate(), experiment).record.samples;
  Model sure = published_estimate();
  for (Parameter& p : sure.parameters) p.spread = 1e-4;
  const StartFactors wrong{{"a_m", 0.01}};
  Session alone(sure, costly_race({wrong}));
  int rejected = 0;
  for (const Sample& sample : samples) {
    const Status status = alone.step(sample).status;
    rejected += status == Status::kRejected || status == Status::kReset;
  }
  EXPECT_GT(rejected, 400);  // or else this shows nothing
  for (const std::size_t right : {0U, 1U}) {
    Session race(sure, costly_race(right == 0 ? std::vector<StartFactors>{{}, wrong}
                                              : std::vector<StartFactors>{wrong, {}}));
    run(race, samples);
    EXPECT_TRUE(race.decided());
    EXPECT_EQ(race.start(), right);
  }
}

/// A clock that is set, 1.7e9 s, when one sample has been taken.
std::vector<Sample> with_clock_set(std::vector<Sample> samples, std::size_t at) {
  for (std::size_t k = at; k < samples.size(); ++k) samples[k].t += 1.7e9;
  return samples;
}

TEST_P(Filter, GapIsNoTimeToLearnIn) {
  // A jump of the clock right at the beginning: what is left is the same record less a sample, and
  // the parameters' walk and the race go on as if nothing had been.
  const std::vector<Sample> samples = record(3000);
  Session jumped(published_arm(), settings_);
  const Belief after = run(jumped, with_clock_set(samples, 1));
  const Belief whole = run(session_, {samples.begin() + 1, samples.end()});
  for (std::size_t i = 0; i < whole.values.size(); ++i) {
    // Time is known to 2e-7 s at 1.7e9 s, 5e-4 of an interval.
    EXPECT_NEAR(after.values[i], whole.values[i], whole.deviations[i]) << i;
    EXPECT_NEAR(after.deviations[i] / whole.deviations[i], 1.0, 0.3) << i;
  }
}

TEST(Session, TakesNoSlowRecordForGaps) {
  Session session(published_estimate(), {});
  const std::vector<Sample> samples = record(2000);
  for (std::size_t k = 0; k < samples.size(); k += 120) {
    const Estimate e = session.step(samples[k]);  // every 60 ms
    EXPECT_NE(e.status, Status::kGap) << k;
  }
}

TEST(Session, RefusesAFilterThatDoesNotExist) {
  try {
    Session session(published_arm(), settings_of("kf"));
    FAIL() << "taken";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "unknown filter 'kf'; known are: ukf, ekf, srukf, ckf, iekf, "
                 "adaptive, adaptive_ekf, adaptive_srukf, adaptive_ckf, "
                 "adaptive_iekf");
  }
}

TEST(Session, RefusesBoundsOfAdaptationThatCross) {
  EstimatorSettings settings = settings_of("adaptive");
  settings.adaptation.least = 2.0;
  settings.adaptation.most = 1.0;
  EXPECT_THROW(Session(published_arm(), settings), InputError);
}

/// Slow motion turns all masses as one: what the motor's share is, only the noise tells that the
/// controller brings into the torque, and by that several arms are nearly as likely. Each filter by
/// itself is too sure of its own.
TEST(Session, DoubtsWhatOnlySeveralArmsTogetherExplain) {
  const Model truth = published_estimate();
  const int motor = truth.index_of("a_m");
  for (const std::uint64_t seed : {101, 102, 103, 104}) {
    const std::vector<Sample> samples =
        simulate_experiment(truth, {.kind = ExperimentKind::kValidation3,
                                    .seed = seed,
                                    .samples = 12000,
                                    .sensor_noise = 0.1,
                                    .torque_disturbance = 0.1})
            .record.samples;
    Session session(published_arm(), {});
    run(session, samples);
    EXPECT_TRUE(session.is_settling()) << seed;
    const double off = session.model().parameters[motor].value - truth.parameters[motor].value;
    EXPECT_LT(std::abs(off), 3.0 * session.parameter_deviations()[motor]) << seed;
    EXPECT_NEAR(std::sqrt(session.parameter_covariance()(0, 0)),
                session.parameter_deviations()[motor], 1e-12)
        << seed;
    // A share is told, though its coordinate holds another mass' share as well.
    EXPECT_EQ(std::ranges::count(session.hardly_told(), "a_m"), 0) << seed;
  }
}

TEST(Passes, BeginWithoutWhatTheSamplesDidNotTell) {
  Model start = published_arm();
  RecursiveEstimate found;
  found.model = start;
  for (const char* name : {"k_a", "d_a"}) found.model.parameter(name).value *= 0.1;
  found.hardly_told = {"d_a"};
  const Model next = next_start(start, found);
  EXPECT_EQ(next.parameter("k_a").value, found.model.parameter("k_a").value);
  EXPECT_EQ(next.parameter("d_a").value, start.parameter("d_a").value);
}

/// The share that was told, beside the other as it was before, would leave the arm none.
TEST(Passes, BeginWithSharesThatLeaveSomethingToEveryMass) {
  const Model start = published_arm();
  RecursiveEstimate found;
  found.model = start;
  found.model.parameter("a_m").value = 0.1;
  found.model.parameter("a_g").value = 0.84;
  found.model.parameter("k_a").value *= 0.5;
  found.hardly_told = {"a_m"};
  const Model next = next_start(start, found);
  EXPECT_TRUE(next.is_physical(next.values()));
  EXPECT_EQ(next.parameter("a_g").value, start.parameter("a_g").value);
  EXPECT_EQ(next.parameter("k_a").value, found.model.parameter("k_a").value);
}

TEST(Condition, StandsInAModelAsEffectsOfTheDrive) {
  Condition condition;
  EXPECT_TRUE(with_drive(published_arm(), condition).effects.empty());
  condition.torque_gain = -0.2;
  condition.input_delay = 1e-3;
  condition.sensor_gain = 0.05;
  const Model model = with_drive(published_arm(), condition);
  ASSERT_EQ(model.effects.size(), 2U);  // none for the sensor
  EXPECT_EQ(model.parameter("torque_gain").value, -0.2);
  EXPECT_TRUE(model.parameter("torque_gain").known);
  EXPECT_EQ(model.parameter("input_delay").value, 1e-3);
  std::vector<Sample> samples{{0.0, 1.0, 2.1}, {1e-3, 3.0, 4.2}, {2e-3, 5.0, 6.3}};
  samples = at_the_arm(samples, condition);
  EXPECT_DOUBLE_EQ(samples[2].u, 0.8 * 3.0);
  EXPECT_DOUBLE_EQ(samples[2].y, 6.0);
  const std::vector<Deviance> all = deviances(condition);
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all.back().name, "sensor_gain");
  EXPECT_TRUE(all.back().of_sensor);
}

TEST(Tally, JudgesTheModelByWhatComesAfterAChange) {
  Session session(published_arm(), {});
  Tally tally;
  const std::vector<Sample> samples = record(400);
  for (int k = 0; k < 300; ++k) tally.add(session.step(samples[k]));
  EXPECT_EQ(tally.lately().count(), 300U);
  tally.begin_anew();
  for (int k = 300; k < 400; ++k) tally.add(session.step(samples[k]));
  EXPECT_EQ(tally.lately().count(), 100U);
  EXPECT_EQ(tally.innovations().count(), 400U);
}

TEST(Tally, CountsWhatBecameOfEachSample) {
  Session session(published_arm(), {});
  std::vector<Sample> samples = record(100);
  samples[50].y = kNaN;
  samples[60].y = 1e4;
  Tally tally;
  for (const Sample& sample : samples) tally.add(session.step(sample));
  EXPECT_EQ(tally.samples(), 100u);
  EXPECT_EQ(tally.count(Status::kMissing), 1u);
  EXPECT_EQ(tally.count(Status::kRejected), 1u);
  EXPECT_EQ(tally.innovations().count(), 98u);
}

/// Sigma points over a whole turn would tell nothing of an angle, and lead all parameters astray.
TEST(Session, FindsAnAngleWhereverItBegins) {
  Model model = published_estimate();
  model.add_effect("gravity");
  model.parameter("gravity").value = 2.0;
  const std::vector<Sample> samples =
      simulate_experiment(model, {.sensor_noise = 0.1, .torque_disturbance = 0.1}).record.samples;
  for (const std::ptrdiff_t first : {1500, 3000, 4500}) {
    Session session(model, {});
    for (auto sample = samples.begin() + first; sample != samples.end(); ++sample)
      session.step(*sample);
    const Model found = session.model();
    EXPECT_NEAR(found.parameter("gravity").value, 2.0, 0.05) << "from sample " << first;
    EXPECT_NEAR(found.parameter("k_a").value, model.parameter("k_a").value, 0.5)
        << "from sample " << first;
  }
}

}  // namespace
}  // namespace armukf
