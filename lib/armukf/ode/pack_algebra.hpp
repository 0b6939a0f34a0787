#pragma once

#include <array>

#include "armukf/core/dual.hpp"
#include "armukf/core/lanes.hpp"

namespace armukf {

/// Odeint's algebra over rows (std::array) of lanes, dual numbers or plain numbers. A stepper's
/// operations are linear, so they may be done register by register: one pass over the memory for
/// each, where an algebra over whole rows would write every intermediate sum.
struct PackAlgebra {
  // Odeint calls for_eachN with N states and the operation last.
  template <class A, class B, class Op>
  static void for_each2(A& a, B& b, Op op) {
    each(op, a, b);
  }
  template <class A, class B, class C, class Op>
  static void for_each3(A& a, B& b, C& c, Op op) {
    each(op, a, b, c);
  }
  template <class A, class B, class C, class D, class Op>
  static void for_each4(A& a, B& b, C& c, D& d, Op op) {
    each(op, a, b, c, d);
  }
  template <class A, class B, class C, class D, class E, class Op>
  static void for_each5(A& a, B& b, C& c, D& d, E& e, Op op) {
    each(op, a, b, c, d, e);
  }
  template <class A, class B, class C, class D, class E, class F, class Op>
  static void for_each6(A& a, B& b, C& c, D& d, E& e, F& f, Op op) {
    each(op, a, b, c, d, e, f);
  }
  template <class A, class B, class C, class D, class E, class F, class G, class Op>
  static void for_each7(A& a, B& b, C& c, D& d, E& e, F& f, G& g, Op op) {
    each(op, a, b, c, d, e, f, g);
  }
  template <class A, class B, class C, class D, class E, class F, class G, class H, class Op>
  static void for_each8(A& a, B& b, C& c, D& d, E& e, F& f, G& g, H& h, Op op) {
    each(op, a, b, c, d, e, f, g, h);
  }

 private:
  template <class Op, class Row, std::size_t N, class... Others>
  static void each(Op& op, std::array<Row, N>& first, Others&... others) {
    for (std::size_t i = 0; i < N; ++i) elements(op, first[i], others[i]...);
  }
  template <class Op, int L, class... Others>
  [[gnu::always_inline]] static void elements(Op& op, Lanes<L>& first, Others&... others) {
    for_each_index<Lanes<L>::kPacks>([&](int k) __attribute__((always_inline)) {
      op(first.packs[k], others.packs[k]...);
    });
  }
  template <class Op, int L, class... Others>
  [[gnu::always_inline]] static void elements(Op& op, Dual<L>& first, Others&... others) {
    op(first.value, others.value...);
    elements(op, first.gradient, others.gradient...);
  }
  template <class Op, class... Others>
  [[gnu::always_inline]] static void elements(Op& op, double& first, Others&... others) {
    op(first, others...);
  }
};

}  // namespace armukf
