#pragma once
// SPDX-License-Identifier: MIT
//
// A method that chooses among methods, and says why.
//
//     const auto run = simulate(system, start, 10.0, Automatic{}, {.rtol = 1e-9});     // cvode_automatic.hpp
//     run.statistics.method           "taylor", or "dop853, cvode_bdf" where it changed its mind
//     run.statistics.method_reason    why, in one sentence for each
//
// Smooth. It starts with Taylor, where T, V, the forces of effects and constraints are formulas, and rtol asks for more than a few digits. Taylor is two
// to seven times as fast as Dop853 on pendulums, orbits, chains and linkages. T, V and forces may branch. Otherwise, so where a constraint branches,
// with Dop853.
//
// Stiff. An explicit method of order p is stable while h |λ| stays below a limit for every eigenvalue λ of ∂f/∂y: 6 for Dop853 in all directions,
// 0.37 p + 1.4 for Taylor. Accuracy holds h |λ| below that as long as a motion with rate |λ| is going on: at 1.2 for Taylor, below 3.5 for Dop853. So
//
//     h ρ > 4  (Dop853),      h ρ > half the limit  (Taylor),      ρ = max |λ| of the exact Jacobian
//
// says that something fast is there, that it is at rest within the tolerance, and that only stability holds the step. It is computed every 4 size()
// steps, and sixteen at least, so that the Jacobian is two percent of the cost. With more than a thousand components it is every hundred steps, for
// there it takes twenty evaluations (steps/spectral_radius.hpp). If it warns twice in a row, the stiff method takes over, provided that the fast
// part is damped:
//
//     −Re λ ≥ 0.1 |λ| .
//
// What swings undamped is no stiffness, even at rest. BDF of order 3 and more lets it grow when h |λ| is about 1 to 10, and then has to follow it. That
// is less accurate, and costs more than the explicit methods at their limit. An example is a pendulum on an undamped spring of 1e6 N/m in Cartesian
// coordinates, for 10 s at 1e-6. Taylor takes 1.7 ms with an error of 8e-6, BDF 36 ms with 4e-4. (In r and θ CvodeBdf is cheaper, and less accurate:
// docs/lab/steppers.md.)
//
// Back. A stiff method covers some time per evaluation, Jacobians counted as size() of them; Dop853 at its limit, 4.8/ρ for twelve. It loses digits
// with each of its steps, and a step costs more than its evaluations. So when it gains less than a factor of 6, the first method takes over again. To
// leave it then takes four times as many warnings as before. An exception is a gain of 60 at some time, which pays for a change.
//
// Other changes: Taylor may meet a point at which T, V or a force is not analytic, or more branches than pay, as of a sensor of many cells. The stiff
// method may be unable to take a step. Then Dop853 goes on from the last good state. Nothing depends on a clock: the same run is the same to the last
// bit.
//
// Reference: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.2 (stiffness detection in DOP853).

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/steps/automatic_stepper.hpp"
#include "qdot/integrate/taylor.hpp"
#include "qdot/integrate/watch/any_form.hpp"

namespace qdot {

namespace detail {

/// Fills in the series where it promises to pay, and the reason for the choice.
///
/// @param what    what the series is made of: "T and V"
/// @param series  makes Taylor's stepper; may throw NotAnalytic
template <class Series>
void choose_first(AutomaticChoice& choice, Eigen::Index size, const Options& options, const std::string& what, const Series& series) {
  constexpr double fewest_digits = 1e-4;      // rtol above which Dop853 is as good
  constexpr Eigen::Index most_components = 128;  // beyond, recording T and factoring M at each step may cost more than it saves
  if (options.rtol > fewest_digits) {
    choice.reason = "few digits are asked for";
  } else if (size > most_components) {
    choice.reason = "there are many coordinates";
  } else {
    try {
      choice.series = series();
      choice.reason = sentence({what, choice.series->ends_at_branches() ? " are formulas on each branch, at whose ends steps end"
                                                                        : " are formulas without branches, and the motion is smooth"});
    } catch (const NotAnalytic& error) {
      choice.reason = sentence({error.source(), " has a branch or a kink"});
    } catch (const InvalidValue&) {  // of a system that is to be evaluated by dual numbers
      choice.reason = "dual numbers have no power series";
    }
  }
}

}  // namespace detail

/// Taylor or Dop853 while the motion is smooth, the stiff method `Stiff` where it is not.
template <class Stiff>
struct AutomaticWith {
  static constexpr std::string_view name = "automatic";  ///< as statistics call it until it has chosen
  using MakerOfSteppers = AutomaticWith;                 ///< integrate/watch/any_form.hpp

  Stiff stiff = {};  ///< settings of the stiff method

  /// A stepper for `system`, which it copies. The stiff method's is made when it is needed.
  template <FirstOrderSystem F>
  [[gnu::cold]] AutomaticStepper stepper(const F& system, const Options& options) const {
    const auto kept = std::make_shared<F>(system);
    AutomaticChoice choice = choice_of(kept, any_stepper(Dop853{}, system, options),
                                       [kept, options, method = stiff] { return any_stepper(method, *kept, options); });
    choice.reason = SwitchingSystem<F> ? "equations that switch have no power series" : "the system is more than T and V";
    if constexpr (detail::is_recordable<F>::value)
      detail::choose_first(choice, system.size(), options,
                           detail::mechanical_form<F>::value ? "T and V"
                           : ProjectableSystem<F>            ? "T, V, the forces and the constraints"
                                                             : "T, V and the forces",
                           [&] { return any_stepper(Taylor{}, system, options); });
    return AutomaticStepper(std::move(choice), system.size());
  }
  /// A stepper of so many components for a system whose type is hidden.
  template <int size>
    requires detail::MethodOfAnyForm<Stiff, size>
  [[gnu::cold]] AutomaticStepper stepper_of_form(const std::shared_ptr<const detail::AnyForm>& form, const Options& options) const {
    const std::shared_ptr<detail::MethodForm> kept = form->method_form();
    AutomaticChoice choice = choice_of(
        kept, detail::stepper_of_rates<Dop853::StepperOfRates<size>>(form->rates(), std::string(Dop853::name), options),
        [form, options, method = stiff] { return AnyStepper::made_by([&] { return method.template stepper_of_form<size>(form, options); }); });
    detail::choose_first(choice, kept->size(), options, "T and V",
                         [&] { return AnyStepper::made_by([&] { return Taylor{}.stepper_of_form<size>(form, options); }); });
    return AutomaticStepper(std::move(choice), kept->size());
  }

 private:
  // The choice without a series: steppers, and what is asked of the system besides.
  template <class F>
  static AutomaticChoice choice_of(const std::shared_ptr<F>& kept, AnyStepper smooth, std::function<AnyStepper()> stiff_method) {
    return {.series = std::nullopt,
            .smooth = std::move(smooth),
            .stiff = std::move(stiff_method),
            .jacobian = [kept](double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::MatrixXd> J) { kept->jacobian(t, y, J); },
            .derivative = [kept](double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot) { kept->derivative(t, y, ydot); },
            .renew = [kept] { detail::renew(*kept); },
            .reason = {}};
  }
};

}  // namespace qdot
