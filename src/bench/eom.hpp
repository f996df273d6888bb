#pragma once
// SPDX-License-Identifier: MIT
//
// The rows of `qdot bench eom`: q̈ by the library beside q̈ as an expert derives and writes it. A unit that has rows declares
// one function here that returns them, and eom.cpp lists that function.

#include <algorithm>
#include <string>
#include <vector>

#include "bench/bench.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot::bench {

/// A function that reads q, q̇ and writes q̈ (and, for Jacobians, what follows from it).
using AccelerationFunction = void (*)(const double* q, const double* qdot, double* out);

struct EquationsRow {
  std::string system;
  int n;
  std::string door;  // how the system was given to the library: "general, for", "general, unroll", "jacobian"
  AccelerationFunction baseline;
  AccelerationFunction measured;
  double lowest, highest;                     // of the coordinates; velocities lie in (−2, 2)
  std::string baseline_name{"hand-derived"};
  int states = 1;                             // evaluated by one call of `measured`, stored one after another
  int numbers_out = 0;                        // written by one call; 0: n for each state
  double (*middle)(int i) = nullptr;          // where given, added to coordinate i
};

/// The finding of a row, named after its system and `what`: the time for one state of both functions over the same states, 64 of them where n ≤ 64.
/// It is the least of many repeats in turn (timed.cpp).
Row timed(const EquationsRow& row, const std::string& what);

/// Rows of several kinds, one kind after the other.
inline std::vector<EquationsRow> joined(const std::vector<std::vector<EquationsRow>>& kinds) {
  std::vector<EquationsRow> all;
  for (const auto& rows : kinds) all.insert(all.end(), rows.begin(), rows.end());
  return all;
}

std::vector<EquationsRow> system_rows();           // eom_systems.cpp
std::vector<EquationsRow> unrolled_chain_rows();   // eom_unrolled_chains.cpp
std::vector<EquationsRow> looped_chain_rows();     // eom_looped_chains.cpp
std::vector<EquationsRow> kinematic_chain_rows();  // eom_kinematic_chains.cpp
std::vector<EquationsRow> jacobian_rows();         // eom_jacobians.cpp

/// An object whose parameters are read when it is evaluated, like a user's.
template <int n, class E>
inline const System<E, n> benched_system = mechanical_system<n>(E{});

/// A system as a run has it, which keeps the lines of its equations (mechanics/derive/kept_lines.hpp).
template <class Sys>
Sys in_a_run(Sys system) {
  qdot::detail::keep_lines(system, system);
  return system;
}

/// q̈ in a run that goes one way (mechanics/by.hpp).
template <int n, class E, By way>
inline const auto benched_way = in_a_run(mechanical_system<n>(E{}).by(way));
template <int n, class E, By way>
[[gnu::noinline]] void by_way(const double* q, const double* qdot, double* qddot) {
  using V = Vector<double, n>;
  Eigen::Map<V>{qddot} = acceleration(benched_way<n, E, way>, V(Eigen::Map<const V>(q)), V(Eigen::Map<const V>(qdot)));
}

/// A form as a run has it.
template <class Form>
Form as_in_a_run(Form form) {
  if constexpr (requires { form.renew(); }) form.renew();
  return form;
}

/// y ← [q; q̇] in pairs, as a stepper writes it: a load of a pair waits for two separate stores.
template <int n>
[[gnu::always_inline]] inline void write_state(double* y, const double* q, const double* qdot) {
  if constexpr (n > 8) {
    std::copy_n(qdot, n, std::copy_n(q, n, y));
  } else {
    double both[2 * n];  // in registers
    detail::unroll<n>([&](auto i) __attribute__((always_inline)) {
      both[i] = q[i];
      both[n + i] = qdot[i];
    });
    qdot::detail::write_in_pairs<2 * n>(y, both);
  }
}

/// q̈ in a run, by the form that a run has of a system.
template <int n, class Form>
void by_form(const Form& form, const double* q, const double* qdot, double* qddot) {
  double y[2 * n], ydot[2 * n];
  write_state<n>(y, q, qdot);
  form.write_derivative(0.0, y, ydot);
  std::copy_n(ydot + n, n, qddot);
}
template <int n, class E>
[[gnu::noinline]] void by_run(const double* q, const double* qdot, double* qddot) {
  static const auto form = as_in_a_run(first_order_form(mechanical_system<n>(E{})));
  by_form<n>(form, q, qdot, qddot);
}

/// q̈ from the energies E by the general door.
template <int n, class E>
[[gnu::noinline]] void by_general_door(const double* q, const double* qdot, double* qddot) {
  using V = Vector<double, n>;
  Eigen::Map<V>{qddot} = acceleration(benched_system<n, E>, V(Eigen::Map<const V>(q)), V(Eigen::Map<const V>(qdot)));
}

/// q̈ from a function object that is no library's.
template <class Hand>
[[gnu::noinline]] void by_hand(const double* q, const double* qdot, double* qddot) {
  static const Hand hand;
  hand(q, qdot, qddot);
}

}  // namespace qdot::bench
