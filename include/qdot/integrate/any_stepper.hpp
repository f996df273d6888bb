#pragma once
// SPDX-License-Identifier: MIT
//
// A method chosen at run time.
//
//     std::map<std::string, AnyMethod<decltype(system)>> methods = {{"taylor", Taylor{}}, {"gauss", Gauss{.step = 0.01}}};
//     const auto run = simulate(system, start, 10.0, methods.at(name), options);
//
// Every method makes a stepper of a type of its own, unrolled for the number of components. AnyStepper hides that type behind one indirect
// call per step, a nanosecond or two beside a step's hundreds. After the call, time and state are read where the stepper keeps them. So
// the loop of a run is compiled once for all methods (simulate() makes one of each), and a switch costs nothing within the step.
//
// The hidden stepper keeps its promises (stepper.hpp), and constraints as well, whether it projects inside its steps or not.

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "qdot/integrate/projecting_stepper.hpp"
#include "qdot/integrate/stepper.hpp"
#include "qdot/integrate/steps/rates.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot {

/// A Stepper of any type. Movable; moved-from it can only be assigned to or destroyed.
class AnyStepper {
 public:
  static constexpr bool projects_itself = true;  // see any_stepper()

  /// Takes over a stepper, AnyStepper(std::in_place, …); one allocation.
  template <class S>
  AnyStepper(std::in_place_t, S stepper) : AnyStepper(made_by([&] { return std::move(stepper); })) {}

  /// The stepper that make() returns, made where it is kept: moving one is much code.
  template <class Make>
  static AnyStepper made_by(const Make& make) {
    static_assert(Stepper<decltype(make())>, "qdot: AnyStepper holds what models Stepper");
    if constexpr (std::is_same_v<decltype(make()), AnyStepper>) return make();
    else return AnyStepper(std::make_unique<Holder<decltype(make())>>(make));
  }

  void reset(const TimePoint& at, const Eigen::Ref<const Eigen::VectorXd>& y) { held_->reset(at, y); }
  bool step(double t_limit) { return held_->step(t_limit); }

  /// Takes other absolute tolerances, before a reset, where the stepper can.
  void tolerate(const Eigen::VectorXd& atol) { held_->tolerate(atol); }

  /// Whether what the stepper has recorded of its system still holds.
  bool is_current() { return held_->is_current(); }

  const Failure& failure() const { return held_->failure(); }
  double t() const noexcept { return held_->t; }
  double t_previous() const noexcept { return held_->t_previous; }
  TimePoint time_point() const noexcept { return held_->time_point; }
  [[deprecated("qdot: say time_point()")]] TimePoint moment() const noexcept { return time_point(); }
  Eigen::Map<const Eigen::VectorXd> y() const noexcept { return {held_->y, held_->size}; }
  int order() const { return held_->order(); }
  bool has_fixed_step() const noexcept { return held_->fixed; }
  /// Whether the last step lies on one branch of functors that branch, by the stepper's own care.
  bool ends_at_branches() const noexcept { return held_->ends_at_branches; }
  /// Whether evaluations go by the branch that functors had at the last reset, beyond its guards as well, as hold_branches() asks.
  bool holds_branch() const noexcept { return held_->holds_branch; }
  /// Asks the stepper for that, where it can.
  void hold_branches(bool wish) { held_->hold_branches(wish); }
  /// Lets the next reset hold the branch of another state, right ahead of its own.
  void hold_next_of(double t, const Eigen::VectorXd& y) { held_->hold_next_of(t, y); }
  /// How many branches of functors the stepper has recorded.
  long recordings() const noexcept { return held_->recordings(); }
  const Statistics& statistics() const noexcept { return *held_->statistics; }
  PolynomialView polynomial() { return held_->polynomial(); }
  void interpolate(double t, Eigen::Ref<Eigen::VectorXd> out) { held_->polynomial().evaluate(t, out); }

 private:
  // What is asked for at every step lies open; the rest is asked through the table.
  struct Held {
    double t = 0.0, t_previous = 0.0;
    TimePoint time_point;
    const double* y = nullptr;
    Eigen::Index size = 0;
    bool fixed = false, ends_at_branches = false, holds_branch = false;
    const Statistics* statistics = nullptr;

    virtual ~Held() = default;
    virtual void reset(const TimePoint& at, const Eigen::Ref<const Eigen::VectorXd>& state) = 0;
    virtual bool step(double t_limit) = 0;
    virtual void tolerate(const Eigen::VectorXd& atol) = 0;
    virtual bool is_current() = 0;
    virtual const Failure& failure() const = 0;
    virtual int order() const = 0;
    virtual long recordings() const noexcept = 0;
    virtual void hold_branches(bool wish) = 0;
    virtual void hold_next_of(double t, const Eigen::VectorXd& y) = 0;
    virtual PolynomialView polynomial() = 0;
  };

  template <class S>
  struct Holder final : Held {
    static_assert(!std::is_same_v<decltype(std::declval<const S&>().y()), Eigen::VectorXd>,
                  "qdot: a stepper must show the state that it keeps, not a copy of it");
    S stepper;

    template <class Make>
    explicit Holder(const Make& make) : stepper(make()) {
      this->fixed = detail::has_fixed_step(stepper);
      look();
    }

    void reset(const TimePoint& at, const Eigen::Ref<const Eigen::VectorXd>& state) override {
      detail::reset_at(stepper, at, state);
      look();
    }
    bool step(double t_limit) override {
      const bool accepted = stepper.step(t_limit);
      look();
      return accepted;
    }
    void tolerate([[maybe_unused]] const Eigen::VectorXd& atol) override {
      if constexpr (requires { stepper.tolerate(atol); }) stepper.tolerate(atol);
    }
    bool is_current() override {
      if constexpr (requires { stepper.is_current(); }) return stepper.is_current();
      return true;
    }
    const Failure& failure() const override { return stepper.failure(); }
    int order() const override { return stepper.order(); }
    long recordings() const noexcept override {
      if constexpr (requires { stepper.recordings(); }) return stepper.recordings();
      return 0;
    }
    void hold_branches([[maybe_unused]] bool wish) override {
      if constexpr (requires { stepper.hold_branches(wish); }) stepper.hold_branches(wish), look();
    }
    void hold_next_of([[maybe_unused]] double time, [[maybe_unused]] const Eigen::VectorXd& at) override {
      if constexpr (requires { stepper.hold_next_of(time, at); }) stepper.hold_next_of(time, at);
    }
    PolynomialView polynomial() override { return stepper.polynomial(); }

    void look() {
      this->t = stepper.t();
      this->t_previous = stepper.t_previous();
      this->time_point = detail::time_point_of(stepper);
      this->y = stepper.y().data();
      this->size = stepper.y().size();
      this->statistics = &stepper.statistics();
      if constexpr (requires { stepper.ends_at_branches(); }) this->ends_at_branches = stepper.ends_at_branches();
      if constexpr (requires { stepper.holds_branch(); }) this->holds_branch = stepper.holds_branch();
    }
  };

  explicit AnyStepper(std::unique_ptr<Held> held) : held_(std::move(held)) {}

  std::unique_ptr<Held> held_;
};

static_assert(Stepper<AnyStepper>);

namespace detail {

/// A stepper of rates, its type hidden; on their constraints, where they have some.
template <class S>
AnyStepper stepper_of_rates(std::unique_ptr<Rates> rates, std::string name, const Options& options) {
  const bool is_constrained = rates->is_constrained();
  const auto made = [&] { return S(std::move(rates), std::move(name), options); };
  if (!is_constrained) return AnyStepper::made_by(made);
  return AnyStepper::made_by([&] { return ProjectingStepper<S>(made()); });
}
struct Dop853Coefficients;  // integrate/steps/runge_kutta_coefficients.hpp

}  // namespace detail

template <class C, int N>
class RungeKuttaStepper;  // integrate/runge_kutta.hpp

#ifdef QDOT_COMPILED
namespace detail {
extern template AnyStepper stepper_of_rates<RungeKuttaStepper<Dop853Coefficients, 2>>(std::unique_ptr<Rates>, std::string, const Options&);
extern template AnyStepper stepper_of_rates<RungeKuttaStepper<Dop853Coefficients, 3>>(std::unique_ptr<Rates>, std::string, const Options&);
extern template AnyStepper stepper_of_rates<RungeKuttaStepper<Dop853Coefficients, 4>>(std::unique_ptr<Rates>, std::string, const Options&);
extern template AnyStepper stepper_of_rates<RungeKuttaStepper<Dop853Coefficients, 5>>(std::unique_ptr<Rates>, std::string, const Options&);
extern template AnyStepper stepper_of_rates<RungeKuttaStepper<Dop853Coefficients, 6>>(std::unique_ptr<Rates>, std::string, const Options&);
extern template AnyStepper stepper_of_rates<RungeKuttaStepper<Dop853Coefficients, 8>>(std::unique_ptr<Rates>, std::string, const Options&);
extern template AnyStepper stepper_of_rates<RungeKuttaStepper<Dop853Coefficients, Dynamic>>(std::unique_ptr<Rates>, std::string, const Options&);
}  // namespace detail
#endif

/// The method's stepper for a first-order system, its type hidden; on constraints, where the system has some.
template <FirstOrderSystem F, SteppingMethod<F> M>
AnyStepper any_stepper(const M& method, const F& system, const Options& options) {
  if constexpr (requires { typename M::template StepperOfRates<F::size_at_compile_time>; }) {
    return detail::stepper_of_rates<typename M::template StepperOfRates<F::size_at_compile_time>>(detail::rates_of(system), std::string(M::name), options);
  } else if constexpr (std::is_same_v<decltype(method.stepper(system, options)), AnyStepper>) return method.stepper(system, options);
  else return AnyStepper::made_by([&] { return detail::projecting_stepper(method, system, options); });
}

/// Any method for one type of system: what a name can stand for.
///
/// @tparam System  a mechanical system, or anything that models FirstOrderSystem
template <class System>
class AnyMethod {
 public:
  using Form = std::remove_cvref_t<decltype(first_order_form(std::declval<const System&>()))>;  ///< the system as steppers see it

  template <class M>
    requires(!std::is_same_v<M, AnyMethod>) && SteppingMethod<M, Form>
  AnyMethod(M method)
      : make_([method = std::move(method)](const Form& form, const Options& options) { return any_stepper(method, form, options); }) {}

  /// A stepper for `system`, which it copies. Allocates all its memory here.
  AnyStepper stepper(const Form& system, const Options& options) const { return make_(system, options); }

 private:
  std::function<AnyStepper(const Form&, const Options&)> make_;
};

}  // namespace qdot
