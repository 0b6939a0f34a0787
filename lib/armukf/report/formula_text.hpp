#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "armukf/core/symbol.hpp"
#include "armukf/report/source_text.hpp"

namespace armukf {

/// A number as the language writes it, to its last bit.
std::string number_text(double value, Language language);

/// Formulas as lines of a language. What several of them hold in common gets a name, v1, v2, ...,
/// in a line of its own before them; the order of all operations stays what it was.
class FormulaText {
 public:
  FormulaText(const std::vector<Symbol>& formulas, Language language);

  /// The formulas, in their order.
  const std::vector<std::string>& formulas() const { return formulas_; }

  /// Names and formulas of what they have in common, in the order that they need.
  const std::vector<std::pair<std::string, std::string>>& common() const { return common_; }

  bool uses(const std::string& variable) const { return variables_.contains(variable); }

 private:
  /// A formula and how tightly its last operation binds.
  struct Written {
    std::string text;
    int rank;
  };

  void count(const Symbol& formula);
  Written written(const Symbol& formula);
  Written composed(const Symbol& formula);
  std::string operand(const Symbol& formula, int least_rank);
  Written binary(const Symbol& formula, const char* sign, int rank);
  std::string call(const Symbol& formula, const std::string& function);
  std::string choice(const Symbol& formula);

  Language language_;
  std::map<const void*, int> uses_;
  std::map<const void*, std::string> names_;
  std::vector<std::string> formulas_;
  std::vector<std::pair<std::string, std::string>> common_;
  std::set<std::string> variables_;
};

}  // namespace armukf
