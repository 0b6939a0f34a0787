#include "armukf/diagnosis/score.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "armukf/diagnosis/foresight.hpp"
#include "diagnosis/noisy_record.hpp"

namespace armukf {
namespace {

constexpr double kHertz = 5.0;

/// A torque of that frequency: its cosine, and its sine.
Eigen::MatrixXd waves(const Record& record) {
  Eigen::MatrixXd torques(record.samples.size(), 2);
  for (std::size_t k = 0; k < record.samples.size(); ++k) {
    const double angle = 2.0 * std::numbers::pi * kHertz * record.samples[k].t;
    torques.row(static_cast<Eigen::Index>(k)) << std::cos(angle), std::sin(angle);
  }
  return torques;
}

/// A fit of the complete model to a record that such a torque of that size (N.m) has acted on
/// besides u, and what the test says of it.
Score score_of_wave(double size) {
  std::vector<Record> pieces{noisy_record(published_estimate(), 6000, 0.1, 0.5, 1)};
  const Eigen::MatrixXd torques = waves(pieces[0]);
  for (std::size_t k = 0; k < pieces[0].samples.size(); ++k)
    pieces[0].samples[k].u -= size * torques(static_cast<Eigen::Index>(k), 0);
  const ForesightFit fit =
      fit_foresight(published_estimate(), {}, pieces, {}, kForesightDensity, 20);
  return ScoreTest(fit.model, fit.x0, pieces, {})(torques);
}

TEST(Score, TellsTheSizeOfATorqueThatIsNotInTheInput) {
  const Score score = score_of_wave(0.2);
  EXPECT_LT(score.p_value, 1e-6);
  EXPECT_GT(score.share, 0.005);
  EXPECT_NEAR(score.sizes[0], 0.2, 0.04);
  EXPECT_NEAR(score.sizes[1], 0.0, 0.04);
}

TEST(Score, OfWhatIsNotThereIsNoneBeyondChance) {
  const Score score = score_of_wave(0.0);
  EXPECT_GT(score.p_value, 1e-3);
  EXPECT_LT(score.share, 0.005);
}

TEST(Score, OfWhatTheModelExplainsAnywayIsNone) {
  const std::vector<Record> pieces{noisy_record(published_estimate(), 3000, 0.1, 0.5, 1)};
  const ForesightFit fit =
      fit_foresight(published_estimate(), {}, pieces, {}, kForesightDensity, 20);
  const Score score = ScoreTest(fit.model, fit.x0, pieces, {})(
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(pieces[0].samples.size()), 1));
  EXPECT_EQ(score.p_value, 1.0);
  EXPECT_EQ(score.share, 0.0);
}

}  // namespace
}  // namespace armukf
