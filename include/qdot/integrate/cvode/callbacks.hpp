#pragma once
// SPDX-License-Identifier: MIT
//
// Between CVODE, which is C, and a model, which is C++ and may throw.
//
// CVODE calls functions with a void* and takes three answers: 0, here is the value; +1, try again with a smaller step
// ("recoverable"); −1, give up. An exception must not travel through C code. So the functions below catch everything, translate
// it, and keep it for the stepper, which acts after CVode has returned:
//
//     value with NaN or infinity      +1   remembered: which component, at which t
//     NonFinite, MassMatrixError,     +1   remembered; the point may lie beyond where the step will end
//     RecoverableError
//     StopRequest                     −1   the run ends in good order
//     anything else                   −1   rethrown unchanged to the caller of the run
//
// CVODE does not see NaN by itself: with +1 a run into NaN takes hundreds of evaluations instead of hundreds of thousands. A
// later success drops the memory of a recoverable trouble, for then the smaller step was the cure.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "qdot/ad/vector.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/cvode/bridge.hpp"
#include "qdot/integrate/cvode/newton.hpp"
#include "qdot/integrate/time_point.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/steps/watch_budget.hpp"
#include "qdot/integrate/watch/driven_form.hpp"

namespace qdot::detail::cvode {

using ConstVector = Eigen::Ref<const Eigen::VectorXd>;

/// The model as CVODE sees it: counted, checked, and with every exception kept back.
class GuardedSystem {
 public:
  GuardedSystem(std::unique_ptr<MethodForm> system, const Options& options)
      : system_(std::move(system)), budget_(options), start_y_(system_->size()), start_ydot_(system_->size()), projected_(system_->size()) {}

  const MethodForm& system() const noexcept { return *system_; }
  void renew() {
    system_->renew();
    if (newton) newton->renew();
  }

  /// Evaluates f at the start of a run, from where CVODE counts its time, and keeps it for CVODE's first call; throws like the model.
  void start(const TimePoint& at, const ConstVector& y) {
    forget();
    start_pending_ = false;
    clock.start(at);
    began = at.elapsed;
    ++evaluations;
    derivative(shown(0.0), y, start_ydot_);
    start_y_ = y;
    start_pending_ = true;
  }

  /// f at the last start(); valid until CVODE has asked for it.
  const Eigen::VectorXd& start_derivative() const noexcept { return start_ydot_; }

  /// Forgets what went wrong before.
  void forget() noexcept {
    trouble_.reset();
    exception_ = nullptr;
  }

  /// What the last evaluation refused, if it refused.
  const std::optional<Failure>& trouble() const noexcept { return trouble_; }

  /// Rethrows an exception of the user's own, if one was caught.
  void rethrow() {
    if (exception_) std::rethrow_exception(std::exchange(exception_, nullptr));
  }

  /// Runs `evaluate` and translates what it throws into CVODE's answers.
  template <class Evaluate>
  int guarded(const Evaluate& evaluate) noexcept {
    try {
      evaluate();
      if (trouble_) trouble_.reset();
      return 0;
    } catch (...) {
      return answer_to_exception();
    }
  }

  static int right_hand_side(double t, N_Vector y, N_Vector ydot, void* self) noexcept {
    auto& guard = *static_cast<GuardedSystem*>(self);
    // The vectors are CVODE's own and promise no alignment beyond that of malloc.
    const Eigen::Map<const Eigen::VectorXd> state(N_VGetArrayPointer(y), guard.system_->size());
    Eigen::Map<Eigen::VectorXd> result(N_VGetArrayPointer(ydot), guard.system_->size());
    if (guard.start_pending_) {
      guard.start_pending_ = false;
      if (t == 0.0 && std::equal(state.data(), state.data() + state.size(), guard.start_y_.data())) {
        std::copy_n(guard.start_ydot_.data(), state.size(), result.data());
        return 0;
      }
    }
    if (guard.over_budget()) return -1;
    ++guard.evaluations;
    return guard.guarded([&] { guard.derivative(guard.shown(t), state, result); });
  }

  // One over what each component may err; asked for at every step, so tolerances may change between steps.
  static int error_weights(N_Vector y, N_Vector weights, void* self) noexcept {
    const auto& guard = *static_cast<GuardedSystem*>(self);
    const double* const state = N_VGetArrayPointer(y);
    double* const weight = N_VGetArrayPointer(weights);
    for (Eigen::Index i = 0; i < guard.atol.size(); ++i) weight[i] = 1.0 / (guard.rtol * std::abs(state[i]) + guard.atol[i]);
    return 0;
  }

  static int jacobian(double t, N_Vector y, N_Vector, SUNMatrix J, void* self, N_Vector, N_Vector, N_Vector) noexcept {
    auto& guard = *static_cast<GuardedSystem*>(self);
    const Eigen::Index n = guard.system_->size();
    const Eigen::Map<const Eigen::VectorXd> state(N_VGetArrayPointer(y), n);
    Eigen::Map<Eigen::MatrixXd> result(SUNDenseMatrix_Data(J), n, n);  // column-major, like Eigen's
    ++guard.jacobians;
    return guard.guarded([&] {
      guard.system_->jacobian(guard.shown(t), state, result);
      if (!all_finite(result.data(), result.size())) throw guard.non_finite_jacobian(guard.shown(t), result);
    });
  }

  // Newton's matrix of many coordinates; only γ is new when `keep` is set.
  static int sparse_newton(sunrealtype t, N_Vector y, N_Vector, SUNMatrix, sunbooleantype keep, sunbooleantype* is_new,
                           sunrealtype gamma, void* self, N_Vector, N_Vector, N_Vector) noexcept {
    auto& guard = *static_cast<GuardedSystem*>(self);
    const Eigen::Map<const Eigen::VectorXd> state(N_VGetArrayPointer(y), guard.system_->size());
    *is_new = keep ? SUNFALSE : SUNTRUE;
    return guard.guarded([&] {
      if (!keep) {
        ++guard.jacobians;
        guard.newton->linearize(guard.shown(t), state);
      }
      guard.newton->assemble(gamma);
    });
  }

  // CVODE's projection: corr ← projected(y) − y, at every step, before the error test.
  static int projection(double t, N_Vector y, N_Vector correction, double, N_Vector, void* self) noexcept {
    auto& guard = *static_cast<GuardedSystem*>(self);
    const Eigen::Map<const Eigen::VectorXd> state(N_VGetArrayPointer(y), guard.system_->size());
    Eigen::Map<Eigen::VectorXd> change(N_VGetArrayPointer(correction), guard.system_->size());
    return guard.guarded([&] {
      std::copy_n(state.data(), state.size(), guard.projected_.data());
      const ProjectionReport report = guard.system_->project(guard.shown(t), guard.projected_);
      for (Eigen::Index i = 0; i < state.size(); ++i) change[i] = guard.projected_[i] - state[i];
      ++guard.projections;
      guard.constraint_residual = std::max(guard.constraint_residual, report.residual);
      guard.constraint_velocity = std::max(guard.constraint_velocity, report.velocity_residual);
    });
  }

  Clock clock;
  double began = 0.0;                       // elapsed on the clock where CVODE's own time is 0
  std::unique_ptr<NewtonEquations> newton;  // in place of a dense matrix, where most coordinates do not meet
  long evaluations = 0;
  long jacobians = 0;
  long projections = 0;
  double constraint_residual = 0.0, constraint_velocity = 0.0;  // largest after a projection
  double rtol = 0.0;
  Eigen::VectorXd atol;

 private:
  // ydot ← f(t, y). @throws NonFinite when it is not finite, and whatever the model throws.
  void derivative(double t, const ConstVector& y, Eigen::Ref<Eigen::VectorXd> ydot) const {
    system_->derivative(t, y, ydot);
    if (!all_finite(ydot.data(), ydot.size())) throw non_finite_derivative(t, ydot);
  }

  [[gnu::cold, gnu::noinline]] NonFinite non_finite_derivative(double t, const Eigen::Ref<Eigen::VectorXd>& ydot) const {
    Eigen::Index i = 0;
    while (std::isfinite(ydot[i])) ++i;
    return non_finite(sentence({"the derivative of ", system_->component_name(i)}), ydot[i], t);
  }

  [[gnu::cold, gnu::noinline]] NonFinite non_finite_jacobian(double t, const Eigen::Map<Eigen::MatrixXd>& J) const {
    Eigen::Index k = 0;
    while (std::isfinite(J.data()[k])) ++k;  // column-major and without gaps, as CVODE keeps it
    const std::string changes = system_->component_name(k % J.rows()), with = system_->component_name(k / J.rows());
    return non_finite(sentence({"the change of ", changes, "'s derivative with ", with}), J.data()[k], t);
  }

  static NonFinite non_finite(const std::string& component, double value, double t) {
    return {component, t, sentence({component, " is ", value, " at t = ", t})};
  }

  // t for the model, by CVODE's time.
  double shown(double cvode_time) const noexcept { return clock.shown(clock.within(began + cvode_time)); }

  // True when nothing may be evaluated any more, with that as the trouble.
  bool over_budget() {
    if (!budget_.is_spent(evaluations)) return false;
    trouble_ = budget_.failure(evaluations);
    return true;
  }

  int refused(Outcome outcome, const std::exception& error) {
    trouble_.emplace(Failure{outcome, error.what()});
    return +1;
  }

  // What CVODE is told of the exception that is being handled.
  [[gnu::cold, gnu::noinline]] int answer_to_exception() noexcept {
    try {
      try {
        throw;
      } catch (const NonFinite& error) {
        return refused(Outcome::non_finite, error);
      } catch (const MassMatrixError& error) {
        return refused(Outcome::singular_mass_matrix, error);
      } catch (const ConstraintError& error) {
        return refused(Outcome::constraint_failure, error);
      } catch (const RecoverableError& error) {
        return refused(Outcome::refused_by_model, error);
      } catch (const StopRequest& request) {
        refused(Outcome::stopped_by_model, request);
        return -1;
      }
    } catch (...) {  // also when there is no memory left for the words of the others
      trouble_.reset();
      exception_ = std::current_exception();
      return -1;
    }
  }

  std::unique_ptr<MethodForm> system_;
  Budget budget_;
  Eigen::VectorXd start_y_, start_ydot_, projected_;
  bool start_pending_ = false;
  std::optional<Failure> trouble_;
  std::exception_ptr exception_;
};

}  // namespace qdot::detail::cvode
