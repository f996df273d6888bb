#pragma once
// SPDX-License-Identifier: MIT
//
// What stands in front of a run whose derivatives are asked for: y and Φ at its start, and its events as functions and changes without their types.
//
// A start that depends on a parameter, y₀(p) at t₀(p), gives ∂y/∂p = ∂y₀/∂p − f ∂t₀/∂p at the fixed time t₀. Phases of contacts and friction follow
// from the state, and Φ is put onto the constraints.

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <functional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "qdot/analysis/variations/variational_form.hpp"
#include "qdot/analysis/variations/variations.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/driver/consistent_start.hpp"
#include "qdot/integrate/event.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/integrate/runge_kutta.hpp"

namespace qdot::detail {

template <class M>
inline constexpr bool is_explicit_method = false;
template <>
inline constexpr bool is_explicit_method<Dop853> = true;
template <>
inline constexpr bool is_explicit_method<Dopri5> = true;

template <class Model>
inline constexpr Changes changes_of = SwitchingSystem<typename Model::Form>     ? Changes::phases
                                      : ProjectableSystem<typename Model::Form> ? Changes::projections
                                                                                : Changes::none;

// The function of an event, and its change, on [y; columns of Φ].
struct ErasedFunction {
  const VariationalEquations* equations;
  std::function<double(double, const Eigen::VectorXd&, Eigen::Index, double)> h;

  double operator()(const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const double& t) const {
    if (equations->dof() == 0) return h(t, q.head(equations->state_size()), -1, 0.0);
    Eigen::VectorXd y(2 * q.size());
    y << q, qdot;
    return h(t, y, -1, 0.0);
  }
};
template <bool barrier>
struct ErasedChange {
  static constexpr bool is_barrier = barrier;
  VariationalEquations* equations;
  std::string name;
  Surface surface;

  void operator()(double t, Eigen::VectorXd& both) const { equations->pass(name, t, both, surface); }
};

template <class G, class Action>
auto erased_event(const Event<G, Action>& event, VariationalEquations& changes, Surface surface) {
  using E = Event<G, Action>;
  static_assert(
      !E::is_timed,
      "qdot: a motion that every() changes is not differentiated; give the times as an event of t, or leave every() out where it only records");
  const auto with_function = [&](auto g) {
    if constexpr (E::stops || E::records) return Event<decltype(g), Action>{event.name, std::move(g), event.direction, {}};
    else
      return Event<decltype(g), ErasedChange<E::is_barrier>>{event.name, std::move(g), event.direction, {&changes, event.name, std::move(surface)}};
  };
  if constexpr (E::is_formula) return with_function(event.g);
  else return with_function(ErasedFunction{&changes, surface.h});
}

struct NamedSurface {
  std::string name;
  Surface surface;
  bool stops;
};

// Events of a model, with `changes` to make what they change.
template <class List, class Model>
auto erased_events(const List& list, const Variations<Model>& equations, VariationalEquations& changes) {
  return [&]<std::size_t... i>(std::index_sequence<i...>) {
    return events(erased_event(std::get<i>(list.list), changes, equations.template surface<i>())...);
  }(std::make_index_sequence<Model::event_count>{});
}

template <class List, class Model>
std::vector<NamedSurface> surfaces_of(const List& list, const Variations<Model>& equations) {
  std::vector<NamedSurface> surfaces;
  [&]<std::size_t... i>(std::index_sequence<i...>) {
    (surfaces.push_back({std::get<i>(list.list).name, equations.template surface<i>(), std::get<i>(list.list).stops}), ...);
  }(std::make_index_sequence<Model::event_count>{});
  for (Eigen::Index k = 0; k < equations.guard_count(); ++k)
    if (const std::string name = equations.ending(k); !name.empty()) surfaces.push_back({name, equations.guard_surface(k), true});
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (surfaces[i].name == surfaces[k].name)
        throw_invalid_value({"events must have names of their own where their times are differentiated, but two are called '",
                             surfaces[i].name, "'; rename one"});
  return surfaces;
}

// ∂[y₀; t₀]/∂p_j of starts that do not depend on parameters, and of those that do; empty for zero.
struct FixedStart {
  template <class Model>
  Eigen::VectorXd operator()(const Model&, Eigen::Index) const {
    return {};
  }
};
struct SlopeOfFamilyStart {
  template <class Model>
  Eigen::VectorXd operator()(const Model& of, Eigen::Index j) const {
    const auto begins = [&](double s) {
      const auto nearby = of.member(j, s);
      const Eigen::VectorXd y = packed(first_order_form(nearby.system), nearby.start);
      Eigen::VectorXd both(y.size() + 1);
      both << y, nearby.start.t;
      return both;
    };
    const auto slope = slope_at_zero(begins, std::ldexp(parameter_step(of.parameter(j)), 8));
    if (!slope) throw_invalid_value({"the start of a family must have a derivative with respect to parameter ", j, "; let it depend smoothly on it"});
    return *slope;
  }
};

template <class = void>  // compiled only where it is called
Eigen::VectorXd each_atol(const Options& options, Eigen::Index size) {
  return Eigen::VectorXd::NullaryExpr(size, [&](Eigen::Index i) { return options.atol[i]; });
}

// [y; Φ] where a run begins, after what is wrong with the start has been said.
template <class Model, class Start, class StartSlope>
Eigen::VectorXd begun(Variations<Model>& equations, const Start& start, const Options& options, const StartSlope& slope_of_start) {
  using Form = typename Model::Form;
  const Eigen::Index size = equations.state_size(), columns = equations.columns();
  const Eigen::VectorXd y0 = packed(equations.form(), start);
  if (y0.size() != size)
    throw DimensionError("y", static_cast<long>(size), static_cast<long>(y0.size()), "pass one entry for each component of the system");
  for (Eigen::Index i = 0; i < size; ++i)
    if (!std::isfinite(y0[i]))
      throw_invalid_value({equations.state_name(i), " must be finite at the start, but is ", y0[i], "; give it a number"});
  if constexpr (requires { require_existing_entries(equations.form().system(), y0.data(), start.t); })
    require_existing_entries(equations.form().system(), y0.data(), start.t);
  else if constexpr (requires { require_existing_entries(equations.form().scene().system(), y0.data(), start.t); })
    require_existing_entries(equations.form().scene().system(), y0.data(), start.t);
  equations.rtol = options.rtol;
  equations.began = start.t;
  equations.atol = each_atol(options, size);
  Eigen::VectorXd both = Eigen::VectorXd::Zero(equations.size()), settled = y0;
  if constexpr (SwitchingSystem<Form>) {
    equations.form().switched(start.t, settled, std::vector<bool>(static_cast<std::size_t>(equations.form().guard_count())), equations.resolution(y0));
    settled.head(2 * equations.dof()) = y0.head(2 * equations.dof());
  }
  Eigen::VectorXd projected;
  if constexpr (ProjectableSystem<Form>) require_consistent(equations.form(), start.t, settled, projected);
  both.head(size) = settled;
  Eigen::Map<Eigen::MatrixXd> Phi(both.data() + size, size, columns);
  const Eigen::VectorXd f = equations.state_rate(start.t, settled);
  for (Eigen::Index j = 0; j < equations.start_columns(); ++j) Phi(equations.start_entries()[static_cast<std::size_t>(j)], j) = 1.0;
  if (equations.time_columns() > 0) Phi.col(equations.start_columns()) = -f;
  for (Eigen::Index j = columns - equations.model().parameters(), p = 0; j < columns; ++j, ++p) {
    const Eigen::VectorXd slope = slope_of_start(equations.model(), p);
    if (slope.size() > 0) Phi.col(j) = slope.head(size) - f * slope[size];
  }
  if constexpr (changes_of<Model> != Changes::none) equations.project(start.t, both);
  both.head(2 * equations.dof()) = y0.head(2 * equations.dof());
  return both;
}

}  // namespace qdot::detail
