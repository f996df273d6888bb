#pragma once
// SPDX-License-Identifier: MIT
//
// The return map of a section and its derivative
// ==============================================
//
//     DP = Φ + f ∂t/∂x = (1 − f ∇gᵀ / (∇g·f + ∂g/∂t)) Φ        at the return
//
// P takes a point x of a surface g = 0 to where the motion from there passes it next (analysis/section.hpp). A neighbour
// passes it earlier or later by ∂t/∂x δ. Φ and ∂t/∂x come from one run with its derivatives (analysis/sensitivity.hpp),
// exact through impacts and friction. Where the motion only grazes the surface, ∇g·f ≈ 0, there is no DP.
//     const auto P = return_map(star, State<2>{0.0, {0.0, 0.1}, {0.4, 0.0}}, plane, 100.0);
//     P.derivative, P.derivative_in({1, 3})            2n × 2n in (q, q̇); of q₁ and q̇₁ alone
// DP is zero along f, and its image lies in the surface. So a map in 2n − 1 coordinates is enough for deviations on the
// surface, ∇g·δ = 0, and one in 2n − 2 if they keep the energy as well, ∇h·δ = 0. In a coordinate and its momentum the
// latter keeps areas. Its eigenvalues at P x = x are those multipliers of the orbit (periodic_orbit.hpp) that are not
// trivial.

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <tuple>
#include <vector>

#include <Eigen/Core>

#include "qdot/analysis/section.hpp"
#include "qdot/analysis/sensitivity.hpp"
#include "qdot/analysis/variations/slope.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/event.hpp"
#include "qdot/mechanics/energy.hpp"

namespace qdot {

/// Where a motion returns to a surface, and how that depends on its start.
///
/// @tparam n  number of coordinates, or Dynamic
template <int n = Dynamic>
struct ReturnMap {
  SectionOutcome outcome = SectionOutcome::complete;  ///< how it ended
  Outcome run_outcome = Outcome::completed;           ///< why the run ended, or not_differentiable
  std::string message;                                ///< how it ended, with the numbers and what to do
  double t = 0.0;                                     ///< of the return; of the end of the run, if there was none
  Eigen::VectorXd y;                                  ///< at the return, [q; q̇; …]; empty without one
  Eigen::MatrixXd derivative;                         ///< ∂y/∂(q, q̇ at the start) at the return, wherever it moves; empty unless complete
  Eigen::VectorXd time;                               ///< ∂t/∂(q, q̇ at the start)
  Eigen::VectorXd surface_slope, energy_slope;        ///< ∇g and ∇h at the start, 2n; empty where there is none
  bool keeps_energy = false;                          ///< h is the same at the return, as far as the tolerances tell
  bool is_constrained = false;                        ///< whether the system has constraints
  Eigen::Index dof = 0;                               ///< number of coordinates

  /// Whether it came back, with a derivative.
  bool complete() const noexcept { return outcome == SectionOutcome::complete; }

  /// The return as a time, coordinates and velocities.
  ///
  /// @throws InvalidValue  where there was none
  State<n> state() const {
    if (y.size() == 0) throw InvalidValue("there is no state of a return where the motion did not return; look at its outcome and message");
    return State<n>{t, y.head(dof), y.segment(dof, dof)};
  }

  /// The derivative of the map in some entries of [q; q̇] alone: 2n − 1 for starts on the surface, 2n − 2 for those on the energy level as well.
  ///
  /// @param entries  their places: i for q_i, n + i for q̇_i
  /// @return         a row and a column for each
  /// @throws InvalidValue  without a derivative; for other entries than can tell the points of the surface apart; on constraints
  Eigen::MatrixXd derivative_in(const std::vector<Eigen::Index>& entries) const;
};

namespace detail {

// Deviations τ_j, in columns, with τ_j = e_j among the given entries of [q; q̇] and normal to one or two slopes.
template <class = void>  // compiled only where it is called
Eigen::MatrixXd deviations_within(const std::vector<Eigen::Index>& entries, const Eigen::VectorXd& g, const Eigen::VectorXd& h) {
  const Eigen::Index size = g.size(), count = static_cast<Eigen::Index>(entries.size());
  std::vector<Eigen::Index> others;
  for (Eigen::Index i = 0; i < size; ++i)
    if (std::find(entries.begin(), entries.end(), i) == entries.end()) others.push_back(i);
  const bool on_level = others.size() == 2;
  const Eigen::Index a = others.front(), b = others.back();
  const double determinant = on_level ? g[a] * h[b] - g[b] * h[a] : g[a];
  const double largest = g.cwiseAbs().maxCoeff() * (on_level ? h.cwiseAbs().maxCoeff() : 1.0);
  if (!(std::abs(determinant) > 1e-9 * largest))
    throw_invalid_value({"the entries of a map must tell the points of its surface apart, but those left out, ", a, on_level ? " and " : "",
                         on_level ? Phrase(b) : Phrase(""), ", do not follow from them there; choose others"});
  Eigen::MatrixXd tau = Eigen::MatrixXd::Zero(size, count);
  for (Eigen::Index j = 0; j < count; ++j) {
    const Eigen::Index c = entries[static_cast<std::size_t>(j)];
    tau(c, j) = 1.0;
    if (on_level) {
      tau(a, j) = (g[b] * h[c] - g[c] * h[b]) / determinant;
      tau(b, j) = (g[c] * h[a] - g[a] * h[c]) / determinant;
    } else {
      tau(a, j) = -g[c] / determinant;
    }
  }
  return tau;
}

template <class = void>  // compiled only where it is called
Eigen::MatrixXd reduced(const Eigen::MatrixXd& derivative, Eigen::Index dof, const std::vector<Eigen::Index>& entries, const Eigen::VectorXd& g,
                        const Eigen::VectorXd& h, bool keeps_energy, bool is_constrained) {
  const Eigen::Index size = 2 * dof, count = static_cast<Eigen::Index>(entries.size());
  if (derivative.size() == 0) throw InvalidValue("the derivative of a return map is not there; look at its outcome and message");
  if (is_constrained)
    throw InvalidValue(
        "a map in fewer entries needs a scene without constraints, whose deviations are not free; use derivative, which maps those that are allowed");
  bool valid = count == size - 1 || count == size - 2;
  for (const Eigen::Index entry : entries) valid = valid && entry >= 0 && entry < size && std::count(entries.begin(), entries.end(), entry) == 1;
  if (!valid || count == 0)
    throw_invalid_value({"a map on the surface is one of ", size - 1, " different entries of [q; qdot], or of ", size - 2,
                         " on the energy level, each from 0 to ", size - 1, ", but ", count, " were given; i is q_i, and ", dof, " + i its velocity"});
  if (g.size() == 0) throw InvalidValue("the function of the surface must have a derivative at the start, but has none; let it be smooth there");
  const bool on_level = count == size - 2;
  if (on_level && (h.size() == 0 || !keeps_energy))
    throw_invalid_value({size - 2, " entries are enough only where the motion keeps its energy q̇·p − L, but it does not; give ", size - 1});
  return derivative(entries, Eigen::indexing::all) * deviations_within(entries, g, h);
}

// ∂F/∂[q; q̇] at x, whose entries are of the sizes that those of two points have; empty where there is none.
template <class = void>  // compiled only where it is called
Eigen::VectorXd slope_of(const std::function<double(const Eigen::VectorXd& x)>& F, const Eigen::VectorXd& x, const Eigen::VectorXd& other) {
  const Eigen::Index dof = x.size() / 2;
  Eigen::VectorXd slope(x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    double size = 0.0;
    for (Eigen::Index k = i < dof ? 0 : dof; k < (i < dof ? dof : 2 * dof); ++k) size = std::max({size, std::abs(x[k]), std::abs(other[k])});
    const auto along = slope_at_zero([&](double s) {
      Eigen::VectorXd nearby = x;
      nearby[i] += s;
      return Eigen::VectorXd(Eigen::VectorXd::Constant(1, F(nearby)));
    }, size > 0.0 ? size : 1.0);
    if (!along) return {};
    slope[i] = (*along)[0];
  }
  return slope;
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template Eigen::VectorXd slope_of<void>(const std::function<double(const Eigen::VectorXd&)>&, const Eigen::VectorXd&, const Eigen::VectorXd&);
#endif

// The event of a surface that is nearest to a time, within a distance, and has a derivative; null without one.
template <class = void>  // compiled only where it is called
const EventSensitivity* nearest_crossing(const std::vector<EventSensitivity>& events, const std::string& surface, double t, double distance) {
  const EventSensitivity* nearest = nullptr;
  for (const EventSensitivity& event : events)
    if (event.name == surface && event.time.size() > 0 && std::abs(event.t - t) <= distance &&
        (nearest == nullptr || std::abs(event.t - t) < std::abs(nearest->t - t)))
      nearest = &event;
  return nearest;
}

// A return that has no derivative, for its run with derivatives misses the surface or ends before it.
template <int n>
void end_without_derivative(ReturnMap<n>& found, const RunEnd& run, const std::string& surface) {
  found.outcome = SectionOutcome::no_derivative;
  found.run_outcome = run.completed() ? Outcome::not_differentiable : run.outcome;
  found.message = sentence({name(found.outcome), ": '", surface, "' is crossed at t = ", found.t, "; "});
  found.message += !run.completed() ? run.message
                                    : "but another run of the same tolerances misses it, so it is little more than grazed: choose a start that crosses "
                                      "clearly, or tighten rtol and atol";
}

// ∇g and ∇h at the start, and whether h is the same at the return.
//
// @param y0  at the start, [q; q̇; …]
// @param x1  at the return, [q; q̇]
template <int n, class System, class G>
void write_slopes(ReturnMap<n>& found, const System& system, const G& g, double t0, const Eigen::VectorXd& y0, const Eigen::VectorXd& x1, double rtol) {
  const Eigen::Index dof = found.dof;
  const Eigen::VectorXd x0 = y0.head(2 * dof);
  const auto surface_at = [&](const Eigen::VectorXd& x) {
    Eigen::VectorXd nearby = y0;
    nearby.head(2 * dof) = x;
    return event_value<n>(g, t0, nearby, dof);
  };
  found.surface_slope = slope_of(surface_at, x0, x1);
  const auto energy_at = [&](double t) {
    return [&system, t, dof](const Eigen::VectorXd& x) { return jacobi_energy(system.system(), State<n>{t, x.head(dof), x.tail(dof)}); };
  };
  found.energy_slope = slope_of(energy_at(t0), x0, x1);
  if (found.energy_slope.size() == 0) return;
  const double size = found.energy_slope.cwiseAbs().dot(x0.cwiseAbs()) + std::abs(energy_at(t0)(x0));
  found.keeps_energy = std::abs(energy_at(found.t)(found.y.head(2 * dof)) - energy_at(t0)(x0)) <= (1e-6 + 1e2 * rtol) * size;
}

}  // namespace detail

template <int n>
Eigen::MatrixXd ReturnMap<n>::derivative_in(const std::vector<Eigen::Index>& entries) const {
  return detail::reduced(derivative, dof, entries, surface_slope, energy_slope, keeps_energy, is_constrained);
}

/// The first return of a motion to a surface, and its derivative.
///
/// A run of size 2n, and one of size 2n (2n + 1) that keeps its trajectory as far as the return.
///
/// @param system   a system or scene; states of its effects begin as they always do
/// @param start    on the surface, or anywhere
/// @param surface  event(name, g), with .rising() or .falling() for one direction; g smooth where it is crossed
/// @param t_end    where the run ends at the latest
/// @param method   Dop853{} or Dopri5{}
/// @param others   events(…) of the motion itself
/// @return         the return and its derivative, with a named outcome: no_derivative where it only grazes
/// @throws         as poincare_section() and sensitivities()
template <class System, int n, class G, class Action, class Method = Dop853, class... Events>
auto return_map(const System& system, const State<n>& start, const Event<G, Action>& surface, double t_end, const Method& method = {},
                Options options = {}, const EventList<Events...>& others = {}) {
  static_assert(!Event<G, Action>::is_timed, "qdot: a clock has no slope; give the surface sin(2π t/T), rising, or ask sensitivities() over the period");
  const auto point = poincare_section(system, start, surface, 1, t_end, method, options, others);
  using Form = detail::FormOf<System>;
  constexpr int dofs = detail::dof_at_compile_time<Form>();
  ReturnMap<dofs> found;
  found.outcome = point.outcome;
  found.run_outcome = point.run_outcome;
  found.message = point.message;
  found.t = point.t_reached;
  found.dof = point.dof;
  found.is_constrained = ProjectableSystem<Form>;
  if (!point.complete()) return found;
  found.t = point.t.front();
  found.y = point.y.col(0);

  // As far as the steps of another run may bring the return later.
  const double duration = found.t - start.t, later = std::min(1e-6 + 1e3 * options.rtol, 0.1) * duration;
  options.keep_trajectory = true;
  options.output_times.clear();
  const auto s = std::apply([&](const auto&... each) {
    return sensitivities(system, start, found.t + later, method, options, events(surface, each...));
  }, others.list);
  const EventSensitivity* nearest = detail::nearest_crossing(s.events, surface.name, found.t, std::abs(later));
  if (nearest == nullptr) {
    detail::end_without_derivative(found, s, surface.name);
    return found;
  }
  const auto form = first_order_form(system);
  const Eigen::VectorXd y = s.run.trajectory.y_before(nearest->t).head(form.size()), y0 = detail::packed(form, start);
  Eigen::VectorXd rate(form.size());
  form.derivative(nearest->t, y, rate);
  found.time = nearest->time;
  found.derivative = s.Phi_before(nearest->t) + rate * found.time.transpose();
  detail::write_slopes(found, system, surface.g, start.t, y0, y.head(2 * found.dof), options.rtol);
  return found;
}

}  // namespace qdot
