#include "armukf/diagnosis/consistency.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "armukf/batch/experiment.hpp"
#include "armukf/diagnosis/trace_records.hpp"
#include "diagnosis/noisy_record.hpp"

namespace armukf {
namespace {

/// A record of the published arm, and one of an arm of so much of its gear's stiffness.
TraceRecords records_of_two(double stiffness) {
  constexpr int kSamples = 6000;
  Model other = published_estimate();
  other.parameter("k_g1").value *= stiffness;
  return trace_records({noisy_record(published_estimate(), kSamples, 0.1, 0.5, 1)},
                       {noisy_record(other, kSamples, 0.1, 0.5, 2)}, {}, 0.05);
}

TEST(OneForAll, IsThereWhereTheArmIsTheSame) {
  for (const double stiffness : {1.0, 0.7}) {
    const TraceRecords records = records_of_two(stiffness);
    const Explained now = explained(published_arm(), {}, records, kForesightDensity);
    EXPECT_EQ(one_for_all(now, published_arm(), records, {}), stiffness == 1.0);
  }
}

TEST(Disagreements, AreOfRecordsOnlyWhereNoModelIsOneForAll) {
  const std::vector<Consistency> all{{"k_g1", "halves", {20.0, 15.0}, {0.1, 0.1}, 1e-9},
                                     {"k_a", "records", {15.0, 12.0}, {0.1, 0.1}, 1e-9},
                                     {"d_g", "records", {0.04, 0.02}, {1e-3, 1e-3}, 1e-9},
                                     {"a_m", "records", {0.2, 0.3}, {0.1, 0.1}, 0.5}};
  int asked = 0;
  const auto told = [&](bool same) {
    return disagreements(all, published_arm(), [&asked, same] {
      ++asked;
      return same;
    });
  };
  const std::vector<std::string> different = told(false);
  ASSERT_EQ(different.size(), 3U);
  EXPECT_EQ(different[1],
            "k_a is 15 ± 0.1 in one of two records and 12 ± 0.1 N.m/rad in the other: its law is "
            "not this one");
  EXPECT_EQ(asked, 1);
  const std::vector<std::string> same = told(true);
  ASSERT_EQ(same.size(), 1U);
  EXPECT_EQ(same[0].rfind("k_g1 is 20 ", 0), 0U);
}

}  // namespace
}  // namespace armukf
