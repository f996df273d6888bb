#pragma once
// SPDX-License-Identifier: MIT
//
// The rows of `qdot bench scenes`: q̈ of a scene with its effects, and λ where there are constraints, beside the same as an expert
// writes it. A unit that has rows declares one function here that returns them, and scenes.cpp lists that function.

#include <algorithm>
#include <string>
#include <vector>

#include "bench/eom.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/effects/scene_motion.hpp"

namespace qdot::bench {

struct SceneRow {
  EquationsRow evaluation;
  int constraints;
  std::string effect;
};

std::vector<SceneRow> system_scene_rows();             // scenes_systems.cpp
std::vector<SceneRow> body_scene_rows();               // scenes_bodies.cpp
std::vector<SceneRow> unrolled_chain_scene_rows();     // scenes_unrolled_chains.cpp
std::vector<SceneRow> looped_chain_scene_rows();       // scenes_looped_chains.cpp
std::vector<SceneRow> placed_chain_scene_rows();       // scenes_placed_chains.cpp
std::vector<SceneRow> hanging_chain_scene_rows();      // scenes_hanging_chains.cpp
std::vector<SceneRow> jacobian_scene_rows();           // scenes_jacobians.cpp

/// The states of the effects of a case (measured_scenes.hpp).
template <class Case>
auto states_of_case() {
  if constexpr (requires { Case::states(); }) {
    return Case::states();
  } else {
    return EffectStates<decltype(Case::scene())>();
  }
}

/// Objects whose parameters are read when they are evaluated, like a user's.
template <class Case>
inline const auto benched_scene = Case::scene();
template <class Case>
inline const auto benched_states = states_of_case<Case>();
template <class Hand>
inline Hand benched_hand{};  // not const, for the same reason

/// q̈ and λ of a case as an expert writes them.
template <class Hand>
[[gnu::noinline]] void by_hand_of_scene(const double* q, const double* qdot, double* out) {
  benched_hand<Hand>(q, qdot, out);
}

/// q̈ of a case, followed by λ where it has constraints; of its unit alone, for what g++ inlines depends on what else there is in a unit.
template <class Case>
[[gnu::noinline]] static void by_scene(const double* q, const double* qdot, double* out) {
  constexpr int n = Case::n, m = Case::constraints;
  using V = Vector<double, n>;
  const V x(Eigen::Map<const V>{q}), v(Eigen::Map<const V>{qdot});
  if constexpr (m == 0) {
    Eigen::Map<V>{out} = acceleration(benched_scene<Case>, x, v, 0.0, benched_states<Case>);
  } else {
    const auto solution = constrained_acceleration(benched_scene<Case>, x, v, 0.0, benched_states<Case>);
    Eigen::Map<V>{out} = solution.qddot;
    Eigen::Map<Vector<double, m>>{out + n} = solution.lambda;
  }
}

/// q̈ alone of a case, by the form that a run has of it, and as an expert writes it.
template <class Case>
[[gnu::noinline]] static void by_scene_in_a_run(const double* q, const double* qdot, double* out) {
  constexpr int n = Case::n;
  static const auto form = as_in_a_run(first_order_form(Case::scene()));
  const auto& z = benched_states<Case>;
  constexpr int states = EffectStates<decltype(Case::scene())>::SizeAtCompileTime;
  double y[2 * n + states], ydot[2 * n + states];
  write_state<n>(y, q, qdot);
  std::copy_n(z.data(), states, y + 2 * n);
  form.write_derivative(0.0, y, ydot);
  std::copy_n(ydot + n, n, out);
}
template <class Case>
[[gnu::noinline]] void by_hand_without_multipliers(const double* q, const double* qdot, double* out) {
  double all[Case::n + Case::constraints];
  benched_hand<typename Case::Hand>(q, qdot, all);
  std::copy_n(all, Case::n, out);
}

/// A case beside another function than its hand-derived one.
template <class Case>
SceneRow row_beside(AccelerationFunction baseline, const char* baseline_name) {
  return {.evaluation = {.system = Case::name,
                         .n = Case::n,
                         .door = "",
                         .baseline = baseline,
                         .measured = by_scene<Case>,
                         .lowest = Case::lowest,
                         .highest = Case::highest,
                         .baseline_name = baseline_name,
                         .numbers_out = Case::n + Case::constraints},
          .constraints = Case::constraints,
          .effect = Case::effect};
}

/// Cases beside what an expert writes.
template <class... Case>
std::vector<SceneRow> rows_of_cases() {
  return {row_beside<Case>(by_hand_of_scene<typename Case::Hand>, "hand-derived")...};
}

/// Cases as a run has them, q̈ alone, beside what an expert writes.
template <class... Case>
std::vector<SceneRow> rows_in_a_run() {
  const auto row = [](SceneRow r, AccelerationFunction by_hand, AccelerationFunction in_a_run) {
    r.evaluation.system += ", in a run";
    r.evaluation.baseline = by_hand;
    r.evaluation.measured = in_a_run;
    r.evaluation.numbers_out = r.evaluation.n;
    return r;
  };
  return {row(row_beside<Case>(nullptr, "hand-derived"), by_hand_without_multipliers<Case>, by_scene_in_a_run<Case>)...};
}

}  // namespace qdot::bench
