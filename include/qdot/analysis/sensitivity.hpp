#pragma once
// SPDX-License-Identifier: MIT
//
// How a motion depends on where it begins, when it begins, and on what it is made of:
//
//     Φ(t) = ∂y(t) / ∂(y₀, t₀, p) ,      y = [q; q̇; …] .
//
//     const auto s = sensitivities(system, State<2>{0.0, q, qdot}, 3.0, Dop853{}, {.rtol = 1e-12});
//     s.Phi, s.Phi_at(1.5)        a column for each entry of q₀ and q̇₀, at the end and on the way
//
// Φ is integrated with y by the same steps, from exact ∂f/∂y and ∂f/∂p (analysis/variations/equations.hpp). At an event
// it is multiplied by a saltation matrix, and where a functor branches it has the jump that a jump of f makes
// (analysis/variations/branches.hpp). On constraints it maps tangent vectors to tangent vectors. There is no derivative
// where a motion only grazes an event, or where two events in one moment act on each other. Nor is there of an action
// with a kink, or with another result at each call. The run then ends as not_differentiable, and returns what it had.
// Steps are those of Dop853{} or Dopri5{}; CvodeBdf{} is for stiff motions, Taylor{} for results to rounding, Gauss{}
// for long times.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/analysis/variations/beginning.hpp"
#include "qdot/analysis/variations/branches.hpp"
#include "qdot/analysis/variations/variations.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/driver/consistent_start.hpp"
#include "qdot/integrate/driver/natural_tolerances.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

namespace qdot {

/// A motion before it is run: what moves, from where, and its events. Made by problem().
template <class System, class Start, class List = EventList<>>
struct Problem {
  System system;     ///< of a given value of the parameters
  Start start;       ///< and its start
  List events = {};  ///< and its events
};

/// A system or scene, its start, and the events of its run.
template <class System, class Start, class... Events>
Problem<System, Start, EventList<Events...>> problem(System system, Start start, EventList<Events...> events = {}) {
  return {std::move(system), std::move(start), std::move(events)};
}

/// Which columns Φ has besides those of the parameters, and what they ask of the steps.
struct WithRespectTo {
  bool start = true;        ///< q and q̇ at the start, 2n columns (all of y, for a first-order system)
  bool start_time = false;  ///< the time of the start, one column behind them
  bool controlled = true;   ///< steps are short enough for Φ; if not, a fifth fewer, and nothing holds the errors of Φ: by Dop853 and Dopri5 alone
};

/// An event of a run and the derivative of its time.
struct EventSensitivity {
  double t = 0.0;    ///< when
  std::string name;  ///< of the event
  /// ∂t/∂x, an entry for each column of Φ. Empty for an event that was only recorded, if no trajectory was kept, or if an action has changed the
  /// equations since.
  Eigen::VectorXd time;
};

/// A run and its derivatives. Columns of Φ: those of the start, of its time, of the parameters, as far as they were asked for.
///
/// @tparam n  number of coordinates, or Dynamic
template <int n = Dynamic>
struct Sensitivities : RunEnd {
  Eigen::VectorXd ydot;                              ///< ẏ there, which is ∂y/∂t_end
  Eigen::MatrixXd Phi;                               ///< ∂y/∂x at the fixed time t
  Eigen::MatrixXd Phi_of_event;                      ///< where an event stopped the run: ∂y/∂x at the event, wherever it moves; otherwise Φ
  std::vector<EventSensitivity> events;              ///< in the order of time
  Eigen::Index start_columns = 0, time_columns = 0;  ///< columns of Φ for the start and for its time; parameters have the rest
  Run<Dynamic> run;                                  ///< of [y; columns of Φ] as one system

  /// ∂y/∂(q₀, q̇₀), ∂y/∂t₀ and ∂y/∂p at the end, the columns of Φ that were asked for.
  Eigen::MatrixXd d_start() const { return Phi.leftCols(start_columns); }
  /// ∂y/∂t₀.
  Eigen::MatrixXd d_start_time() const { return Phi.middleCols(start_columns, time_columns); }
  /// ∂y/∂p.
  Eigen::MatrixXd d_parameters() const { return Phi.rightCols(Phi.cols() - start_columns - time_columns); }

  /// The last good state.
  State<n> state() const { return state_of(t, y); }

  /// The state at a time, behind a jump if there is one.
  ///
  /// @throws InvalidValue  when t is not within the run, or no trajectory was kept
  State<n> at(double time) const { return state_of(time, run.trajectory.y(time)); }

  /// Φ at a time, behind a jump if there is one; within the tolerances between steps, and so are J(q) Φ = 0 and the like.
  Eigen::MatrixXd Phi_at(double time) const { return columns_of(run.trajectory.y(time)); }

  /// Φ just in front of a jump.
  Eigen::MatrixXd Phi_before(double time) const { return columns_of(run.trajectory.y_before(time)); }

 private:
  State<n> state_of(double time, const Eigen::VectorXd& of) const {
    const Eigen::Index dof = run.trajectory.dof();
    if (dof < 1) throw InvalidValue("a state needs coordinates, but this first-order system has none; use y");
    return State<n>{time, of.head(dof), of.segment(dof, dof)};
  }
  Eigen::MatrixXd columns_of(const Eigen::VectorXd& both) const {
    return Eigen::Map<const Eigen::MatrixXd>(both.data() + y.size(), y.size(), Phi.cols());
  }
};

namespace detail {

// An event with the derivative of its time: known where it has changed the state, asked of the trajectory where it was recorded. Where it stopped
// the run, the end moves with it.
template <int n>
EventSensitivity differentiated(const RecordedEvent& event, const std::vector<NamedSurface>& surfaces, const VariationalEquations& equations,
                                bool kept, Sensitivities<n>& result) {
  EventSensitivity found{event.t, event.name, {}};
  bool by_name = false;  // of several in one moment
  for (const EventSlope& passed : equations.passed()) {
    if (passed.t != event.t || passed.name.empty() || by_name) continue;
    by_name = event.name == passed.name || event.name.starts_with(passed.name + " ");
    found.time = passed.time;
  }
  if (found.time.size() > 0) return found;
  for (const NamedSurface& each : surfaces) {
    if (each.name != event.name) continue;
    const bool ends = each.stops && result.outcome == Outcome::stopped_by_event && event.t == result.t;
    const bool has_changed = equations.changed() && std::abs(*equations.changed() - result.t) <= std::abs(event.t - result.t);
    if (!ends && (!kept || has_changed)) continue;
    found.time = equations.crossing(event.name, event.t, ends ? result.run.y : result.run.trajectory.y_before(event.t), each.surface).time;
    if (ends) result.Phi_of_event = result.Phi + result.ydot * found.time.transpose();
  }
  return found;
}

// The model of p ↦ (T, V) at p.
template <int n, class EnergiesOf, class P, class List>
auto energies_model(const EnergiesOf& energies_of, const P& p, const List& events) {
  static_assert(n != Dynamic, "qdot: parameters of energies need the number of coordinates in the type of the start, State<2>{…}");
  require_finite_parameters(p);
  const auto system = mechanical_system<n>(energies_of(p));
  using Form = FormOf<decltype(system)>;
  return EnergiesModel<Form, List, EnergiesOf, P::SizeAtCompileTime>{{first_order_form(system), events}, energies_of, p};
}

// What a method needs of a model besides the variational equations.
template <class Method, class Model>
struct Preparation {
  static constexpr bool takes_branches = true;  // one that records refuses them
  static void prepare(Variations<Model>&) {}
};

// How many components [y; columns of Φ] has, with the columns of the parameters and with or without those of the start. Dynamic where
// the number is not known at compile time, or where unrolled steps of that size are no faster. Each size is one more loop of a run to
// compile, shared by all models.
inline constexpr int most_components_in_sight = 20;
template <class Model>
consteval int size_in_sight(bool with_start) {
  constexpr int N = Model::Form::size_at_compile_time;
  if constexpr (N > 0 && changes_of<Model> == Changes::none && requires { Model::parameters_at_compile_time; }) {
    constexpr int m = Model::parameters_at_compile_time;
    const int columns = m + (with_start ? N : 0), both = N * (1 + columns);
    if (m >= 0 && columns > 0 && both <= most_components_in_sight) return both;
  }
  return Dynamic;
}
template <Changes changes, int size>
using FormOfSize = std::conditional_t<size == Dynamic, VariationalForm<changes>, SizedVariationalForm<changes, size == Dynamic ? 1 : size>>;

// The run of a model whose functors compare.
template <class Model, class Method, class... Events>
Run<Dynamic> run_with_branches(Variations<Model>& equations, const FunctorBranches<>& branches, const FirstOrderState& start, double t_end,
                               const Method& method, const Options& options, const EventList<Events...>& list) {
  if constexpr (Preparation<Method, Model>::takes_branches) {
    Run<Dynamic> run = simulate(VariationalForm<changes_of<Model>>(equations), start, t_end, method, options, with_branches(list, branches, equations));
    leave_branches_out(run.events);
    return run;
  }
  return {};
}

// Tolerances of y that the user did not give, from the sizes of the motion itself.
template <class Model>
void set_natural_tolerances(Variations<Model>& equations, const Options& options, double t, const Eigen::VectorXd& both, double t_end) {
  if (!options.atol.is_default() || t_end == t) return;
  const NaturalTolerances found = natural_tolerances(driven_form(equations.form()), options, t, both.head(equations.state_size()), t_end - t);
  if (found.each.size() > 0) equations.atol = found.each;
}

// Tolerances of [y; columns of Φ]: those of y for each column; without control of the columns, as if there were y alone.
template <class Method, class Model>
void spread_tolerances(Options& options, const Variations<Model>& equations, bool controlled) {
  const Eigen::Index size = equations.state_size();
  if (options.atol.size() > 1) {
    Eigen::VectorXd each(equations.size());
    for (Eigen::Index i = 0; i < each.size(); ++i) each[i] = options.atol[i % size];
    options.atol = each;
  }
  if (controlled) return;
  if (!is_explicit_method<Method>)
    throw InvalidValue("derivatives are left out of the control of errors by Dop853 and Dopri5 only; leave `controlled` as it is, or take one of them");
  // The root of the mean square is that of y alone again, where the columns' share is nothing.
  const double share = 1.0 / std::sqrt(static_cast<double>(1 + equations.columns()));
  Eigen::VectorXd each = Eigen::VectorXd::Constant(equations.size(), 1e300);
  for (Eigen::Index i = 0; i < size; ++i) each[i] = share * equations.atol[i];
  options.rtol = std::max(share * options.rtol, least_rtol);
  options.atol = each;
}

// The run of [y; columns of Φ], by steps that are written out for their number where that is in sight.
template <class Model, class Method, class List>
Run<Dynamic> run_of_columns(Variations<Model>& equations, const FirstOrderState& start, double t_end, const Method& method, const Options& options,
                            const List& list) {
  const auto run_of = [&]<int size>() { return simulate(FormOfSize<changes_of<Model>, size>(equations), start, t_end, method, options, list); };
  constexpr bool sized = is_explicit_method<Method>;
  constexpr int few = sized ? size_in_sight<Model>(false) : Dynamic, all = sized ? size_in_sight<Model>(true) : Dynamic;
  if (equations.size() == few) return run_of.template operator()<few>();
  if (equations.size() == all) return run_of.template operator()<all>();
  return run_of.template operator()<Dynamic>();
}

template <class = void>  // compiled only where it is called
void end_with(RunEnd& end, const Failure& failure) {
  end.outcome = failure.outcome;
  end.message = sentence({name(end.outcome), ": ", failure.message, "; ", advice(end.outcome)});
}

// The last state of result.run in parts: y and Φ, with ẏ.
//
// @param failure  that ended the run before it was begun, if any
template <class Model, int n>
void write_last_state(Sensitivities<n>& result, const Variations<Model>& equations, const std::optional<Failure>& failure) {
  const Run<Dynamic>& run = result.run;
  const Eigen::Index size = equations.state_size(), columns = equations.columns();
  result.start_columns = equations.start_columns();
  result.time_columns = equations.time_columns();
  static_cast<RunEnd&>(result) = {run.outcome, run.message, run.t, run.y.head(size)};
  if (failure) end_with(result, *failure);
  result.Phi = result.Phi_of_event = Eigen::Map<const Eigen::MatrixXd>(run.y.data() + size, size, columns);
  result.ydot = equations.state_rate(run.t, result.y);
}

// The derivatives of the run of a model from its start; of second order, too, they stand in its states behind Φ (analysis/second_sensitivity.hpp).
// The effects' own states at the start have columns behind those of q and q̇ on request.
template <class Model, class Start, class List, class StartSlope>
auto sensitivities_of(Model model, const Start& start, const List& list, double t_end, const auto& method, Options options,
                      const WithRespectTo& wanted, const StartSlope& slope_of_start, int order = 1, bool with_own_states = false) {
  using Method = std::remove_cvref_t<decltype(method)>;
  static_assert(SteppingMethod<Method, VariationalForm<changes_of<Model>>>,
                "qdot: sensitivities are integrated by Dop853, Dopri5, CvodeBdf, CvodeAdams, and without contacts or dry friction by Taylor "
                "(analysis/taylor_sensitivity.hpp) and Gauss (analysis/gauss_sensitivity.hpp)");
  require_valid(options, model.form.size());
  Variations<Model> equations(std::move(model), wanted.start, wanted.start_time, with_own_states);
  Preparation<Method, Model>::prepare(equations);
  const Eigen::Index columns = equations.columns();
  if (columns == 0) throw InvalidValue("sensitivities must be with respect to something; ask for the start, for its time, or give parameters");
  if (order == 2) equations.pairs = columns * (columns + 1) / 2;
  const Eigen::VectorXd both = begun(equations, start, options, slope_of_start);
  set_natural_tolerances(equations, options, start.t, both, t_end);
  spread_tolerances<Method>(options, equations, wanted.controlled);
  const auto erased = erased_events(list, equations, equations);
  const std::vector<NamedSurface> surfaces = surfaces_of(list, equations);

  Sensitivities<Variations<Model>::n> result;
  FunctorBranches<> branches(equations);
  std::optional<Failure> undifferentiable;
  bool has_branches = false;
  try {
    has_branches = Preparation<Method, Model>::takes_branches && branches.begin(start.t, both, t_end);
  } catch (EndOfRun& at_start) {
    undifferentiable = std::move(at_start.failure);
    t_end = start.t;
  }
  const FirstOrderState begin{start.t, both};
  result.run = has_branches ? run_with_branches(equations, branches, begin, t_end, method, options, erased)
                            : run_of_columns(equations, begin, t_end, method, options, erased);
  if (branches.grazed()) undifferentiable = branches.grazed()->failure;
  write_last_state(result, equations, undifferentiable);
  try {
    for (const RecordedEvent& event : result.run.events)
      result.events.push_back(differentiated(event, surfaces, equations, options.keep_trajectory, result));
  } catch (const EndOfRun& end) {
    end_with(result, end.failure);
  }
  return result;
}

}  // namespace detail

/// The motion of a system or scene and its derivatives with respect to its start.
///
/// One run of size (2n)(1 + columns); one ∂f/∂y for each evaluation of f.
///
/// Errors are controlled for y and Φ alike: options.atol holds for y, and for Φ per unit of what it is differentiated by. A parameter of size 1e9 (a
/// stiffness in N/m) has derivatives of size 1e-9: take its logarithm, or a unit in which it is smaller. state_norm_limit holds for Φ, too.
///
/// @param system   as simulate() has it
/// @param start    State{t, q, qdot}, or FirstOrderState{t, y}; on the constraints, if there are any
/// @param method   Dop853{} or Dopri5{}, and where the motion is stiff CvodeBdf{} (integrate/cvode.hpp), Taylor{}
///     (analysis/taylor_sensitivity.hpp) or Gauss{} (analysis/gauss_sensitivity.hpp)
/// @param events   events(…), whose actions may be called several times at one moment
/// @param wanted   which columns Φ has
/// @return         outcome, last good state, Φ there and on the way, events with the derivatives of their times
/// @throws         as simulate(); InvalidValue for events of the same name
template <class System, class Start, class Method, class... Events>
  requires(!std::is_invocable_v<const System&, const Start&>)
auto sensitivities(const System& system, const Start& start, double t_end, const Method& method, const Options& options = {},
                   const EventList<Events...>& events = {}, const WithRespectTo& wanted = {}) {
  using Form = detail::FormOf<System>;
  return detail::sensitivities_of(detail::FixedModel<Form, EventList<Events...>>{first_order_form(system), events}, start, events, t_end, method, options,
                                  wanted, detail::FixedStart{});
}

/// The motion and its derivatives with respect to its start and, exactly, to parameters of T and V. Other arguments and the cost
/// are those above.
///
/// @param energies_of  p ↦ an object with members T and V, for a vector p of double and of duals; it computes with the scalar of p
/// @param p            parameters
template <class EnergiesOf, class P, int n, class Method, class... Events>
  requires std::is_invocable_v<const EnergiesOf&, const P&>
auto sensitivities(const EnergiesOf& energies_of, const P& p, const State<n>& start, double t_end, const Method& method, const Options& options = {},
                   const EventList<Events...>& events = {}, const WithRespectTo& wanted = {}) {
  return detail::sensitivities_of(detail::energies_model<n>(energies_of, p, events), start, events, t_end, method, options, wanted, detail::FixedStart{});
}

/// The motion and its derivatives with respect to p, for a family of problems, which may differ in everything.
///
/// What has no formula in duals is differenced, with order six and from values that are exact to rounding: some twelve digits. Six evaluations of f more for
/// each parameter that f depends on, two for one that only events or the start ask for.
///
/// @param family  p ↦ problem(system or scene, start, events(…)) for a vector p of double
/// @param wanted  which columns Φ has besides those of p; none, unless asked for
/// @throws        InvalidValue where the family has no members on either side of p
template <class Family, class P, class Method>
  requires std::is_invocable_v<const Family&, const P&>
auto sensitivities(const Family& family, const P& p, double t_end, const Method& method, const Options& options = {},
                   const WithRespectTo& wanted = {.start = false}) {
  detail::FamilyModel<Family, P> model(family, p);
  const auto nominal = model.nominal;
  return detail::sensitivities_of(std::move(model), nominal.start, nominal.events, t_end, method, options, wanted, detail::SlopeOfFamilyStart{});
}

}  // namespace qdot
