#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "armukf/batch/experiment.hpp"
#include "armukf/batch/simulation.hpp"
#include "armukf/online/recursion.hpp"
#include "armukf/report/model_file.hpp"
#include "heavier.hpp"

namespace armukf {
namespace {

std::vector<Sample> record(const Model& model, int samples = 12000, std::uint64_t seed = 1) {
  return simulate_experiment(
             model,
             {.seed = seed, .samples = samples, .sensor_noise = 0.3, .torque_disturbance = 0.2})
      .record.samples;
}

class EachFilter : public ::testing::TestWithParam<std::string> {
 protected:
  EstimatorSettings settings_ = [] {
    EstimatorSettings settings;
    settings.filter = GetParam();
    return settings;
  }();
};

TEST_P(EachFilter, LearnsTheSensorsNoiseWhateverItWasTold) {
  settings_.noise.sensor = 0.02;
  const RecursiveEstimate found =
      estimate_record(published_arm(), settings_, record(published_estimate()));
  const LearntNoise& noise = found.belief.noise;
  ASSERT_TRUE(noise.known);
  EXPECT_NEAR(noise.sensor_sd, 0.3, 0.02);
  EXPECT_LT(noise.sensor_pole, 0.05);
  // The mean of 8000 squares has a deviation of 0.016; what the model's error keeps is below 0.05.
  EXPECT_NEAR(found.tally.innovations().mean_nis(), 1.0, 0.1);
}

// A drive that loses a telegram now and then, and a scheduler that is a tenth of a sample late.
TEST_P(EachFilter, LearnsTheNoiseWhereSamplesAreMissingLateOrWrong) {
  std::vector<Sample> samples = record(published_estimate());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    samples[k].t += k % 2 == 0 ? 0.0 : 7e-5;
    if (k % 500 == 100) samples[k].y = NAN;
    if (k % 500 == 300) samples[k].y += 50.0;
  }
  std::erase_if(samples, [&](const Sample& s) { return (&s - samples.data()) % 500 == 400; });
  const RecursiveEstimate found = estimate_record(published_arm(), settings_, samples);
  ASSERT_TRUE(found.belief.noise.known);
  EXPECT_NEAR(found.belief.noise.sensor_sd, 0.3, 0.02);
  EXPECT_NEAR(found.tally.innovations().mean_nis(), 1.0, 0.1);
}

// What is usual of torques, of their noise among them, goes with the arm's inertia.
TEST_P(EachFilter, LearnsTheSameOfAHeavierArm) {
  const std::vector<Sample> samples = record(published_estimate());
  const RecursiveEstimate light = estimate_record(published_arm(), settings_, samples);
  for (const double times : {100.0, 0.01}) {
    const RecursiveEstimate heavy =
        estimate_record(heavier(published_arm(), times), settings_, heavier(samples, times));
    ASSERT_TRUE(heavy.belief.noise.known);
    EXPECT_NEAR(heavy.tally.innovations().mean_nis(), light.tally.innovations().mean_nis(), 1e-3);
    EXPECT_NEAR(heavy.belief.noise.torque_sd, times * light.belief.noise.torque_sd,
                1e-2 * heavy.belief.noise.torque_sd);
    for (const int i : light.model.unknowns()) {
      const Parameter& p = light.model.parameters[i];
      const double expected = std::pow(times, power_of_torque(p.unit)) * p.value;
      EXPECT_NEAR(heavy.model.parameters[i].value, expected, 1e-2 * expected) << p.name;
    }
  }
}

TEST_P(EachFilter, SaysNothingOfNoiseThatItCouldNotLearn) {
  std::vector<Sample> samples = record(published_estimate());
  for (std::size_t k = 0; k < samples.size(); k += 2) samples[k].y = NAN;
  const RecursiveEstimate found = estimate_record(published_arm(), settings_, samples);
  EXPECT_FALSE(found.belief.noise.sought);
}

/// An arm that begins to move after a rest, sines of torque, and what a sensor shows of it: 0
/// without any noise while it rests.
std::vector<Sample> after_rest(int rest, int motion) {
  const Model truth = published_estimate();
  std::vector<Sample> samples;
  for (int k = 0; k < rest + motion; ++k) {
    const double t = 5e-4 * k;
    double u = 0.0;
    for (const double hertz : {1.3, 7.0, 16.0, 29.0})
      if (k >= rest) u += 2.0 * std::sin(2.0 * std::numbers::pi * hertz * (t - 5e-4 * rest));
    samples.push_back({.t = t, .u = u, .y = 0.0});
  }
  const auto states =
      simulate_states(truth, std::vector<double>(truth.states.size(), 0.0), samples, {});
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, 0.3);
  for (int k = rest; k < rest + motion; ++k)
    samples[k].y = states[k][kMeasuredState] + noise(random);
  return samples;
}

TEST_P(EachFilter, StandstillChangesNothing) {
  const RecursiveEstimate at_once =
      estimate_record(published_arm(), settings_, after_rest(0, 16000));
  const RecursiveEstimate found =
      estimate_record(published_arm(), settings_, after_rest(8000, 16000));
  EXPECT_EQ(found.tally.count(Status::kReset), 0U);
  ASSERT_TRUE(found.belief.noise.known);
  EXPECT_NEAR(found.belief.noise.sensor_sd, 0.3, 0.03);
  EXPECT_NEAR(found.tally.innovations().mean_nis(), 1.0, 0.1);
  for (const int i : found.model.unknowns()) {
    const double sd = at_once.sd[i];
    EXPECT_NEAR(found.model.parameters[i].value, at_once.model.parameters[i].value, sd)
        << found.model.parameters[i].name;
    EXPECT_NEAR(found.sd[i] / sd, 1.0, 0.3) << found.model.parameters[i].name;
  }
}

/// The same motion, come upon when the arm has swung for a while: the masses differ in speed, and
/// the springs are wound.
TEST_P(EachFilter, FindsAnArmThatSwingsAlready) {
  for (const int swung : {1100, 1500, 1900}) {
    std::vector<Sample> samples = after_rest(0, swung + 16000);
    samples.erase(samples.begin(), samples.begin() + swung);
    const RecursiveEstimate found = estimate_record(published_arm(), settings_, samples);
    const Model truth = published_estimate();
    EXPECT_TRUE(found.belief.noise.known) << swung;
    for (const int i : found.model.unknowns()) {
      const Parameter& p = truth.parameters[i];
      EXPECT_NEAR(found.model.parameters[i].value, p.value, 4.0 * found.sd[i])
          << p.name << " " << swung;
    }
    EXPECT_NEAR(found.model.parameter("k_a").value / truth.parameter("k_a").value, 1.0, 0.05)
        << swung;
  }
}

TEST(SecondLook, ComesAfterThreeSecondsAndSettlesForOne) {
  Session session(published_arm(), {});
  for (const Sample& sample : record(published_estimate(), 10000)) {
    session.step(sample);
    EXPECT_EQ(session.is_settling(), sample.t < 4.0 - 1e-9) << sample.t;
    EXPECT_EQ(session.decided(), sample.t >= 2.0 - 1e-9) << sample.t;
  }
}

/// On their way from start values that are far off, filters pass arms that are none.
TEST(SecondLook, NobodyIsSureOfAnArmBeforeIt) {
  constexpr double kBefore = 2.9;  // s
  constexpr double kNinety = 1.645;
  const Model truth = published_estimate();
  for (const ExperimentKind kind : {ExperimentKind::kEstimation, ExperimentKind::kValidation1}) {
    ExperimentSettings settings;
    settings.kind = kind;
    settings.samples = 8000;
    settings.sensor_noise = 0.1;
    settings.torque_disturbance = 0.05;
    Session session(published_arm(), {});
    double before = 0.0;
    for (const Sample& sample : simulate_experiment(truth, settings).record.samples) {
      session.step(sample);
      if (sample.t > kBefore && before == 0.0) {
        before = session.parameter_deviations()[kKa];
        EXPECT_NEAR(session.model().parameters[kKa].value, truth.parameters[kKa].value,
                    kNinety * before);
        const double variance = session.parameter_covariance()(kKa - kAm, kKa - kAm);
        EXPECT_NEAR(std::sqrt(variance) / before, 1.0, 1e-6);
      }
    }
    EXPECT_LT(session.parameter_deviations()[kKa], 0.2 * before);
  }
}

/// Arms, motions and noises by which the filters of the race, and the winner's second look, end at
/// an arm spring of twice the stiffness and more.
TEST(SecondLook, LeavesAWrongArmForARival) {
  struct Case {
    std::vector<double> arm;  // the unknowns
    ExperimentSettings settings;
  };
  const std::vector<Case> cases{{{0.2234, 0.7066, 21.43, 27.58, 0.02384, 10.74, 0.003301},
                                 {.kind = ExperimentKind::kEstimation,
                                  .seed = 49,
                                  .sensor_noise = 0.144,
                                  .torque_disturbance = 0.3,
                                  .torque_pole = 0.9}},
                                {{0.2041, 0.7259, 16.02, 21.97, 0.02333, 12.59, 0.002669},
                                 {.kind = ExperimentKind::kValidation2,
                                  .seed = 79,
                                  .sensor_noise = 0.452,
                                  .torque_disturbance = 0.264,
                                  .torque_pole = 0.9}}};
  for (const Case& c : cases) {
    Model truth = published_estimate();
    for (std::size_t k = 0; k < c.arm.size(); ++k)
      truth.parameters[truth.unknowns()[k]].value = c.arm[k];
    const RecursiveEstimate found =
        estimate_record(published_arm(), {}, simulate_experiment(truth, c.settings).record.samples);
    EXPECT_NEAR(found.model.parameter("k_a").value / truth.parameter("k_a").value, 1.0, 0.3);
  }
}

/// Nor does one that goes on from what was believed settle at all.
TEST(SecondLook, DoesNotComeWhereTheModelLacksSomething) {
  Model truth = published_estimate();
  truth.add_effect("torque_ripple");
  truth.parameter("torque_ripple").value = 6.0;
  const std::vector<Sample> samples = record(truth, 10000);
  Session session(published_arm(), {});
  for (const Sample& sample : samples) {
    session.step(sample);
    EXPECT_EQ(session.is_settling(), sample.t < 3.0 - 1e-9) << sample.t;
  }
  EstimatorSettings later;
  later.belief = session.belief();
  Session again(session.model(), later);
  for (const Sample& sample : samples) {
    again.step(sample);
    EXPECT_FALSE(again.is_settling()) << sample.t;
  }
}

/// Where samples come so fast that there is no room for all, it comes when that is full: what is
/// believed jumps there.
TEST(SecondLook, ComesWhereThereIsNoRoomForMore) {
  constexpr double kInterval = 1.0 / 3000;  // s
  const std::vector<Sample> samples =
      simulate_experiment(published_estimate(), {.samples = 13000,
                                                 .sample_time_s = kInterval,
                                                 .sensor_noise = 0.3,
                                                 .torque_disturbance = 0.2})
          .record.samples;
  Session session(published_arm(), {});
  const int k_a = published_arm().index_of("k_a");
  double last = 0.0;
  double largest = 0.0;
  std::size_t at = 0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    session.step(samples[k]);
    ASSERT_EQ(session.is_settling(), samples[k].t < 4.0 - 1e-9) << samples[k].t;
    const double sd = session.parameter_deviations()[k_a];
    const double jump = std::abs(std::log(sd / std::exchange(last, sd)));
    if (samples[k].t < 2.5 || jump < largest) continue;
    largest = jump;
    at = k;
  }
  EXPECT_EQ(at, 8192U);  // told with the first sample that is not kept
}

TEST_P(EachFilter, TakesNoMissingTorqueForNoise) {
  Model truth = published_estimate();
  truth.add_effect("torque_ripple");
  truth.parameter("torque_ripple").value = 6.0;
  const RecursiveEstimate found = estimate_record(published_arm(), settings_, record(truth));
  EXPECT_FALSE(found.belief.noise.known);
  EXPECT_GT(found.belief.noise.not_noise, 0.5);
}

TEST_P(EachFilter, GoesOnFromWhatItBelieved) {
  const Model truth = published_estimate();
  const RecursiveEstimate first = estimate_record(published_arm(), settings_, record(truth));
  EstimatorSettings later = settings_;
  later.belief = first.belief;
  Session session(first.model, later);
  EXPECT_TRUE(session.decided());
  const std::vector<double> sd = session.parameter_deviations();
  for (const int i : first.model.unknowns())
    EXPECT_NEAR(sd[i] / first.sd[i], 1.0, 1e-6) << first.model.parameters[i].name;
  for (const Sample& sample : record(truth, 6000, 2)) {
    session.step(sample);
    const Model now = session.model();
    for (const int i : now.unknowns())
      ASSERT_LT(std::abs(now.parameters[i].value - first.model.parameters[i].value),
                3.5 * first.sd[i])
          << now.parameters[i].name << " at " << sample.t;
  }
}

INSTANTIATE_TEST_SUITE_P(Some, EachFilter, ::testing::Values("ukf", "ekf", "srukf"),
                         [](const auto& test) { return test.param; });

TEST(Covariance, GoesWithTheDeviations) {
  const RecursiveEstimate found =
      estimate_record(published_arm(), {}, record(published_estimate(), 6000));
  const std::vector<int> unknowns = found.model.unknowns();
  ASSERT_EQ(found.belief.covariance.size(), static_cast<int>(unknowns.size()));
  for (std::size_t k = 0; k < unknowns.size(); ++k) {
    const int i = static_cast<int>(k);
    EXPECT_NEAR(std::sqrt(found.belief.covariance(i, i)) / found.sd[unknowns[k]], 1.0, 1e-9);
    EXPECT_GE(found.sd[unknowns[k]], found.model_sd[unknowns[k]] * (1.0 - 1e-12));
    for (int j = 0; j < i; ++j)
      EXPECT_NEAR(found.belief.covariance(i, j), found.belief.covariance(j, i),
                  1e-12 * found.sd[unknowns[k]] * found.sd[unknowns[static_cast<std::size_t>(j)]]);
  }
}

TEST(Belief, ReadsBackFromAModelFile) {
  const RecursiveEstimate found =
      estimate_record(published_arm(), {}, record(published_estimate(), 6000));
  ModelFile content{found.model, {}};
  content.settings.belief = found.belief;
  // Rounding leaves the matrix symmetric only to the last digits; a file is exact.
  const std::string text = model_file_text(content);
  const ModelFile back = parse_model_file(text, "saved.toml");
  EXPECT_EQ(model_file_text(back), text);
  ASSERT_TRUE(back.settings.belief.has_value());
  EXPECT_EQ(back.settings.belief->noise.sensor_sd, found.belief.noise.sensor_sd);
}

}  // namespace
}  // namespace armukf
