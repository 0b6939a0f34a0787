#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "armukf/batch/experiment.hpp"
#include "armukf/core/error.hpp"
#include "armukf/online/seals.hpp"
#include "armukf/online/session.hpp"
#include "armukf/online/track.hpp"

namespace armukf {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A record with all that a filter may meet: missing measurements, a spike, a gap, and a speed that
/// stays so wrong that the states begin anew.
std::vector<Sample> eventful(int samples) {
  ExperimentSettings experiment;
  experiment.samples = samples;
  experiment.sensor_noise = 0.1;
  std::vector<Sample> record = simulate_experiment(published_estimate(), experiment).record.samples;
  for (int k = 0; k < samples; ++k) {
    if (k % 50 == 7) record[k].y = kNaN;
    if (k % 90 == 11) record[k].y += 1000.0;
    if (k >= samples / 2) record[k].t += 1.0;
    if (k >= samples / 4 && k < samples / 4 + 60) record[k].y += 500.0;
  }
  return record;
}

/// All that a session says of samples, from one of them on.
std::vector<double> said(Session& session, const std::vector<Sample>& samples, int from, int to) {
  std::vector<double> all;
  for (int k = from; k < to; ++k) {
    const Estimate e = session.step(samples[k]);
    all.insert(all.end(), {e.predicted, e.innovation, e.innovation_sd, e.nis, e.log_likelihood,
                           static_cast<double>(e.status)});
    all.insert(all.end(), e.values.begin(), e.values.end());
    all.insert(all.end(), e.deviations.begin(), e.deviations.end());
  }
  std::ranges::replace_if(
      all, [](double x) { return std::isnan(x); }, 1e99);  // NaN equals nothing
  return all;
}

struct Case {
  std::string filter;
  std::string effect;
  int free = 0;  // further parameters that are unknown
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.filter << ' ' << c.effect << c.free; }

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const std::string& filter : filter_names()) {
    all.push_back({filter, "", 0});
    all.push_back({filter, "presliding_friction", 1});
    all.push_back({filter, "speed_ripple", 6});
  }
  return all;
}

Model model_of(const Case& c) {
  Model model = published_arm();
  if (!c.effect.empty()) model.add_effect(c.effect);
  for (int i = 0; i < c.free; ++i) model.parameters[i].known = false;
  return model;
}

class Checkpoint : public testing::TestWithParam<Case> {
 protected:
  Checkpoint() {
    settings_.filter = GetParam().filter;
    settings_.race.duration_s = 0.1;  // 200 samples
  }
  EstimatorSettings settings_;
  Model model_ = model_of(GetParam());
};

TEST_P(Checkpoint, SessionGoesOnWithTheSameNumbersToTheLastBit) {
  constexpr int kSamples = 480;
  const std::vector<Sample> samples = eventful(kSamples);
  // At the start, in the race, while measurements are rejected, after it, after the gap.
  for (const int at : {0, 1, 90, 140, 170, 239, 240, 330}) {
    Session whole(model_, settings_);
    said(whole, samples, 0, at);
    const std::string bytes = whole.save();
    Session other(model_, settings_);
    said(other, samples, 0, 30);  // what it believed before does not matter
    other.load(bytes);
    EXPECT_TRUE(other.save() == bytes) << at;  // thousands of bytes that nobody wants to see
    EXPECT_EQ(other.decided(), whole.decided());
    EXPECT_TRUE(said(other, samples, at, kSamples) == said(whole, samples, at, kSamples)) << at;
    EXPECT_EQ(other.start(), whole.start());
    EXPECT_TRUE(other.save() == whole.save()) << at;
  }
}

INSTANTIATE_TEST_SUITE_P(All, Checkpoint, testing::ValuesIn(cases()));

std::string refusal(Session& session, const std::string& bytes) {
  try {
    session.load(bytes);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(CheckpointRefused, OfAnotherModelFilterOrSettingWithTheLineThatDiffers) {
  const std::string bytes = Session(published_arm(), {}).save();
  EstimatorSettings ekf;
  ekf.filter = "ekf";
  Session other_filter(published_arm(), ekf);
  EXPECT_EQ(refusal(other_filter, bytes),
            "is of another model or filter: 'filter ukf' there, 'filter ekf' here");
  Model bounded = published_arm();
  bounded.parameter("k_a").upper = 100.0;
  Session other_model(bounded, {});
  EXPECT_EQ(refusal(other_model, bytes),
            "is of another model or filter: 'k_a 20.23072060978318 unknown 0 inf 20 0.3' there, "
            "'k_a 20.23072060978318 unknown 0 100 20 0.3' here");
  EstimatorSettings noisy;
  noisy.noise.sensor = 0.2;
  Session other_noise(published_arm(), noisy);
  EXPECT_NE(refusal(other_noise, bytes).find("[noise] sensor"), std::string::npos);
  Model more = published_arm();
  more.add_effect("backlash");
  Session other_effect(more, {});
  EXPECT_NE(refusal(other_effect, bytes).find("'effect backlash' here"), std::string::npos);
}

TEST(CheckpointRefused, LeavesTheSessionAsItWas) {
  const std::vector<Sample> samples = eventful(60);
  Session session(published_arm(), {});
  said(session, samples, 0, 40);
  const std::string bytes = session.save();
  for (std::size_t size = 0; size < bytes.size(); size += 97)
    EXPECT_NE(refusal(session, bytes.substr(0, size)), "");
  EXPECT_NE(refusal(session, bytes + "x"), "");
  // Sealed as it should be, but not what was in it.
  const std::string content(unsealed(kSessionSeal, bytes));
  for (std::size_t size = 0; size < content.size(); size += 97)
    EXPECT_NE(refusal(session, sealed(kSessionSeal, content.substr(0, size))), "") << size;
  EXPECT_TRUE(session.save() == bytes);
}

TEST(SessionClock, ThatIsSetIsAGapAndGoesOn) {
  std::vector<Sample> samples = eventful(400);
  Session kept(published_arm(), {});
  Session set(published_arm(), {});
  said(kept, samples, 0, 200);
  said(set, samples, 0, 200);
  const double origin = samples[200].t;
  set.expect_new_clock();
  for (int k = 200; k < 400; ++k) {
    const Estimate a = kept.step(samples[k]);
    Sample shifted = samples[k];
    shifted.t -= origin;
    const Estimate b = set.step(shifted);
    EXPECT_EQ(b.status, a.status) << k;  // the record has a gap there as well
    EXPECT_EQ(b.sample.t, shifted.t);
    for (std::size_t i = 0; i < a.values.size(); ++i)
      EXPECT_NEAR(b.values[i], a.values[i], 1e-6 * (1.0 + std::abs(a.values[i]))) << k;
  }
}

/// Estimates of a track: time and first state, all that came of these samples.
std::vector<std::pair<double, double>> tracked(Track& track, const std::vector<Sample>& samples,
                                               std::size_t from, std::size_t to) {
  std::vector<std::pair<double, double>> all;
  for (std::size_t k = from; k < to; ++k) {
    track.put(samples[k]);
    while (const auto e = track.next()) all.emplace_back(e->sample.t, e->values.back());
  }
  return all;
}

class TrackResumed : public testing::TestWithParam<double> {};

TEST_P(TrackResumed, PassesOverWhatTheCheckpointCoversAndGoesOnBitByBit) {
  std::vector<Sample> samples = eventful(300);
  std::swap(samples[120], samples[121]);                                    // out of order
  samples.insert(samples.begin() + 140, samples[139]);                      // twice
  for (std::size_t k = 200; k < samples.size(); ++k) samples[k].t -= 1.05;  // the clock is set
  samples[60].t = 1e12;                                                     // nonsense
  const Arrival arrival{.reorder_s = GetParam()};
  for (const std::size_t at : {1, 50, 61, 121, 141, 199, 201, 202, 203, 204, 280}) {
    Track whole(published_arm(), {}, arrival);
    tracked(whole, samples, 0, at);
    const std::string bytes = whole.save();
    const auto rest = tracked(whole, samples, at, samples.size());
    whole.end();
    Track again(published_arm(), {}, arrival);
    again.load(bytes);
    EXPECT_EQ(tracked(again, samples, 0, samples.size()), rest) << at;
    again.end();
    EXPECT_EQ(again.tally().samples(), whole.tally().samples()) << at;
    EXPECT_EQ(again.counts().fates.new_clocks, whole.counts().fates.new_clocks) << at;
  }
}

INSTANTIATE_TEST_SUITE_P(WithAndWithoutReordering, TrackResumed, testing::Values(0.0, 0.002));

TEST(TrackResume, StreamMayBeginAfterTheCheckpoint) {
  const std::vector<Sample> samples = eventful(300);
  Track whole(published_arm(), {});
  tracked(whole, samples, 0, 200);
  Track rest(published_arm(), {});
  rest.load(whole.save());
  EXPECT_EQ(tracked(rest, samples, 200, 300), tracked(whole, samples, 200, 300));
}

TEST(TrackResume, NewClockMakesNothingOld) {
  const std::vector<Sample> samples = eventful(100);
  Track track(published_arm(), {});
  tracked(track, samples, 0, 100);
  Track later(published_arm(), {});
  later.load(track.save());
  later.expect_new_clock();
  EXPECT_EQ(tracked(later, samples, 0, 100).size(), 100U);
}

}  // namespace
}  // namespace armukf
