#pragma once

#include <array>

#include "armukf/core/dual.hpp"
#include "armukf/core/lanes.hpp"

namespace armukf {

/// Odeint's algebra over rows (std::array) of lanes, dual numbers or plain numbers. A stepper's
/// operations are linear, so they may be done register by register: one pass over the memory for
/// each, where an algebra over whole rows would write every intermediate sum.
///
/// Count tells how many rows of a state there are, of which a model may use fewer than it has room
/// for: an int, or a std::integral_constant, with which the loops over them unroll.
template <class Count>
struct PackAlgebra {
  [[no_unique_address]] Count rows;

  // Odeint calls for_eachN with N states and the operation last.
  template <class A, class B, class Op>
  void for_each2(A& a, B& b, Op op) const {
    each(op, a, b);
  }
  template <class A, class B, class C, class Op>
  void for_each3(A& a, B& b, C& c, Op op) const {
    each(op, a, b, c);
  }
  template <class A, class B, class C, class D, class Op>
  void for_each4(A& a, B& b, C& c, D& d, Op op) const {
    each(op, a, b, c, d);
  }
  template <class A, class B, class C, class D, class E, class Op>
  void for_each5(A& a, B& b, C& c, D& d, E& e, Op op) const {
    each(op, a, b, c, d, e);
  }
  template <class A, class B, class C, class D, class E, class F, class Op>
  void for_each6(A& a, B& b, C& c, D& d, E& e, F& f, Op op) const {
    each(op, a, b, c, d, e, f);
  }
  template <class A, class B, class C, class D, class E, class F, class G, class Op>
  void for_each7(A& a, B& b, C& c, D& d, E& e, F& f, G& g, Op op) const {
    each(op, a, b, c, d, e, f, g);
  }
  template <class A, class B, class C, class D, class E, class F, class G, class H, class Op>
  void for_each8(A& a, B& b, C& c, D& d, E& e, F& f, G& g, H& h, Op op) const {
    each(op, a, b, c, d, e, f, g, h);
  }

 private:
  template <class Op, class Row, std::size_t N, class... Others>
  void each(Op& op, std::array<Row, N>& first, Others&... others) const {
    for (int i = 0; i < rows; ++i) elements(op, first[i], others[i]...);
  }
  template <class Op, int L, class... Others>
  [[gnu::always_inline]] static void elements(Op& op, Lanes<L>& first, Others&... others) {
    for_each_index<Lanes<L>::kPacks>([&](int k) __attribute__((always_inline)) {
      op(first.packs[k], others.packs[k]...);
    });
  }
  template <class Op, int L, class... Others>
  [[gnu::always_inline]] static void elements(Op& op, Singles<L>& first, Others&... others) {
    for_each_index<Singles<L>::kPacks>([&](int k) __attribute__((always_inline)) {
      op(first.packs[k], others.packs[k]...);
    });
  }
  template <class Op, int L, class Gradient, class... Others>
  [[gnu::always_inline]] static void elements(Op& op, Dual<L, Gradient>& first, Others&... others) {
    op(first.value, others.value...);
    elements(op, first.gradient, others.gradient...);
  }
  template <class Op, class... Others>
  [[gnu::always_inline]] static void elements(Op& op, double& first, Others&... others) {
    op(first, others...);
  }
};

}  // namespace armukf
