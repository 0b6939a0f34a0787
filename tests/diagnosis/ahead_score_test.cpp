#include "armukf/diagnosis/ahead_score.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "armukf/core/parallel.hpp"
#include "armukf/diagnosis/foresight.hpp"
#include "diagnosis/noisy_record.hpp"

namespace armukf {
namespace {

/// A record of an arm with a torque offset (N.m), scored on the arm without it.
class AheadScoreOfAnOffset : public ::testing::Test {
 protected:
  static constexpr double kOffset = 0.1;

  AheadScoreOfAnOffset() {
    Model with = published_estimate();
    with.add_effect("torque_bias");
    with.parameter("torque_bias").value = kOffset;
    records_.pieces.push_back(noisy_record(with, 4000, 0.1, 0.5, 1));
    x0_ = states_before(base_, records_.pieces, {});
  }

  AheadScore score() const {
    return {base_, x0_, records_, foresight_gains(base_, x0_, records_.pieces, {})};
  }

  Model base_ = published_estimate();
  Thinned records_;
  StatesOfPieces x0_;
};

TEST_F(AheadScoreOfAnOffset, SuggestsItsSize) {
  const std::vector<Suggestion> found = score()(trials_of("torque_bias", base_, {}));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].model.parameter("torque_bias").value, kOffset, 0.2 * kOffset);
  EXPECT_GT(found[0].share, 0.01);
}

TEST_F(AheadScoreOfAnOffset, OfATrialIsTheSameWhateverIsScoredWithIt) {
  const Suggested suggested{{1.0, 2.0}, {1.0, 2.0}, {1.0, 2.0}, {30.0}, 2.0, 1.0};
  std::vector<Trial> trials = trials_for(base_, suggested);
  for (Trial& law : last_trials_for(base_, suggested, records_.pieces, {}))
    trials.push_back(std::move(law));
  const Crew crew(2);
  const std::vector<Suggestion> together = score()(trials);
  ASSERT_EQ(together.size(), trials.size());
  int told = 0;  // others would have to be less than nothing
  for (std::size_t i = 0; i < trials.size(); ++i) {
    const Suggestion alone = score()({trials[i]}).front();
    // Effects of no size add zeros to the arm's torques: only roundings differ.
    told += alone.share > 1e-4 ? 1 : 0;
    EXPECT_NEAR(together[i].share, alone.share, 1e-9) << trials[i].effect;
    for (const int size : trials[i].sizes) {
      const double expected = alone.model.parameters[size].value;
      EXPECT_NEAR(together[i].model.parameters[size].value, expected,
                  1e-6 * std::max(1e-3, std::abs(expected)))
          << trials[i].effect;
    }
    if (trials[i].cyclic_state < 0) continue;
    const auto at = static_cast<std::size_t>(trials[i].cyclic_state);
    EXPECT_NEAR(together[i].x0[0][at], alone.x0[0][at], 1e-6) << trials[i].effect;
  }
  EXPECT_GT(told, 15);
}

}  // namespace
}  // namespace armukf
