#pragma once
// SPDX-License-Identifier: MIT
//
// Energies with plain loops at the speed of energies without.
//
//     struct Chain {
//       double m = 1.0, l = 1.0, g = 9.81;
//       constexpr auto T(const auto& q, const auto& qdot) const { … for (int k = 0; k < q.size(); ++k) … }
//       constexpr auto V(const auto& q) const { … }
//     };
//     const auto system = mechanical_system<4>(written_out<4>(Chain{.m = 0.3}));
//
// The compiler runs T and V, which must be constexpr for that (generic lambdas are so by themselves), and lists their operations
// (ad/formula/trace.hpp). From the list it derives the equations of motion, with letters for the parameters, and writes them as code without a loop
// (mechanics/derive/closed_form.hpp): that is q̈, and up to 8 coordinates M, r and the derivatives of q̈
// (mechanics/derive/closed_form_jacobian.hpp). Where T is not a quadratic form or a function has no derivative, and for Jacobians of up to
// 4 coordinates, the scalars of Lagrange's equations go through the list one by one (mechanics/equations/straight_line.hpp). Parameters
// stay what the object has. All other scalars call the user's functors, as ever.
//
// What T and V may do is what a list can hold: entries of q and q̇, size(), dot(), squaredNorm(), norm(), sum(), arithmetic and the functions
// of <cmath>; no other functions of Eigen, and no branch on q, q̇ or t. They may branch on their parameters. An object
// whose parameters lead elsewhere than those that the compiler tried is evaluated by the general way: right, but ten times as slow or more.
// The compiler tries the default values of a class that has them, and numbers below one for the captures of a lambda. Parameters are read when
// the object is made, so they must be numbers in it and not behind a pointer.

#include <array>
#include <cstddef>
#include <type_traits>
#include <utility>

#include "qdot/mechanics/derive/closed_form_evaluation.hpp"
#include "qdot/mechanics/derive/closed_form_jacobian.hpp"
#include "qdot/mechanics/derive/traced_energies.hpp"
#include "qdot/mechanics/equations/straight_line.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot {

namespace detail {

// Largest n: code grows with n², and the compiler takes some 20 s for a chain of 32.
inline constexpr int written_out_limit = 32;

// The English of what keeps an energy from being written out.
template <int n, class E>
consteval bool require_written_out() {
  static_assert(n >= 1 && n <= written_out_limit,
                "qdot: written_out is for up to 32 coordinates; with more of them plain loops are evaluated as they are: leave written_out away");
  if constexpr (n >= 1 && n <= written_out_limit) {
    static_assert(Example<E>::exists,
                  "qdot: written_out runs T and V while compiling and needs an object for that: give each parameter of your class a default "
                  "value (double m = 1.0;), or use lambdas that capture nothing but doubles, by value");
    if constexpr (Example<E>::exists) {
      static_assert(HoldsItsParameters<E>,
                    "qdot: written_out reads the parameters of T and V once, so they must be numbers in the object itself and not behind a "
                    "pointer or a reference, where they may change unseen: leave written_out away for such a class");
      static_assert(RunsWhileCompiling<n, Energy::T, E, 0>,
                    "qdot: written_out cannot run the kinetic energy T while compiling: mark T constexpr, or the functor that places point "
                    "masses and planar bodies, and use no function that is not constexpr (the cosine of a plain number is none: store its "
                    "value) and no vector of Eigen in it");
      static_assert(RunsWhileCompiling<n, Energy::V, E, 0>,
                    "qdot: written_out cannot run the potential energy V while compiling: mark V constexpr, and use no function that is not "
                    "constexpr (the cosine of a plain number is none: store its value) and no vector of Eigen in it");
      if constexpr (RunsWhileCompiling<n, Energy::T, E, 0> && RunsWhileCompiling<n, Energy::V, E, 0>) {
        constexpr ExtentOfRun T = extent_of_run<n, Energy::T, E, 0>(), V = extent_of_run<n, Energy::V, E, 0>();
        static_assert(!T.branches && !V.branches,
                      "qdot: T or V branches on q, qdot or t, and a list of operations holds for one side of a branch only: use abs, max or "
                      "min, or leave written_out away");
        static_assert(!T.too_long && !V.too_long,
                      "qdot: T or V has more than 2000 operations, too many to be written out: leave written_out away");
      }
    }
  }
  return true;
}

// The scalars that are worth a list: those whose zeros the compiler must see.
template <class S>
inline constexpr bool wants_straight_line = false;
template <int n, class Number, class Is, class K>
inline constexpr bool wants_straight_line<EulerLagrange<n, Number, Is, K>> = true;

// a where `first`, otherwise b, with the zeros that both have.
template <int n, class Number, int... Is, int... K>
[[gnu::always_inline]] inline auto either(bool first, const EulerLagrange<n, Number, std::integer_sequence<int, Is...>, std::integer_sequence<int, K...>>& x,
                                          const EulerLagrange<n, Number, std::integer_sequence<int, Is...>, std::integer_sequence<int, K...>>& y) {
  const auto a = x.whole(), b = y.whole();
  auto r = a;
  const auto choose = [first](const Number& of_a, const Number& of_b) __attribute__((always_inline)) { return first ? of_a : of_b; };
  r.value = choose(a.value, b.value);
  r.rate = choose(a.rate, b.rate);
  r.has_rate = a.has_rate | b.has_rate;
  r.g_mask = a.g_mask | b.g_mask;
  r.x_mask = a.x_mask | b.x_mask;
  r.h_mask = a.h_mask | b.h_mask;
  ((r.template g<Is>() = choose(a.template g<Is>(), b.template g<Is>())), ...);
  ((r.template x<Is>() = choose(a.template x<Is>(), b.template x<Is>())), ...);
  ((r.template h<K>() = choose(a.template h<K>(), b.template h<K>())), ...);
  return r;
}

// One step on scalars and constants.
template <trace::Operation o, class S, class A, class B>
[[gnu::always_inline]] inline S step_of(const A& a, const B& b) {
  if constexpr (o == trace::Operation::max || o == trace::Operation::min) {
    const S x(a), y(b);
    if constexpr (std::is_same_v<decltype(x < y), bool>) {
      return either(o == trace::Operation::max ? !(x < y) : !(y < x), x, y);
    } else if constexpr (o == trace::Operation::max) {  // of packs
      return max(x, y);
    } else {
      return min(x, y);
    }
  } else {
    return trace::applied<o>(a, b);
  }
}

[[noreturn, gnu::cold, gnu::noinline]] inline void throw_list_of_another() {
  throw_invalid_value({"a written-out energy was called with the scalar of Lagrange's equations, but its parameters lead to other operations than those "
                       "that were written out; forward replays() in the class that wraps it, or leave written_out away"});
}

template <int n, class E>
consteval bool can_be_written_out() {
  if constexpr (n >= 1 && n <= written_out_limit && Example<E>::exists && HoldsItsParameters<E>) {
    if constexpr (RunsWhileCompiling<n, Energy::T, E, 0> && RunsWhileCompiling<n, Energy::V, E, 0>) {
      constexpr ExtentOfRun T = extent_of_run<n, Energy::T, E, 0>(), V = extent_of_run<n, Energy::V, E, 0>();
      return !T.branches && !V.branches && !T.too_long && !V.too_long;
    }
  }
  return false;
}

}  // namespace detail

/// Energies that written_out<n>() takes: for code that is written for any.
template <class E, int n>
concept CanBeWrittenOut = detail::can_be_written_out<n, E>();

/// T and V of E, gone through as a list of operations where that is faster; made by written_out().
template <int n, class E>
class WrittenOut {
  static constexpr KineticSignature kinetic = detail::kinetic_signature<E, n>();
  static constexpr PotentialSignature potential = detail::potential_signature<E, n>();
  static constexpr auto list_T = detail::list_of_operations<n, detail::Energy::T, E>();
  static constexpr auto list_V = detail::list_of_operations<n, detail::Energy::V, E>();

 public:
  /// Their equations, derived by the compiler; `exists` is false where it can't.
  using ClosedForm = detail::ClosedFormOfLists<n, list_T, list_V>;
  using ClosedJacobian = detail::ClosedJacobianOf<n, typename ClosedForm::Energies>;  ///< Their derivatives, in the same way.

  WrittenOut()
    requires std::is_default_constructible_v<E>
      : WrittenOut(E{}) {}
  explicit WrittenOut(E energies) : energies_(std::move(energies)) {
    replays_ = parameters_read<detail::Energy::T>(list_T, parameters_T_) && parameters_read<detail::Energy::V>(list_V, parameters_V_);
    if constexpr (ClosedForm::exists) has_closed_form_ = replays_ && detail::coefficients_written<ClosedForm>(parameters_T_, parameters_V_, coefficients_);
    if constexpr (ClosedJacobian::exists) detail::write_values<ClosedJacobian>(parameters_T_, parameters_V_, coefficients_of_jacobian_);
  }

  /// T and V as they were given.
  const E& energies() const noexcept { return energies_; }

  /// The list of T, for those who make something else of them (integrate/steps/motion_plan.hpp).
  static constexpr const auto& operations_of_T() { return list_T; }
  /// The same of V.
  static constexpr const auto& operations_of_V() { return list_V; }
  /// Numbers that T reads of this object, in the order of its list.
  const auto& parameters_of_T() const noexcept { return parameters_T_; }
  /// The same of V.
  const auto& parameters_of_V() const noexcept { return parameters_V_; }

  /// False when the parameters lead to other operations than the compiler met; the evaluation then goes the general way.
  bool replays() const noexcept { return replays_; }

  /// False when the derived equations are not this object's, or need a mass that is not positive.
  bool has_closed_form() const noexcept { return has_closed_form_; }
  /// Numbers of this object that the derived equations read.
  const double* closed_form_coefficients() const noexcept { return coefficients_.data(); }

  /// q̈ by the derived equations; false where they are not the way.
  [[gnu::always_inline]] bool acceleration_in_closed_form(const double* q, const double* qdot, double t, double* qddot) const
    requires(ClosedForm::exists)
  {
    return detail::closed_form_acceleration<n>(*this, q, qdot, t, qddot);
  }
  /// With forces that are found where they are needed: forces(q, qdot, Q) writes them.
  template <class Forces>
  [[gnu::always_inline]] bool acceleration_in_closed_form_with(const Forces& forces, const double* q, const double* qdot, double t, double* qddot) const
    requires(ClosedForm::exists)
  {
    return detail::closed_form_acceleration<n>(*this, q, qdot, t, qddot, forces);
  }
  /// The same with its derivatives, by columns.
  bool jacobian_in_closed_form(const double* q, const double* qdot, double t, double* qddot, double* d_q, double* d_qdot) const
    requires(ClosedJacobian::exists)
  {
    return replays_ && detail::closed_form_jacobian<n, ClosedJacobian>(coefficients_of_jacobian_.data(), q, qdot, t, qddot, d_q, d_qdot);
  }
  /// M and r, handed to `use` (mechanics/derive/closed_form_jacobian.hpp); false where this is not the way.
  template <class Use>
  [[gnu::always_inline]] bool equations_in_closed_form(const detail::AtState& at, const Use& use) const
    requires(ClosedJacobian::exists)
  {
    return replays_ && detail::closed_form_equations<n, ClosedJacobian>(coefficients_of_jacobian_.data(), at, use);
  }
  /// M and the derivatives of r − M a.
  template <class Row>
  [[gnu::noinline]] bool slopes(const double* q, const double* qdot, const double* a, double t, double* M, Row* rows) const
    requires(ClosedJacobian::exists)
  {
    if (!replays_) return false;
    detail::closed_form_slopes<n, ClosedJacobian>(coefficients_of_jacobian_.data(), q, qdot, t, a, M, rows);
    return true;
  }
  /// q̈, where has_closed_form() is true.
  template <class Number, class Forces = detail::NoForces>
  [[gnu::always_inline]] auto accelerations_in_closed_form(const Number* q, const Number* qdot, const Number& t, Number* qddot,
                                                           const Forces& forces = {}) const {
    return detail::closed_form_of_acceleration<n, ClosedForm>(coefficients_.data(), q, qdot, t, forces, qddot);
  }

  /// T as a list of operations, or as it was given where that is faster or the only way.
  template <class Qdot>
    requires(kinetic == KineticSignature::velocity)
  [[gnu::always_inline]] auto T(const Qdot& qdot) const {
    using S = typename Qdot::Scalar;
    if constexpr (goes_by_list<Qdot>()) {
      return replayed<S, list_T>(parameters_T_, qdot, qdot, S(0.0));
    } else {
      return energies_.T(qdot);
    }
  }
  template <class Q, class Qdot>
    requires(kinetic == KineticSignature::state)
  [[gnu::always_inline]] auto T(const Q& q, const Qdot& qdot) const {
    using S = typename Q::Scalar;
    if constexpr (goes_by_list<Q>()) {
      return replayed<S, list_T>(parameters_T_, q, qdot, S(0.0));
    } else {
      return energies_.T(q, qdot);
    }
  }
  template <class Q, class Qdot, class Time>
    requires(kinetic == KineticSignature::state_and_time)
  [[gnu::always_inline]] auto T(const Q& q, const Qdot& qdot, const Time& t) const {
    if constexpr (goes_by_list<Q>()) {
      return replayed<Time, list_T>(parameters_T_, q, qdot, t);
    } else {
      return energies_.T(q, qdot, t);
    }
  }
  /// V in the same way.
  template <class Q>
    requires(potential == PotentialSignature::position)
  [[gnu::always_inline]] auto V(const Q& q) const {
    using S = typename Q::Scalar;
    if constexpr (goes_by_list<Q>()) {
      return replayed<S, list_V>(parameters_V_, q, q, S(0.0));
    } else {
      return energies_.V(q);
    }
  }
  template <class Q, class Time>
    requires(potential == PotentialSignature::position_and_time)
  [[gnu::always_inline]] auto V(const Q& q, const Time& t) const {
    if constexpr (goes_by_list<Q>()) {
      return replayed<Time, list_V>(parameters_V_, q, q, t);
    } else {
      return energies_.V(q, t);
    }
  }

 private:
  template <class Q>
  static consteval bool goes_by_list() {
    static_assert(Q::RowsAtCompileTime == n || Q::RowsAtCompileTime == Dynamic,
                  "qdot: written_out<n> and mechanical_system<n> need the same number of coordinates");
    return n <= detail::straight_line_limit && detail::wants_straight_line<typename Q::Scalar> && Q::RowsAtCompileTime == n;
  }

  // False when this object does not do what the list says.
  template <detail::Energy energy, class List, std::size_t count>
  bool parameters_read(const List& list, std::array<double, count>& parameters) const {
    trace::Recording run;
    detail::record<n, energy>(energies_, run);
    if (!list.describes(run)) return false;
    for (int k = 0; k < run.constants; ++k) parameters[static_cast<std::size_t>(k)] = run.constant[k];
    return true;
  }

  template <class S, const auto& list, class Parameters, class Q, class Qdot>
  [[gnu::always_inline]] S replayed(const Parameters& parameters, const Q& q, const Qdot& qdot, const S& t) const {
    if (!replays_) detail::throw_list_of_another();
    constexpr int inputs = 2 * n + 1;
    S x[list.count + 1];
    const auto operand = [&](auto index) __attribute__((always_inline)) -> decltype(auto) {
      constexpr int i = index;
      if constexpr (i < 0) {
        if constexpr (list.literal[-1 - i]) {
          return double(list.value[-1 - i]);
        } else {
          return double(parameters[-1 - i]);
        }
      } else if constexpr (i < n) {
        return (q[i]);
      } else if constexpr (i < 2 * n) {
        return (qdot[i - n]);
      } else if constexpr (i == 2 * n) {
        return (t);
      } else {
        return static_cast<const S&>(x[i - inputs]);
      }
    };
    unroll<list.count>([&](auto i) __attribute__((always_inline)) {
      constexpr trace::Step s = list.step[i];
      x[i] = detail::step_of<s.operation, S>(operand(std::integral_constant<int, s.a>{}), operand(std::integral_constant<int, s.b>{}));
    });
    return S(operand(std::integral_constant<int, list.result>{}));
  }

  template <class List>
  static constexpr std::size_t constants_of(const List&) { return sizeof(List::value) / sizeof(double); }

  E energies_;
  bool replays_ = false;
  bool has_closed_form_ = false;
  std::array<double, ClosedForm::coefficients + 1> coefficients_{};
  std::array<double, ClosedJacobian::coefficients + 1> coefficients_of_jacobian_{};
  std::array<double, constants_of(list_T)> parameters_T_{};
  std::array<double, constants_of(list_V)> parameters_V_{};
};

namespace detail {

template <int n, class E>
inline constexpr bool is_written_out<WrittenOut<n, E>> = true;

template <int n, class E>
auto written_out_of(E energies) {
  static_assert(require_energies<E, n>());
  static_assert(require_written_out<n, E>());
  static_assert(n <= straight_line_limit || WrittenOut<n, E>::ClosedForm::exists,
                "qdot: written_out of more than 8 coordinates takes sums, products, powers and functions of <cmath> that have derivatives, and clang "
                "takes it with -fconstexpr-steps=16777216 (CMake's target qdot::qdot says so): without these, leave written_out away");
  return WrittenOut<n, E>(std::move(energies));
}

}  // namespace detail

/// Energies whose plain loops cost nothing, for mechanical_system<n>(): an object with members T and V, or T alone.
///
/// T and V must be constexpr and take `const auto&`; see the head of this file. Up to 32 coordinates; compile time grows with the number of operations, to
/// 20 s for a chain of 32.
template <int n, class Energies>
auto written_out(Energies energies) {
  return detail::written_out_of<n>(detail::energies_object<n>(std::move(energies)));
}

/// The same of two functors.
template <int n, class Kinetic, class Potential>
auto written_out(Kinetic T, Potential V) {
  return detail::written_out_of<n>(KineticAndPotential<Kinetic, Potential>{std::move(T), std::move(V)});
}

}  // namespace qdot
