#include "armukf/core/symbol.hpp"

#include <utility>

namespace armukf {

struct Symbol::Node {
  Kind kind;
  double value;
  std::string name;
  std::vector<Symbol> arguments;
};

namespace {

bool is_constant(const Symbol& x) { return x.kind() == Symbol::Kind::kConstant; }
bool is(const Symbol& x, double value) { return is_constant(x) && x.value() == value; }

Symbol call(const char* name, const Symbol& x) { return {Symbol::Kind::kCall, name, {x}}; }

}  // namespace

Symbol::Symbol(double value)
    : node_(std::make_shared<const Node>(Node{Kind::kConstant, value, {}, {}})) {}

Symbol::Symbol(Kind kind, std::string name, std::vector<Symbol> arguments)
    : node_(std::make_shared<const Node>(Node{kind, 0.0, std::move(name), std::move(arguments)})) {}

Symbol::Kind Symbol::kind() const { return node_->kind; }
double Symbol::value() const { return node_->value; }
const std::string& Symbol::name() const { return node_->name; }
const std::vector<Symbol>& Symbol::arguments() const { return node_->arguments; }

Symbol operator-(const Symbol& a) {
  if (is_constant(a)) return -a.value();
  if (a.kind() == Symbol::Kind::kNegative) return a.arguments()[0];
  return {Symbol::Kind::kNegative, "", {a}};
}

Symbol operator+(const Symbol& a, const Symbol& b) {
  if (is_constant(a) && is_constant(b)) return a.value() + b.value();
  if (is(a, 0.0)) return b;
  if (is(b, 0.0)) return a;
  if (b.kind() == Symbol::Kind::kNegative) return a - b.arguments()[0];
  return {Symbol::Kind::kSum, "", {a, b}};
}

Symbol operator-(const Symbol& a, const Symbol& b) {
  if (is_constant(a) && is_constant(b)) return a.value() - b.value();
  if (is(a, 0.0)) return -b;
  if (is(b, 0.0)) return a;
  return {Symbol::Kind::kDifference, "", {a, b}};
}

Symbol operator*(const Symbol& a, const Symbol& b) {
  if (is_constant(a) && is_constant(b)) return a.value() * b.value();
  if (is(a, 0.0) || is(b, 0.0)) return 0.0;
  if (is(a, 1.0)) return b;
  if (is(b, 1.0)) return a;
  return {Symbol::Kind::kProduct, "", {a, b}};
}

Symbol operator/(const Symbol& a, const Symbol& b) {
  if (is_constant(a) && is_constant(b)) return a.value() / b.value();
  if (is(a, 0.0)) return 0.0;
  if (is(b, 1.0)) return a;
  return {Symbol::Kind::kQuotient, "", {a, b}};
}

Symbol exp(const Symbol& x) { return call("exp", x); }
Symbol sqrt(const Symbol& x) { return call("sqrt", x); }
Symbol sin(const Symbol& x) { return call("sin", x); }
Symbol cos(const Symbol& x) { return call("cos", x); }
Symbol tanh(const Symbol& x) { return call("tanh", x); }
Symbol magnitude(const Symbol& x) { return call("abs", x); }

Symbol within_one(const Symbol& x) {
  return {Symbol::Kind::kLeast, "", {{Symbol::Kind::kGreatest, "", {x, 0.0}}, 1.0}};
}

Symbol where_negative(const Symbol& x, const Symbol& a, const Symbol& b) {
  return {Symbol::Kind::kWhereNegative, "", {x, a, b}};
}

Symbol since_first_sample(const Symbol& t) { return {Symbol::Kind::kGreatest, "", {t, 0.0}}; }

SechTanh<Symbol> sech_and_tanh(const Symbol& x, const Symbol& y) {
  return {1.0 / call("cosh", x), tanh(y)};
}

}  // namespace armukf
