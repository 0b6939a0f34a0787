#pragma once

#include <memory>
#include <string>
#include <vector>

#include "armukf/core/elementary.hpp"

namespace armukf {

/// A number that is written down instead of worked out: the physics evaluated with it leaves the
/// formulas of its results, for languages that have none of our templates. Sums with 0 and products
/// with 0 or 1 are left out, and constants are folded.
class Symbol {
 public:
  enum class Kind {
    kConstant,  // value
    kVariable,  // name
    kNegative,  // of one argument
    kSum,       // of two, and so are the next three
    kDifference,
    kProduct,
    kQuotient,
    kCall,          // name, a function of one argument: exp, sqrt, sin, cos, tanh, cosh, abs
    kLeast,         // of two
    kGreatest,      // of two
    kWhereNegative  // x < 0 ? a : b of (x, a, b)
  };

  Symbol() : Symbol(0.0) {}
  Symbol(double value);  // NOLINT(google-explicit-constructor): numbers mix with symbols
  Symbol(Kind kind, std::string name, std::vector<Symbol> arguments);

  static Symbol variable(std::string name) { return {Kind::kVariable, std::move(name), {}}; }

  Kind kind() const;
  double value() const;
  const std::string& name() const;
  const std::vector<Symbol>& arguments() const;

  /// What tells this formula from others: copies have the same.
  const void* identity() const { return node_.get(); }

  Symbol& operator+=(const Symbol& other) { return *this = *this + other; }
  Symbol& operator-=(const Symbol& other) { return *this = *this - other; }

  friend Symbol operator-(const Symbol& a);
  friend Symbol operator+(const Symbol& a, const Symbol& b);
  friend Symbol operator-(const Symbol& a, const Symbol& b);
  friend Symbol operator*(const Symbol& a, const Symbol& b);
  friend Symbol operator/(const Symbol& a, const Symbol& b);

 private:
  struct Node;
  std::shared_ptr<const Node> node_;
};

Symbol exp(const Symbol& x);
Symbol sqrt(const Symbol& x);
Symbol sin(const Symbol& x);
Symbol cos(const Symbol& x);
Symbol tanh(const Symbol& x);
Symbol magnitude(const Symbol& x);
Symbol within_one(const Symbol& x);  // the nearest number from 0 to 1
Symbol where_negative(const Symbol& x, const Symbol& a, const Symbol& b);
Symbol since_first_sample(const Symbol& t);
SechTanh<Symbol> sech_and_tanh(const Symbol& x, const Symbol& y);

template <>
inline constexpr bool kPlain<Symbol> = true;

}  // namespace armukf
