#include "armukf/report/formula_text.hpp"

#include <fmt/format.h>

#include <cmath>

namespace armukf {
namespace {

using Kind = Symbol::Kind;

enum Rank { kSumRank, kProductRank, kNegativeRank, kAtomRank };

}  // namespace

std::string number_text(double value, Language language) {
  if (std::isinf(value)) {
    const std::string infinity = language == Language::kC ? "HUGE_VAL" : "Inf";
    return value < 0.0 ? "-" + infinity : infinity;
  }
  std::string text = fmt::format("{}", value);
  if (language == Language::kC && text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

FormulaText::FormulaText(const std::vector<Symbol>& formulas, Language language)
    : language_(language) {
  for (const Symbol& formula : formulas) count(formula);
  for (const Symbol& formula : formulas) formulas_.push_back(written(formula).text);
}

void FormulaText::count(const Symbol& formula) {
  if (++uses_[formula.identity()] > 1) return;
  for (const Symbol& argument : formula.arguments()) count(argument);
}

FormulaText::Written FormulaText::written(const Symbol& formula) {
  const auto named = names_.find(formula.identity());
  if (named != names_.end()) return {named->second, kAtomRank};
  Written result = composed(formula);
  if (uses_[formula.identity()] < 2 || formula.arguments().empty()) return result;
  std::string name = fmt::format("v{}", common_.size() + 1);
  common_.emplace_back(name, std::move(result.text));
  names_[formula.identity()] = name;
  return {name, kAtomRank};
}

FormulaText::Written FormulaText::composed(const Symbol& formula) {
  switch (formula.kind()) {
    case Kind::kConstant:
      return {number_text(formula.value(), language_),
              std::signbit(formula.value()) ? kNegativeRank : kAtomRank};
    case Kind::kVariable:
      variables_.insert(formula.name());
      return {formula.name(), kAtomRank};
    case Kind::kNegative:
      return {"-" + operand(formula.arguments()[0], kAtomRank), kNegativeRank};
    case Kind::kSum:
      return binary(formula, "+", kSumRank);
    case Kind::kDifference:
      return binary(formula, "-", kSumRank);
    case Kind::kProduct:
      return binary(formula, "*", kProductRank);
    case Kind::kQuotient:
      return binary(formula, "/", kProductRank);
    case Kind::kCall:
      return {call(formula, formula.name()), kAtomRank};
    case Kind::kLeast:
      return {call(formula, "min"), kAtomRank};
    case Kind::kGreatest:
      return {call(formula, "max"), kAtomRank};
    case Kind::kWhereNegative:
      return {choice(formula), kAtomRank};
  }
  return {};
}

std::string FormulaText::operand(const Symbol& formula, int least_rank) {
  const Written inner = written(formula);
  return inner.rank < least_rank ? fmt::format("({})", inner.text) : inner.text;
}

FormulaText::Written FormulaText::binary(const Symbol& formula, const char* sign, int rank) {
  const std::string left = operand(formula.arguments()[0], rank);
  const std::string right = operand(formula.arguments()[1], rank + 1);
  return {fmt::format("{} {} {}", left, sign, right), rank};
}

std::string FormulaText::call(const Symbol& formula, const std::string& function) {
  std::string arguments;
  for (const Symbol& argument : formula.arguments())
    arguments += (arguments.empty() ? "" : ", ") + written(argument).text;
  const bool of_doubles =
      language_ == Language::kC && (function == "abs" || function == "min" || function == "max");
  return fmt::format("{}{}({})", of_doubles ? "f" : "", function, arguments);
}

std::string FormulaText::choice(const Symbol& formula) {
  const std::string x = operand(formula.arguments()[0], kSumRank);
  const std::string a = operand(formula.arguments()[1], kNegativeRank);
  const std::string b = operand(formula.arguments()[2], kNegativeRank);
  if (language_ == Language::kC) return fmt::format("({} < 0.0 ? {} : {})", x, a, b);
  return fmt::format("(({0} < 0) * {1} + ({0} >= 0) * {2})", x, a, b);
}

}  // namespace armukf
