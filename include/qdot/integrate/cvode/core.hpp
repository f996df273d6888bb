#pragma once
// SPDX-License-Identifier: MIT
//
// One CVODE solver: its memory, and the code around each of its steps.
//
// CVODE carries the Nordsieck vector zₖ = hᵏ y⁽ᵏ⁾/k!, k = 0 … order, of a polynomial through the recent past, predicts with it
// and corrects with ẏ = f. It goes one step at a time, with the end of the run as its stop time: every step can be seen and
// stopped, and the end is met exactly. Dense output is the Nordsieck vector itself. CVODE counts time from 0 at each reset. Its
// own checks for steps too close to t would refuse, at t = 1.7e9, every motion of less than some 1e-5 s (time_point.hpp).
//
//     floor      The smallest step is some rounding units, set for every step. A model that turns to NaN, or a solution
//                with a pole, costs 10² to 10³ evaluations then, and 10⁵ without it.
//     watch      GuardedSystem holds back the model's exceptions; they are rethrown here.
//     blame      The component with the largest weighted local error is counted, and named in messages.
//     words      Messages are built here from flag, t, h, order and component. CVODE's own differ between versions and
//                go to stderr.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "qdot/ad/vector.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/cvode/bridge.hpp"
#include "qdot/integrate/cvode/callbacks.hpp"
#include "qdot/integrate/cvode/flags.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/statistics.hpp"
#include "qdot/integrate/steps/polynomial.hpp"

namespace qdot {

/// How the implicit equations of a step are solved.
enum class Corrector {
  newton,      ///< modified Newton iteration with the exact Jacobian: for stiff and non-stiff systems
  fixed_point  ///< functional iteration: no Jacobian, no linear algebra, non-stiff systems only
};

/// What CVODE is told besides the common options.
struct CvodeSettings {
  std::string name;     ///< of the method, for statistics
  int family = CV_BDF;  ///< CV_BDF or CV_ADAMS
  int max_order = 5;    ///< 1 … 5 (BDF), 1 … 12 (Adams)
  Corrector corrector = Corrector::newton;
  std::function<void(std::string_view)> on_message;  ///< sink for SUNDIALS' own messages; none by default
};

namespace detail::cvode {

inline constexpr double epsilon = std::numeric_limits<double>::epsilon();
inline constexpr double shortest = std::numeric_limits<double>::min() / epsilon;  // below it, ε h is no number

// Declared in the order of construction: the context first, CVODE's memory last.
struct Core {
  CvodeSettings settings;
  double max_step, initial_step;
  bool has_zero_atol = false;
  Messages messages;
  ContextHandle context;
  GuardedSystem guard;
  Eigen::VectorXd y, weights, errors;  // CVODE writes into these through the vectors below
  Eigen::MatrixXd coefficients;        // of the last step's polynomial, a column each
  Statistics statistics;
  Failure failure;
  double elapsed = 0.0, elapsed_before = 0.0;  // on the guard's clock, at the end of the last step and its beginning
  double t = 0.0, t_previous = 0.0;            // the same for readers
  double direction = 0.0;  // of the run since the last reset; 0 before its first step
  double smallest = 0.0;   // floor of h in the present step
  long cvode_steps = 0, error_failures = 0, corrector_failures = 0, setups = 0;  // CVODE's counters as last seen
  PolynomialView dense;
  bool dense_is_current = false;
  VectorHandle y_vector, weight_vector, error_vector, column_vector;
  MatrixHandle matrix;
  LinearSolverHandle linear_solver;
  NonlinearSolverHandle nonlinear_solver;
  MemoryHandle memory;

  [[gnu::cold]] Core(std::unique_ptr<MethodForm> system, NewtonMaker newton_of, CvodeSettings wanted, const Options& options);
  [[gnu::cold]] void reset(const TimePoint& at, const Eigen::Ref<const Eigen::VectorXd>& y0);
  bool step(double t_limit);
  void tolerate(const Eigen::VectorXd& atol);
  PolynomialView polynomial();

  VectorHandle view_of(Eigen::VectorXd& data) {
    return owned<VectorHandle>(N_VMake_Serial(index(data.size()), data.data(), context.get()), "vector");
  }
  [[gnu::cold]] void create_solver(const Options& options);
  [[gnu::cold]] void choose_corrector(NewtonMaker newton_of);
  void restart_cvode();
  [[gnu::cold]] bool hop();
  PolynomialView view(double scale, int degree) const {
    return {elapsed, scale, degree == 0 ? y.data() : coefficients.data(), y.size(), degree, guard.clock.origin(), elapsed_before, elapsed};
  }
  void count_attempts();
  Eigen::Index worst_component();
  [[gnu::cold]] bool fail(int flag);
  std::string worst_part(int flag);
};

inline Core::Core(std::unique_ptr<MethodForm> system, NewtonMaker newton_of, CvodeSettings wanted, const Options& options)
    : settings(std::move(wanted)),
      max_step(options.max_step),
      initial_step(options.initial_step),
      messages{[](bool, const char* text, void* self) noexcept {
                 const auto& sink = static_cast<const Core*>(self)->settings.on_message;
                 try {
                   if (sink && text != nullptr) sink(text);
                 } catch (...) {  // a sink must not throw through C
                 }
               },
               this},
      context(make_context(messages)),
      guard(std::move(system), options) {
  const Eigen::Index n = guard.system().size();
  if (n < 1) detail::throw_invalid_value({"a system must have at least 1 component, but has ", n});
  detail::require_valid(options, n);
  const int highest = settings.family == CV_BDF ? 5 : 12;
  detail::require_option(
      settings.max_order >= 1 && settings.max_order <= highest, "max_order",
      settings.family == CV_BDF ? "of BDF must lie between 1 and 5" : "of Adams must lie between 1 and 12",
      settings.max_order, "leave it out for the highest");
  statistics.method = settings.name;
  statistics.limited_by.assign(static_cast<std::size_t>(n), 0);
  y = weights = errors = zeros<Eigen::VectorXd>(n);
  coefficients = zeros<Eigen::MatrixXd>(n, highest + 1);
  y_vector = view_of(y);
  weight_vector = view_of(weights);
  error_vector = view_of(errors);
  column_vector = owned<VectorHandle>(N_VMake_Serial(index(n), coefficients.data(), context.get()), "vector");
  create_solver(options);
  choose_corrector(newton_of);
}

// Creates CVODE's memory, and sets what holds for all runs.
inline void Core::create_solver(const Options& options) {
  memory = owned<MemoryHandle>(CVodeCreate(settings.family, context.get()), "solver");
  require(redirect_messages(memory.get(), messages), "CVodeSetErrHandlerFn");
  require(CVodeInit(memory.get(), &GuardedSystem::right_hand_side, 0.0, y_vector.get()), "CVodeInit");
  require(CVodeSetUserData(memory.get(), &guard), "CVodeSetUserData");
  guard.rtol = options.rtol;
  tolerate(Eigen::VectorXd::NullaryExpr(y.size(), [&](Eigen::Index i) { return options.atol[i]; }));
  require(CVodeWFtolerances(memory.get(), &GuardedSystem::error_weights), "CVodeWFtolerances");
  require(CVodeSetMaxNumSteps(memory.get(), -1), "CVodeSetMaxNumSteps");  // the driver counts
  require(CVodeSetMaxHnilWarns(memory.get(), -1), "CVodeSetMaxHnilWarns");
  require(CVodeSetMaxOrd(memory.get(), settings.max_order), "CVodeSetMaxOrd");
  if (guard.system().is_constrained()) {
    if (settings.family != CV_BDF)
      detail::throw_invalid_value({"a system with constraints needs a method that can project onto them, but ", settings.name,
                                   " cannot (CVODE projects with BDF only); use CvodeBdf, Dop853 or Dopri5"});
    require(CVodeSetProjFn(memory.get(), &GuardedSystem::projection), "CVodeSetProjFn");
    require(CVodeSetProjErrEst(memory.get(), SUNFALSE), "CVodeSetProjErrEst");
  }
  if (std::isfinite(max_step)) require(CVodeSetMaxStep(memory.get(), max_step), "CVodeSetMaxStep");
}

// Gives CVODE its nonlinear solver, and Newton's method a linear one.
inline void Core::choose_corrector(NewtonMaker newton_of) {
  if (settings.corrector == Corrector::newton) {
    nonlinear_solver = owned<NonlinearSolverHandle>(SUNNonlinSol_Newton(y_vector.get(), context.get()), "Newton solver");
    require(CVodeSetNonlinearSolver(memory.get(), nonlinear_solver.get()), "CVodeSetNonlinearSolver");
    if (newton_of != nullptr) guard.newton = newton_of(guard.system(), context.get());
    if (guard.newton) {
      require(CVodeSetLinearSolver(memory.get(), guard.newton->solver(), guard.newton->matrix()), "CVodeSetLinearSolver");
      require(CVodeSetLinSysFn(memory.get(), &GuardedSystem::sparse_newton), "CVodeSetLinSysFn");
    } else {
      matrix = owned<MatrixHandle>(SUNDenseMatrix(index(y.size()), index(y.size()), context.get()), "matrix");
      linear_solver = owned<LinearSolverHandle>(SUNLinSol_Dense(y_vector.get(), matrix.get(), context.get()), "linear solver");
      require(CVodeSetLinearSolver(memory.get(), linear_solver.get(), matrix.get()), "CVodeSetLinearSolver");
      require(CVodeSetJacFn(memory.get(), &GuardedSystem::jacobian), "CVodeSetJacFn");
    }
    if (guard.system().jacobian_changes_fast())
      for (const auto set_frequency : {CVodeSetJacEvalFrequency, CVodeSetLSetupFrequency}) require(set_frequency(memory.get(), 1), "CVodeSet…Frequency");
  } else {
    nonlinear_solver = owned<NonlinearSolverHandle>(SUNNonlinSol_FixedPoint(y_vector.get(), 0, context.get()), "fixed-point solver");
    require(CVodeSetNonlinearSolver(memory.get(), nonlinear_solver.get()), "CVodeSetNonlinearSolver");
  }
}

inline void Core::reset(const TimePoint& at, const Eigen::Ref<const Eigen::VectorXd>& y0) {
  const double t0 = at.t();
  const Eigen::Index n = guard.system().size();
  if (y0.size() != n)
    throw DimensionError("y", static_cast<long>(n), static_cast<long>(y0.size()),
                         "pass one entry for each component of the system");
  detail::require_option(std::isfinite(t0), "t", "must be finite", t0, "start at a time that is a number");
  for (Eigen::Index i = 0; i < n; ++i)
    if (!std::isfinite(y0[i]))
      detail::throw_invalid_value({guard.system().component_name(i), " must be finite at the start, but is ", y0[i], "; give it a number"});
    else if (has_zero_atol && y0[i] == 0.0)
      detail::throw_invalid_value({"atol must be positive for ", settings.name, " where a component starts at 0, as ", guard.system().component_name(i),
                                   " does, but is 0; give it the size below which the component no longer matters, or take Dop853"});
  guard.renew();
  guard.start(at, y0);
  t = t_previous = t0;
  elapsed = elapsed_before = at.elapsed;
  y = y0;
  restart_cvode();
}

inline void Core::tolerate(const Eigen::VectorXd& atol) {
  has_zero_atol = atol.size() > 0 && atol.minCoeff() == 0.0;
  guard.atol = atol.unaryExpr([](double a) { return detail::positive_atol(a); });
}

inline void Core::restart_cvode() {
  require(CVodeReInit(memory.get(), 0.0, y_vector.get()), "CVodeReInit");
  cvode_steps = error_failures = corrector_failures = setups = 0;
  direction = 0.0;
  dense = view(1.0, 0);
  dense_is_current = true;
}

inline bool Core::step(double t_limit) {
  guard.clock.head_for(t_limit);
  const double length = guard.clock.length(), way = length - elapsed;
  if (way == 0.0 || !std::isfinite(way) || way * direction < 0)
    detail::throw_invalid_value({"t_limit must lie ahead of t = ", t, ", but is ", t_limit, "; call reset() to turn round"});
  const double sign = way > 0 ? 1.0 : -1.0;
  if (direction == 0.0) {
    if (std::abs(way) <= shortest) return hop();
    require(CVodeSetInitStep(memory.get(), sign * std::min(initial_step, std::abs(way))), "CVodeSetInitStep");
  }
  direction = sign;
  const double stop = length - guard.began;  // in CVODE's time
  smallest = std::min({guard.clock.least_step(elapsed), std::abs(stop - (elapsed - guard.began)), max_step});
  require(CVodeSetMinStep(memory.get(), smallest), "CVodeSetMinStep");
  require(CVodeSetStopTime(memory.get(), stop), "CVodeSetStopTime");

  guard.forget();
  dense_is_current = false;
  double reached = 0.0;
  const int flag = CVode(memory.get(), stop, y_vector.get(), &reached, CV_ONE_STEP);
  guard.rethrow();
  count_attempts();
  if (!accepted(flag)) return fail(flag);

  elapsed_before = std::exchange(elapsed, reached == stop ? length : guard.began + reached);
  t_previous = std::exchange(t, guard.clock.t(elapsed));
  double h = 0.0;
  CVodeGetLastStep(memory.get(), &h);
  CVodeGetLastOrder(memory.get(), &statistics.last_order);
  statistics.last_step = std::abs(h);
  if (statistics.steps == 1) statistics.first_step = statistics.last_step;
  if (elapsed != length) statistics.smallest_step = std::min(statistics.smallest_step, statistics.last_step);
  statistics.highest_order = std::max(statistics.highest_order, statistics.last_order);
  ++statistics.limited_by[static_cast<std::size_t>(worst_component())];
  return true;
}

// A way so short that CVODE's own numbers underflow in it: y + h f is exact there.
inline bool Core::hop() {
  const double h = guard.clock.length() - elapsed;
  const Eigen::Index n = y.size();
  for (Eigen::Index i = 0; i < n; ++i) {
    coefficients.data()[i] = y[i];
    coefficients.data()[n + i] = h * guard.start_derivative()[i];
    y[i] += coefficients.data()[n + i];
  }
  const double length = guard.clock.length(), t_limit = guard.clock.t(length);
  if (guard.guarded([&] { guard.start(guard.clock.time_point(length), y); }) != 0) {
    std::copy_n(coefficients.data(), n, y.data());
    guard.rethrow();
    return fail(CV_RHSFUNC_FAIL);
  }
  elapsed_before = std::exchange(elapsed, length);
  t_previous = std::exchange(t, t_limit);
  restart_cvode();
  dense = view(h, 1);
  dense.origin = elapsed_before;
  ++statistics.steps;
  statistics.evaluations = guard.evaluations;
  statistics.last_step = std::abs(h);
  statistics.last_order = 1;
  return true;
}

inline void Core::count_attempts() {
  long seen_steps = 0, seen_errors = 0, seen_correctors = 0, seen_setups = 0;
  CVodeGetNumSteps(memory.get(), &seen_steps);
  CVodeGetNumErrTestFails(memory.get(), &seen_errors);
  CVodeGetNumStepSolveFails(memory.get(), &seen_correctors);
  CVodeGetNumLinSolvSetups(memory.get(), &seen_setups);
  statistics.steps += seen_steps - std::exchange(cvode_steps, seen_steps);
  statistics.rejected_by_error_test += seen_errors - std::exchange(error_failures, seen_errors);
  statistics.rejected_by_corrector += seen_correctors - std::exchange(corrector_failures, seen_correctors);
  statistics.linear_setups += seen_setups - std::exchange(setups, seen_setups);
  statistics.evaluations = guard.evaluations;
  statistics.jacobians = guard.jacobians;
  statistics.projections = guard.projections;
  statistics.constraint_residual = guard.constraint_residual;
  statistics.constraint_velocity = guard.constraint_velocity;
}

inline Eigen::Index Core::worst_component() {
  CVodeGetEstLocalErrors(memory.get(), error_vector.get());
  CVodeGetErrWeights(memory.get(), weight_vector.get());
  Eigen::Index worst = 0;
  for (Eigen::Index i = 1; i < errors.size(); ++i)
    if (std::abs(errors[i] * weights[i]) > std::abs(errors[worst] * weights[worst])) worst = i;
  return worst;
}

inline PolynomialView Core::polynomial() {
  if (dense_is_current) return dense;
  // cₖ = zₖ. The first two are at hand; CVodeGetDky gives the others as y⁽ᵏ⁾ = k! zₖ/hᵏ, a sum of order − k + 1 vectors
  // each, and needs hᵏ within double's range.
  double t_internal = t, gamma = 0.0, inverse_l1 = 1.0, h = 1.0;
  N_Vector unused = nullptr, z1 = nullptr;
  void* user_data = nullptr;
  CVodeGetNonlinearSystemData(memory.get(), &t_internal, &unused, &unused, &unused, &gamma, &inverse_l1, &z1,
                              &user_data);
  CVodeGetLastStep(memory.get(), &h);
  int degree = statistics.last_order;
  while (degree > 1 && std::abs(h) < 1e-20 && std::abs(std::pow(h, degree)) < 1e-280) --degree;
  double* column = std::copy_n(y.data(), y.size(), coefficients.data());
  column = std::copy_n(N_VGetArrayPointer(z1), y.size(), column);
  double factor = h;
  for (int k = 2; k <= degree; ++k) {
    factor *= h / k;
    N_VSetArrayPointer(column, column_vector.get());
    CVodeGetDky(memory.get(), t_internal, k, column_vector.get());
    for (const double* const end = column + y.size(); column != end; ++column) *column *= factor;
  }
  dense = view(h, degree);
  dense_is_current = true;
  return dense;
}

inline bool Core::fail(int flag) {
  dense = view(1.0, 0);
  dense_is_current = true;
  // The step that was being tried: γ = h/l₁ is all that CVODE still has of it.
  double t_tried = 0.0, gamma = 0.0, inverse_l1 = 1.0;
  N_Vector unused = nullptr;
  void* user_data = nullptr;
  CVodeGetNonlinearSystemData(memory.get(), &t_tried, &unused, &unused, &unused, &gamma, &inverse_l1, &unused,
                              &user_data);
  const double h = inverse_l1 == 0.0 ? 0.0 : gamma / inverse_l1;
  const bool at_floor = std::abs(h) <= 1.01 * smallest;
  failure.outcome = guard.trouble() ? guard.trouble()->outcome : outcome_of(flag, at_floor);
  failure.message = detail::sentence(
      {statistics.method, " took no step from t = ", t, h == 0.0 ? "" : detail::sentence({" with h down to ", std::abs(h)}), ", order ",
       statistics.last_order, ": ", guard.trouble() ? guard.trouble()->message : worst_part(flag), " [CVode: ", flag_text(flag), "]"});
  return false;
}

// What did not come out, and where most of all.
inline std::string Core::worst_part(int flag) {
  const Eigen::Index worst = worst_component();
  return detail::sentence({flag == CV_ERR_FAILURE    ? "the local error stayed too large"
                           : flag == CV_CONV_FAILURE ? "the implicit equations did not converge"
                           : flag == CV_TOO_MUCH_ACC ? "the tolerances are below rounding"
                                                     : "CVODE gave up",
                           ", most of all in ", guard.system().component_name(worst), " = ", y[worst]});
}

// What a stepper asks of it, compiled once in a program, or in the library (qdot::compiled).
template <class Number = double>
std::unique_ptr<Core> new_core(std::unique_ptr<MethodForm> system, NewtonMaker newton_of, CvodeSettings settings, const Options& options) {
  return std::make_unique<Core>(std::move(system), newton_of, std::move(settings), options);
}
template <class Number = double>
void reset(Core& core, const TimePoint& at, const Eigen::Ref<const Eigen::VectorXd>& y) {
  core.reset(at, y);
}
template <class Number = double>
bool step(Core& core, double t_limit) {
  return core.step(t_limit);
}
template <class Number = double>
void tolerate(Core& core, const Eigen::VectorXd& atol) {
  core.tolerate(atol);
}
template <class Number = double>
PolynomialView polynomial(Core& core) {
  return core.polynomial();
}

#ifdef QDOT_COMPILED
extern template std::unique_ptr<Core> new_core<double>(std::unique_ptr<MethodForm>, NewtonMaker, CvodeSettings, const Options&);
extern template void reset<double>(Core&, const TimePoint&, const Eigen::Ref<const Eigen::VectorXd>&);
extern template bool step<double>(Core&, double);
extern template PolynomialView polynomial<double>(Core&);
extern template void tolerate<double>(Core&, const Eigen::VectorXd&);
#endif

}  // namespace detail::cvode
}  // namespace qdot
