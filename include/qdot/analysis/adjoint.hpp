#pragma once
// SPDX-License-Identifier: MIT
//
// The gradient of a number that a motion ends with
// ================================================
//
//     F = ∫ g(q, q̇, p, t) dt + h(q(T), q̇(T), p, T)
//
//     const auto found = adjoint_sensitivities(family, p, t_end, integral(energy), Dop853{});
//     found.value, found.by_parameters, found.by_start, found.by_end
//
// One run forwards and one backwards give all slopes of F, however many parameters there are: λ = ∂F/∂y(t) goes from
// the end to the start (variations/adjoint_equations.hpp). Sensitivities (sensitivity.hpp) carry a column for each
// parameter. Take those for up to some four parameters, for all of y(T), or for many times. Events, impacts, contacts
// and friction are passed backwards by the transposes of what they do to small deviations; where an event stops the
// run, T moves with it. On constraints λ belongs to tangent vectors, and the start is put onto them first.

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/ad/forward/functor_result.hpp"
#include "qdot/ad/dual.hpp"
#include "qdot/analysis/sensitivity.hpp"
#include "qdot/analysis/variations/adjoint_equations.hpp"
#include "qdot/analysis/variations/beginning.hpp"
#include "qdot/analysis/variations/branches.hpp"
#include "qdot/error.hpp"

namespace qdot {

/// What is not there: zero.
struct NoTerm {};

/// ∫ g dt + h at the end; each a functor of (q), (q, qdot), (q, qdot, p) or (q, qdot, p, t) for duals that returns a number.
template <class G, class H>
struct Functional {
  G g;  ///< what is integrated
  H h;  ///< what is added at the end
};

/// ∫ g dt.
template <class G>
Functional<G, NoTerm> integral(G g) {
  return {std::move(g), {}};
}

/// h at the end of the run.
template <class H>
Functional<NoTerm, H> end_value(H h) {
  return {{}, std::move(h)};
}

/// ∫ g dt + h at the end.
template <class G, class H>
Functional<G, H> functional(G g, H h) {
  return {std::move(g), std::move(h)};
}

/// A functional of a run and its gradient.
struct AdjointSensitivities {
  Outcome outcome = Outcome::completed;  ///< how the run ended
  std::string message;                   ///< how the run ended, with the numbers and what to do
  double value = 0.0;                    ///< F, up to where the run came
  Eigen::VectorXd by_parameters;         ///< ∂F/∂p; where an event stopped the run, with what p does to its time
  Eigen::VectorXd by_start;              ///< ∂F/∂(q₀, q̇₀), 2n
  double by_start_time = 0.0;            ///< ∂F/∂t₀
  double by_end = 0.0;                   ///< ∂F/∂T = g + ∂h/∂y ẏ + ∂h/∂t at the end
  Run<Dynamic> run;                      ///< of y, dense

  /// Whether there is a gradient: the run reached t_end, and the way back its start.
  bool completed() const noexcept { return outcome == Outcome::completed; }
};

namespace detail {

// A functor's value and slopes, one direction after the other.
template <int n, class G>
Term term_of(const G& g, Eigen::Index dof, const Eigen::VectorXd& p) {
  if constexpr (std::is_same_v<G, NoTerm>) return (void)g, (void)dof, (void)p, Term();
  else
    return [&g, dof, p](double t, const Eigen::VectorXd& y, TermAt& at) {
      using D = Dual<double, 1, AlongColumn>;
      using X = Vector<D, n>;
      using P = Vector<D, Eigen::Dynamic>;
      constexpr bool by_p = !detail::is_callable<const G&, const X&> && !detail::is_callable<const G&, const X&, const X&>;
      constexpr bool by_t = by_p && !detail::is_callable<const G&, const X&, const X&, const P&>;
      X q = y.head(dof).template cast<D>(), qdot = y.segment(dof, dof).template cast<D>();
      P parameters = p.head(by_p ? p.size() : 0).template cast<D>();
      D time(t);
      const auto along = [&](D& direction) {
        direction.tangent[0] = 1.0;
        const D value = [&] {
          if constexpr (detail::is_callable<const G&, const X&>) return D(g(q));
          else if constexpr (detail::is_callable<const G&, const X&, const X&>) return D(g(q, qdot));
          else if constexpr (by_t) return D(g(q, qdot, parameters, time));
          else return D(g(q, qdot, parameters));
        }();
        direction.tangent[0] = 0.0;
        at.value = value.value;
        return value.tangent[0];
      };
      at.by_y.setZero(y.size());
      at.by_p.setZero(p.size());
      at.size = 0.0;
      for (Eigen::Index i = 0; i < 2 * dof; ++i) {
        at.by_y[i] = along(i < dof ? q[i] : qdot[i - dof]);
        at.size += std::abs(at.by_y[i] * y[i]);
      }
      for (Eigen::Index j = 0; j < parameters.size(); ++j) at.by_p[j] = along(parameters[j]);
      if (by_t) at.by_t = along(time);
      at.size += std::abs(at.value);
    };
}

// What the run came to, backwards. Φ is that at the start.
//
// @param end   the surface of an event that stopped the run, or nothing
// @param late  ∂t₀/∂p
template <class = void>  // compiled only where it is called
void gather(VariationalEquations& equations, const JumpRecorder<>& recorder, const Eigen::MatrixXd& Phi, const Eigen::VectorXd& late,
            const NamedSurface* end, const Term& g, const Term& h, double rtol, AdjointSensitivities& result) {
  const Run<Dynamic>& run = result.run;
  AdjointEquations<> adjoint(equations, run.trajectory, g, rtol);
  const std::vector<Eigen::Index>& entries = equations.start_entries();
  const auto starts = static_cast<Eigen::Index>(entries.size());
  TermAt last;
  result.by_end = adjoint.g(run.t, run.y);
  if (h) {
    h(run.t, run.y, last);
    adjoint.lambda = last.by_y(entries);
    adjoint.by_p = last.by_p;
    result.by_end += last.by_t + last.by_y.dot(equations.state_rate(run.t, run.y));
  }
  if (end != nullptr) {
    const Eigen::VectorXd time = equations.crossing(end->name, run.t, recorder.tangents(run.t, run.y), end->surface).time;
    adjoint.lambda += result.by_end * time.head(starts);
    adjoint.by_p += result.by_end * time.tail(time.size() - starts);
  }
  adjoint.go_back(recorder.transfers());
  const double t0 = run.trajectory.front_time();
  const Eigen::VectorXd& y0 = run.trajectory.y_front();
  Eigen::VectorXd whole = Eigen::VectorXd::Zero(y0.size());
  whole(entries) = adjoint.lambda;
  const Eigen::VectorXd all = Phi.transpose() * whole;
  const double first = adjoint.g(t0, y0);
  result.value = adjoint.integral + last.value;
  result.by_start = all.head(2 * equations.dof());
  result.by_start_time = -first - whole.dot(equations.state_rate(t0, y0));
  result.by_parameters = adjoint.by_p + all.tail(all.size() - starts) - first * late;
  if (!adjoint.exact) {
    result.outcome = Outcome::accuracy_not_reached;
    result.message = sentence(
        {name(result.outcome), ": what is integrated backwards does not become smooth however short its steps; ", advice(result.outcome)});
  }
}

template <class Model, class Start, class List, class StartSlope, class G, class H>
auto adjoint_sensitivities_of(Model model, const Start& start, const List& list, double t_end, const auto& method, Options options, const Functional<G, H>& of,
                              const Eigen::VectorXd& p, const StartSlope& slope_of_start) {
  static_assert(is_explicit_method<std::remove_cvref_t<decltype(method)>>, "qdot: what derivatives are asked of is integrated by Dop853 or Dopri5");
  using V = Variations<Model>;
  require_valid(options, model.form.size());
  options.keep_trajectory = true;
  V equations(std::move(model), true, false, true);
  if (equations.dof() < 1) throw InvalidValue("a functional needs coordinates, but this first-order system has none; use sensitivities()");
  const Eigen::Index size = equations.state_size();
  const Eigen::VectorXd both = begun(equations, start, options, slope_of_start);
  Eigen::VectorXd late = Eigen::VectorXd::Zero(p.size());
  for (Eigen::Index j = 0; j < late.size(); ++j)
    if (const Eigen::VectorXd slope = slope_of_start(equations.model(), j); slope.size() > 0) late[j] = slope[size];
  JumpRecorder<> recorder(equations);
  VariationalForm<changes_of<Model>> form(recorder);
  const auto erased = erased_events(list, equations, recorder);
  const std::vector<NamedSurface> surfaces = surfaces_of(list, equations);

  AdjointSensitivities result;
  FunctorBranches<> branches(equations);
  try {
    const FirstOrderState from{start.t, both.head(size)};
    if (branches.begin(start.t, both, t_end)) result.run = simulate(form, from, t_end, method, options, with_branches(erased, branches, recorder));
    else result.run = simulate(form, from, t_end, method, options, erased);
    leave_branches_out(result.run.events);
    if (branches.grazed()) throw EndOfRun(branches.grazed()->failure);
    result.outcome = result.run.outcome;
    result.message = result.run.message;
    const NamedSurface* end = nullptr;
    for (const NamedSurface& each : surfaces)
      if (result.outcome == Outcome::stopped_by_event && each.stops && !result.run.events.empty() && each.name == result.run.events.back().name) end = &each;
    if (equations.changed())
      throw EndOfRun({Outcome::not_differentiable,
                      sentence({"at t = ", *equations.changed(), " an action changes what functors read, and backwards that cannot be undone: "
                                "make it a state of a controller, or ask sensitivities()"})});
    const Eigen::Map<const Eigen::MatrixXd> Phi(both.data() + size, size, equations.columns());
    gather(equations, recorder, Phi, late, end, term_of<V::n>(of.g, equations.dof(), p), term_of<V::n>(of.h, equations.dof(), p), options.rtol, result);
  } catch (const EndOfRun& end) {
    result.outcome = end.failure.outcome;
    result.message = sentence({name(result.outcome), ": ", end.failure.message, "; ", advice(result.outcome)});
  }
  return result;
}

}  // namespace detail

/// A functional of the motion of a system or scene, and its gradient with respect to its start.
///
/// One run of y, and one back of the adjoint: some seven evaluations of ∂f/∂y and of ∂f/∂p for each step. From nine parameters of T and V on,
/// λ·∂f/∂p takes one sweep backwards through them instead.
///
/// @param system   as simulate() has it
/// @param start    State{t, q, qdot}; on the constraints, if there are any
/// @param of       integral(g), end_value(h) or functional(g, h)
/// @param method   Dop853{} or Dopri5{}
/// @param events   events(…), whose actions may be called several times at one moment
/// @return         outcome, value and gradient; of the motion up to where it came
/// @throws         as sensitivities()
template <class System, class Start, class G, class H, class Method, class... Events>
  requires(!detail::is_callable<const System&, const Start&>)
auto adjoint_sensitivities(const System& system, const Start& start, double t_end, const Functional<G, H>& of, const Method& method,
                           const Options& options = {}, const EventList<Events...>& events = {}) {
  using Form = detail::FormOf<System>;
  return detail::adjoint_sensitivities_of(detail::FixedModel<Form, EventList<Events...>>{first_order_form(system), events}, start, events, t_end, method,
                                          options, of, Eigen::VectorXd(), detail::FixedStart{});
}

/// A functional of the motion, and its gradient with respect to its start and to parameters of T and V. Arguments and cost are
/// those above.
///
/// @param energies_of  p ↦ an object with members T and V, as sensitivities() has it
/// @param p            parameters
template <class EnergiesOf, class P, int n, class G, class H, class Method, class... Events>
  requires detail::is_callable<const EnergiesOf&, const P&>
auto adjoint_sensitivities(const EnergiesOf& energies_of, const P& p, const State<n>& start, double t_end, const Functional<G, H>& of, const Method& method,
                           const Options& options = {}, const EventList<Events...>& events = {}) {
  return detail::adjoint_sensitivities_of(detail::energies_model<n>(energies_of, p, events), start, events, t_end, method, options, of,
                                          Eigen::VectorXd(p), detail::FixedStart{});
}

/// A functional and its gradient with respect to p, for a family of problems, which may differ in everything.
///
/// @param family  p ↦ problem(system or scene, start, events(…)) for a vector p of double
template <class Family, class P, class G, class H, class Method>
  requires detail::is_callable<const Family&, const P&>
auto adjoint_sensitivities(const Family& family, const P& p, double t_end, const Functional<G, H>& of, const Method& method, const Options& options = {}) {
  detail::FamilyModel<Family, P> model(family, p);
  const auto nominal = model.nominal;
  return detail::adjoint_sensitivities_of(std::move(model), nominal.start, nominal.events, t_end, method, options, of, Eigen::VectorXd(p),
                                          detail::SlopeOfFamilyStart{});
}

// Old names, accepted until 0.4.

using FunctionalGradient [[deprecated("qdot: say AdjointSensitivities")]] = AdjointSensitivities;

/// adjoint_sensitivities() by its old name.
template <class System, class Start, class G, class H, class Method, class... Events>
  requires(!detail::is_callable<const System&, const Start&>)
[[deprecated("qdot: say adjoint_sensitivities()")]]
auto functional_gradient(const System& system, const Start& start, double t_end, const Functional<G, H>& of, const Method& method,
                         const Options& options = {}, const EventList<Events...>& events = {}) {
  return adjoint_sensitivities(system, start, t_end, of, method, options, events);
}
template <class EnergiesOf, class P, int n, class G, class H, class Method, class... Events>
  requires detail::is_callable<const EnergiesOf&, const P&>
[[deprecated("qdot: say adjoint_sensitivities()")]]
auto functional_gradient(const EnergiesOf& energies_of, const P& p, const State<n>& start, double t_end, const Functional<G, H>& of, const Method& method,
                         const Options& options = {}, const EventList<Events...>& events = {}) {
  return adjoint_sensitivities(energies_of, p, start, t_end, of, method, options, events);
}
template <class Family, class P, class G, class H, class Method>
  requires detail::is_callable<const Family&, const P&>
[[deprecated("qdot: say adjoint_sensitivities()")]]
auto functional_gradient(const Family& family, const P& p, double t_end, const Functional<G, H>& of, const Method& method, const Options& options = {}) {
  return adjoint_sensitivities(family, p, t_end, of, method, options);
}

}  // namespace qdot
