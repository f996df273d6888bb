#pragma once
// SPDX-License-Identifier: MIT
//
// The Taylor series of written-out energies, planned while compiling.
//
// The operations of T and V that are written out (mechanics/written_out.hpp) are a list that the compiler has. From it this header makes
// the graph of the motion, as integrate/steps/recorded_motion.hpp does of other energies at run time,
//
//     p = ∂L/∂q̇ ,   M = ∂p/∂q̇ ,   F = ∂L/∂q ,
//
// and the sweep over it; and it does so twice, with the same functions: while compiling, where parameters are shadows without
// values (ad/series/plan.hpp), and for each object, with its values. If both plans are equal, and they are unless a shadow
// coincides with something, the object's series is made by the code that the compiler wrote.
//
// Arguments of calls that make nodes are made before, one by one: compilers differ in the order of arguments, and the order of nodes
// must not.

#include <cstddef>
#include <type_traits>
#include <vector>

#include "qdot/ad/formula/constant_where_possible.hpp"
#include "qdot/ad/formula/list_graph.hpp"
#include "qdot/ad/series/plan.hpp"
#include "qdot/ad/series/planned_sweep.hpp"
#include "qdot/mechanics/written_out.hpp"

// What follows runs while compiling, and once more when a stepper is made.
#ifdef QDOT_COMPILED
namespace qdot::formula {
extern template class BasicGraph<taylor::Parameter>;
}  // namespace qdot::formula
namespace qdot::taylor {
extern template void Sweep::compile(BasicGraph<Parameter>&, const SweepOutputs&);
}  // namespace qdot::taylor
#endif

namespace qdot::detail {

/// The graph of Lagrange's equations; all but the graph are numbers of its nodes.
struct MotionGraph {
  formula::BasicGraph<taylor::Parameter> graph;
  std::vector<int> q, qdot, p, force;
  std::vector<int> mass;  // lower triangle, row by row
  int t = -1;
  bool has_series = true;  // false: an operation is not analytic, or not known here
};

// The node of an energy that consists of these operations. `parameters` may be null; shadows are counted from `first_shadow`.
template <class List, class Parameters>
constexpr int energy_node(MotionGraph& m, const List& list, const Parameters* parameters, int inputs, int first_shadow) {
  return formula::node_of_list(m.graph, list, inputs, m.has_series, [&](int k) -> taylor::Parameter {
    if (list.literal[k]) return list.value[k];
    const double shadow = formula::shadow_of(first_shadow + list.same_as[k]);
    return {shadow, parameters == nullptr ? shadow : (*parameters)[static_cast<std::size_t>(k)]};
  });
}

/// Makes the graph of written-out energies: of an object, or of all of them when `energies` is null.
template <int n, class W>
constexpr void make_motion_graph(MotionGraph& m, const W* energies) {
  constexpr int inputs = 2 * n + 1, shadows_of_V = 10000;
  for (int i = 0; i < n; ++i) m.q.push_back(m.graph.variable(i));
  for (int i = 0; i < n; ++i) m.qdot.push_back(m.graph.variable(n + i));
  m.t = m.graph.variable(2 * n);
  const int T = energy_node(m, W::operations_of_T(), energies == nullptr ? nullptr : &energies->parameters_of_T(), inputs, 0);
  const int V = energy_node(m, W::operations_of_V(), energies == nullptr ? nullptr : &energies->parameters_of_V(), inputs, shadows_of_V);
  m.p = m.graph.gradient(T, m.qdot);
  m.force = m.graph.gradient(m.graph.difference(T, V), m.q);
  for (std::size_t i = 0; i < m.p.size(); ++i) {
    const std::vector<int> row = m.graph.gradient(m.p[i], m.qdot);
    for (std::size_t j = 0; j <= i; ++j) m.mass.push_back(row[j]);
  }
}

/// The sweep over it.
constexpr taylor::Sweep sweep_over(MotionGraph& m, int highest_order) {
  taylor::SweepOutputs outputs;
  outputs.early = m.p;
  outputs.series = m.force;
  outputs.values = m.mass;
  outputs.late = m.qdot;
  for (const int node : m.q) outputs.series.push_back(node);
  outputs.series.push_back(m.t);
  return taylor::Sweep(m.graph, outputs, highest_order);
}

/// What must be known to write the orders of a motion's series as code; slots of the sweep.
template <int n>
struct MotionPlan {
  taylor::SweepPlan sweep;
  int q[n] = {}, qdot[n] = {}, p[n] = {}, force[n] = {}, t = 0;
  bool exists = false;

  MotionPlan() = default;
  constexpr MotionPlan(const MotionGraph& m, const taylor::Sweep& s) : sweep(s), t(s.slot(m.t)), exists(m.has_series && sweep.fits()) {
    for (int i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      q[i] = s.slot(m.q[k]);
      qdot[i] = s.slot(m.qdot[k]);
      p[i] = s.slot(m.p[k]);
      force[i] = s.slot(m.force[k]);
    }
  }
  friend constexpr bool operator==(const MotionPlan&, const MotionPlan&) = default;
};

template <int n, class W>
constexpr MotionPlan<n> plan_of_energies() {
  MotionGraph m;
  make_motion_graph<n, W>(m, nullptr);
  if (!m.has_series) return {};
  const taylor::Sweep sweep = sweep_over(m, 1);
  return {m, sweep};
}

/// The plan of all objects of the written-out energies W; empty where there is none, or where the compiler cannot make it: one that takes
/// no function of <cmath> for constant expressions may stop at a power of a constant.
template <int n, class W>
inline constexpr MotionPlan<n> motion_plan = formula::made_where_possible<&plan_of_energies<n, W>>;

template <int n, class W>
struct PlannedMotion {
  static constexpr const taylor::SweepPlan& plan = motion_plan<n, W>.sweep;
};

/// Makes orders 2 to `order` of the series of a motion whose order 1 is complete.
///
/// @param coefficients  columns [q; q̇], one for each order
/// @param M             the factors of the mass matrix
template <int n, class W, class MassFactors>
[[gnu::noinline]] void expand_by_plan(taylor::Sweep& s, double time_unit, int order, double* coefficients, const MassFactors& M) {
  constexpr const MotionPlan<n>& motion = motion_plan<n, W>;
  taylor::PlannedSweep<PlannedMotion<n, W>> sweep(s);
  for (int k = 2; k <= order; ++k) {
    const double factor = time_unit / k;
    const double* const before = coefficients + 2 * n * (k - 1);
    double* const now = coefficients + 2 * n * k;
    Vector<double, n> b;
    double* const rates = b.data();
    // All rates before any variable is set: a rate may be a variable (V = q₀ q₁).
    unroll<n>([&](auto i) __attribute__((always_inline)) { rates[i] = factor * sweep.latest(motion.force[i]); });
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      sweep.latest(motion.q[i]) = now[i] = factor * before[n + i];
      sweep.latest(motion.qdot[i]) = 0.0;
    });
    sweep.latest(motion.t) = 0.0;
    sweep.advance(k);
    unroll<n>([&](auto i) __attribute__((always_inline)) { rates[i] -= sweep.latest(motion.p[i]); });
    M.solve_mass(rates);
    unroll<n>([&](auto i) __attribute__((always_inline)) { sweep.latest(motion.qdot[i]) = now[n + i] = rates[i]; });
    sweep.complete(k);
  }
}

}  // namespace qdot::detail
