#include "armukf/report/formula_text.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

namespace armukf {
namespace {

const Symbol a = Symbol::variable("a");
const Symbol b = Symbol::variable("b");
const Symbol c = Symbol::variable("c");

std::string text(const Symbol& formula, Language language = Language::kC) {
  return FormulaText({formula}, language).formulas()[0];
}

TEST(FormulaText, KeepsTheOrderOfOperations) {
  EXPECT_EQ(text(a + b + c), "a + b + c");
  EXPECT_EQ(text(a + (b + c)), "a + (b + c)");
  EXPECT_EQ(text(a - (b - c)), "a - (b - c)");
  EXPECT_EQ(text(a * (b + c)), "a * (b + c)");
  EXPECT_EQ(text(a / (b * c)), "a / (b * c)");
  EXPECT_EQ(text(a / b * c), "a / b * c");
  EXPECT_EQ(text(-(a * b)), "-(a * b)");
  EXPECT_EQ(text(-a * b), "-a * b");
}

TEST(FormulaText, LeavesOutWhatDoesNothing) {
  EXPECT_EQ(text(0.0 * a + 1.0 * b), "b");
  EXPECT_EQ(text(a / 1.0 + 0.0), "a");
  EXPECT_EQ(text(a + -b), "a - b");
  EXPECT_EQ(text(0.0 - a), "-a");
  EXPECT_EQ(text(-(-a)), "a");
  EXPECT_EQ(text(Symbol(2.0) * 3.0), "6.0");
}

TEST(FormulaText, NamesOnceWhatIsUsedTwice) {
  const Symbol both = a + b;
  const FormulaText written({sqrt(both) * both, both * c}, Language::kC);
  const std::vector<std::pair<std::string, std::string>> common{{"v1", "a + b"}};
  EXPECT_EQ(written.common(), common);
  EXPECT_EQ(written.formulas(), (std::vector<std::string>{"sqrt(v1) * v1", "v1 * c"}));
  EXPECT_TRUE(written.uses("a") && written.uses("c"));
  EXPECT_FALSE(written.uses("d"));
}

TEST(FormulaText, SpeaksBothLanguages) {
  const Symbol choice = where_negative(a, -b, b);
  EXPECT_EQ(text(choice), "(a < 0.0 ? -b : b)");
  EXPECT_EQ(text(choice, Language::kMatlab), "((a < 0) * -b + (a >= 0) * b)");
  EXPECT_EQ(text(within_one(a)), "fmin(fmax(a, 0.0), 1.0)");
  EXPECT_EQ(text(within_one(a), Language::kMatlab), "min(max(a, 0), 1)");
  EXPECT_EQ(text(magnitude(a)), "fabs(a)");
  EXPECT_EQ(text(magnitude(a), Language::kMatlab), "abs(a)");
}

TEST(FormulaText, WritesNumbersToTheLastBit) {
  for (const double value : {0.1, 1.0 / 3.0, 6.02214076e23, -3e-300})
    for (const Language language : {Language::kC, Language::kMatlab})
      EXPECT_EQ(std::stod(number_text(value, language)), value);
  EXPECT_EQ(number_text(2.0, Language::kC), "2.0");  // 1 / 2 would be 0 there
  EXPECT_EQ(number_text(-std::numeric_limits<double>::infinity(), Language::kMatlab), "-Inf");
}

}  // namespace
}  // namespace armukf
