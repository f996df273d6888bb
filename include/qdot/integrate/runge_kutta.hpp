#pragma once
// SPDX-License-Identifier: MIT
//
// Explicit Runge–Kutta steps, unrolled: Dop853 (order 8, the general choice) and Dopri5 (order 5, few digits).
//
// The compiler knows the coefficients, and the size of y where n is fixed. Every Σⱼ aᵢⱼ kⱼ becomes straight-line code without zero
// terms: a step of two coordinates has a few tens of nanoseconds of its own, a multistep code's one or two microseconds. With
// k₁ … k_s and y₁ = y + h Σ bⱼ kⱼ a step is accepted if err ≤ 1, and the next one is, by a proportional–integral controller,
//
//     h · 0.9 · err^(−α) · err_before^β ,      β = 0.2/order,  α = 1/order − 0.75 β        (β damps h at the limit of stability)
//
// err is the root mean square of h Σ eⱼ kⱼ in units of rtol |yᵢ| + atolᵢ. Dop853 has two estimates, of order 5 and 3, and takes
// e₅² / √(e₅² + 0.01 e₃²), which behaves like h⁸ and is not fooled by an e₅ that vanishes by chance. Dense output
//
//     y(t + s h) = y + s (F₀ + (1 − s)(F₁ + s (F₂ + (1 − s)(F₃ + …)))),   F₀ = Δ = y₁ − y, F₁ = h k₁ − Δ, F₂ = 2Δ − h(k₁ + k_new)
//
// has order 7 (Dop853, by three evaluations where it is asked for) or 4 (Dopri5).  (Hairer, Nørsett, Wanner I, II.4–II.6, II.10)

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "qdot/integrate/stepper.hpp"
#include "qdot/integrate/steps/first_step.hpp"
#include "qdot/integrate/steps/fixed_step.hpp"
#include "qdot/integrate/steps/one_step.hpp"
#include "qdot/integrate/steps/runge_kutta_coefficients.hpp"
#include "qdot/integrate/steps/runge_kutta_sums.hpp"

namespace qdot {

/// A Stepper that takes explicit Runge–Kutta steps with the coefficients C. Movable.
template <class C, int N>
class RungeKuttaStepper : public detail::OneStep<N> {
  using Base = detail::OneStep<N>;
  using typename Base::Y;
  using Base::epsilon, Base::size;
  static constexpr int degree = 3 + static_cast<int>(C::dense.size());  // of the dense output

 public:
  /// @throws InvalidValue, DimensionError  for options outside their range
  RungeKuttaStepper(std::unique_ptr<detail::Rates> system, std::string name, const Options& options);

  /// Starts (afresh) at (t, y); evaluates f once there.
  ///
  /// @throws DimensionError, InvalidValue  y has the wrong size, or t or y is not finite
  /// @throws NonFinite, MassMatrixError    the model has no finite derivative there; and the model's own
  void reset(const TimePoint& at, const Eigen::Ref<const Eigen::VectorXd>& y);

  /// Replaces the state at t() by a nearby one, such as its projection onto constraints; evaluates f once there if it moved.
  void correct(const Eigen::Ref<const Eigen::VectorXd>& y) {
    if (std::equal(y.data(), y.data() + size(), this->y_.data())) return;
    for (Eigen::Index i = 0; i < size(); ++i)
      if (this->y_[i] != y[i]) lost_[i] = 0.0;
    std::copy_n(y.data(), size(), this->y_.data());
    this->evaluate(this->elapsed_, this->y_, f_);
    if (!dense_is_current_) std::copy_n(k_.data(), size(), k_last_.data());  // dense output still ends where the step did
    corrected_ = true;
    std::copy_n(f_.data(), size(), k_.data());
  }

  /// One accepted step towards t_limit, landing on it exactly if it comes that far.
  bool step(double t_limit);

  /// The last step's dense output, of degree 7 (Dop853: three evaluations) or 4 (Dopri5).
  ///
  /// Where the model cannot be evaluated for it, the cubic through both ends and their derivatives.
  PolynomialView polynomial() {
    if (h_last_ == 0.0) return this->view(this->elapsed_, 1.0, this->y_.data(), 0);
    if (!dense_is_current_) make_dense();
    return this->view(this->elapsed_before_, h_last_, dense_.data(), degree);
  }

  /// out ← y(t) for t within the last step.
  void interpolate(double t, Eigen::Ref<Eigen::VectorXd> out) { polynomial().evaluate(t, out); }

 private:
  static constexpr double beta = 0.2 / C::order;                   // of the integral part
  static constexpr double exponent = 1.0 / C::order - 0.75 * beta; // of the proportional part

  // Whether an estimate of the error needs f(t₁, y₁).
  static constexpr bool needs_end = [] {
    bool needs = C::e[C::stages] != 0.0;
    if constexpr (C::two_errors) needs = needs || C::e_low[C::stages] != 0.0;
    return needs;
  }();

  // Stages, new state and f there; returns the weighted error, which is NaN where f was. A function of its own: in large files GCC would
  // inline it into the loop of the run, where registers are short. A run of a double pendulum then takes 1.2 times as long.
  double attempted_step(double end, double h, Eigen::Index& worst);

  // Column `row` of k ← f less k₁. Since Σⱼ aᵢⱼ = cᵢ and Σ bⱼ = 1, h (cᵢ k₁ + Σⱼ aᵢⱼ (kⱼ − k₁)) is taken for h Σⱼ aᵢⱼ kⱼ. The weights alternate and
  // are rounded, the same error in each step: Σ bᵢ Σⱼ aᵢⱼ is ½ + 4.6e-16, and the energy goes one way. Beside differences, smaller by h, such
  // errors count an order less; what rounding leaves of ½ − Σ bᵢ cᵢ is known and added (`half_defect`).
  void write_difference(int row) { detail::write_difference<N>(f_.data(), k_.data(), k_.data() + row * size(), size()); }

  template <std::size_t... i>
  void take_stages(double h, std::index_sequence<i...>) {
    (take_stage<static_cast<int>(i) + 1>(this->elapsed_, this->y_, lost_, h), ...);
  }

  template <int row>
  void take_stage(double elapsed, const Y& base, const Y& lost, double h) {
    detail::write_stage<detail::StageRow<C, row>>(k_, C::c[row], h, base.data(), lost.data(), stage_.data());
    this->evaluate(elapsed + C::c[row] * h, stage_, f_);
    write_difference(row);
  }

  // ‖h Σ eⱼ kⱼ / (rtol |yᵢ| + atolᵢ)‖, and the component with the largest share.
  double weighted_error(double h, Eigen::Index& worst);
  void plan_next(double h, double error, bool rejected_before) {
    double factor = 0.9 * std::pow(std::max(error, 1e-10), -exponent) * std::pow(error_before_, beta);
    factor = std::clamp(factor, 1.0 / 3.0, rejected_before ? 1.0 : 6.0);
    const bool was_cut = std::abs(h) < std::abs(h_);  // to land: the plan for a free step still holds
    const double next = was_cut ? std::max(std::abs(h_), std::abs(h) * factor) : std::abs(h) * factor;
    h_ = this->direction_ * std::min(next, this->max_step_);
    error_before_ = std::max(error, 1e-4);
  }

  // A first |h|, unless one is given.
  double first_step();
  void make_dense();
  // F₀ … F_m, a column each; those after F₂ are zero without the dense output's stages.
  void write_quotients(double h, const Y& k_new, bool complete);

  // y + s (F₀ + (1 − s)(F₁ + s (F₂ + …))) as powers of s, innermost bracket first. What a bracket begins with is from the start where it
  // ends up, so that a factor s costs nothing, and 1 − s a subtraction for each power that is there.
  void multiply_out();

  [[noreturn, gnu::cold, gnu::noinline]] void throw_non_finite() const;
  double initial_step_;
  double share_;               // of a unit that the estimate may be is 1/share_: 1/64 for rtol < 1e-14, where the error's sign must drown in rounding
  double h_ = 0.0;             // planned, with its sign; 0 before the first step
  double h_last_ = 0.0;        // taken; 0 before the first step
  double error_before_ = 1e-4;
  bool dense_is_current_ = false;
  bool corrected_ = false;     // since the last step
  Y y_old_, y_new_, stage_, f_, sums_, low_sums_, k_first_, k_last_;
  Y lost_, lost_new_;                    // of y_, y_new_ by rounding (integrate/steps/fixed_step.hpp); after a step lost_new_ is y_old_'s
  Matrix<double, N, C::total> k_;        // k₁; less k₁: k₂ … k_s, f(t₁, y₁), the dense output's stages
  Matrix<double, N, degree> quotient_;   // F₀ … F_m
  Matrix<double, N, degree + 1> dense_;  // coefficients of powers of s, a column each
};

template <class C, int N>
RungeKuttaStepper<C, N>::RungeKuttaStepper(std::unique_ptr<detail::Rates> system, std::string name, const Options& options)
    : Base(std::move(system), std::move(name), C::order, options),
      initial_step_(options.initial_step),
      share_(options.rtol < 1e-14 ? 64.0 : 1.0) {
  const Eigen::Index n = this->y_.size();
  k_.resize(n, C::total);
  std::fill_n(k_.data(), k_.size(), 0.0);
  quotient_.resize(n, degree);
  dense_.resize(n, degree + 1);
  y_new_ = y_old_ = stage_ = f_ = sums_ = low_sums_ = k_first_ = k_last_ = lost_ = lost_new_ = this->y_;  // zeros
}

template <class C, int N>
void RungeKuttaStepper<C, N>::reset(const TimePoint& at, const Eigen::Ref<const Eigen::VectorXd>& y) {
  this->begin(at, y);
  this->evaluate(this->elapsed_, this->y_, stage_);
  if (!detail::all_finite(stage_)) throw_non_finite();
  std::copy_n(stage_.data(), size(), k_.data());
  std::fill_n(lost_.data(), size(), 0.0);
  lost_new_ = lost_;
  h_ = 0.0;
  h_last_ = 0.0;
  error_before_ = 1e-4;
  dense_is_current_ = false;
}

template <class C, int N>
bool RungeKuttaStepper<C, N>::step(double t_limit) {
  this->head_for(t_limit);
  if (h_ == 0.0) h_ = this->direction_ * first_step();
  double h = h_;
  bool rejected_before = false;
  for (int attempts = 0; attempts < 200; ++attempts) {
    const double distance = this->distance_left();
    const bool lands = std::abs(h) * (1 + 1e-3) >= std::abs(distance);
    if (lands) h = distance;
    // A step is what the sum was rounded to; otherwise the clock would lose 1e-13 s at 2000 s in each.
    const double end = lands ? this->clock_.length() : this->clock_.rounded(this->elapsed_ + h, h);
    const double taken = end - this->elapsed_;
    double error = 0.0;
    Eigen::Index worst = 0;
    const bool evaluated = this->attempt([&] { error = attempted_step(end, taken, worst); });
    if (evaluated && error <= 1.0) {
      plan_next(h, error, rejected_before);
      y_old_ = std::exchange(this->y_, y_new_);  // y_new_ stays the step's own end
      std::swap(lost_, lost_new_);
      std::copy_n(k_.data(), size(), k_first_.data());
      std::copy_n(f_.data(), size(), k_.data());
      h_last_ = taken;
      dense_is_current_ = false;
      corrected_ = false;
      this->accept(end, worst);
      return true;
    }
    if (!evaluated && this->failure_.outcome == Outcome::stopped_by_model) return this->give_up(h);
    ++this->statistics_.rejected_by_error_test;
    rejected_before = true;
    if (evaluated && error > 1.0) {
      this->blame_error_test(worst);
      h *= std::max(0.2, 0.9 * std::pow(error, -exponent));
    } else {
      if (evaluated) this->failure_ = {Outcome::non_finite, "the right-hand side was not finite"};
      h *= 0.25;
    }
    h_ = h;
    if (std::abs(h) <= this->smallest_step()) break;
    if (this->over_budget()) return false;
  }
  return this->give_up(h);
}

template <class C, int N>
[[gnu::noinline]] double RungeKuttaStepper<C, N>::attempted_step(double end, double h, Eigen::Index& worst) {
  take_stages(h, std::make_index_sequence<C::stages - 1>{});
  detail::write_end<detail::StageRow<C, C::stages>>(k_, C::half_defect, C::stages - 1, h, this->y_.data(), lost_.data(), y_new_.data(), lost_new_.data());
  double error = 0.0;
  if constexpr (!needs_end) error = weighted_error(h, worst);
  if (!(error <= 1.0)) return error;
  this->evaluate(end, y_new_, f_);
  write_difference(C::stages);
  if constexpr (needs_end) error = weighted_error(h, worst);
  return detail::all_finite(f_) ? error : std::numeric_limits<double>::quiet_NaN();
}

template <class C, int N>
double RungeKuttaStepper<C, N>::weighted_error(double h, Eigen::Index& worst) {
  double sum = 0.0, sum_low = 0.0, largest = -1.0;
  detail::write_weighted_sums<detail::ErrorRow<C>>(k_, 1.0, sums_.data());
  if constexpr (C::two_errors) detail::write_weighted_sums<detail::LowErrorRow<C>>(k_, 1.0, low_sums_.data());
  for (Eigen::Index i = 0; i < size(); ++i) {
    const double scale = 1.0 / this->weight(i, this->y_[i], y_new_[i]);
    const double e = sums_[i] * scale;
    sum += e * e;
    if constexpr (C::two_errors) {
      const double e_low = low_sums_[i] * scale;
      sum_low += e_low * e_low;
    }
    if (e * e > largest) {
      largest = e * e;
      worst = i;
    }
  }
  const double n = static_cast<double>(size());
  if constexpr (C::two_errors) {
    const double both = sum + 0.01 * sum_low;
    return both == 0.0 ? 0.0 : share_ * std::abs(h) * sum / std::sqrt(n * both);
  } else {
    return share_ * std::abs(h) * std::sqrt(sum / n);
  }
}

template <class C, int N>
double RungeKuttaStepper<C, N>::first_step() {
  const double distance = std::abs(this->distance_left());
  if (initial_step_ > 0.0) return std::min(initial_step_, distance);
  const auto weight = [&](Eigen::Index i) { return this->weight(i, this->y_[i], this->y_[i]); };
  return detail::first_step(C::order, size(), this->y_.data(), k_.data(), weight, std::min(this->max_step_, distance), [&](double h) -> const double* {
    const auto probe = [&] {
      for (Eigen::Index i = 0; i < size(); ++i) stage_[i] = this->y_[i] + this->direction_ * h * k_(i, 0);
      this->evaluate(this->elapsed_ + this->direction_ * h, stage_, f_);
    };
    return this->attempt(probe) ? f_.data() : nullptr;
  });
}

template <class C, int N>
void RungeKuttaStepper<C, N>::make_dense() {
  const double h = h_last_;
  const Y k_start = Eigen::Map<const Y>(k_.data(), size());
  const Y k_new = corrected_ ? k_last_ : k_start;
  std::copy_n(k_first_.data(), size(), k_.data());
  detail::write_difference<N>(k_new.data(), k_first_.data(), k_.data() + C::stages * size(), size());
  const bool complete = this->attempt([&] {
    [&]<std::size_t... i>(std::index_sequence<i...>) {
      (take_stage<C::stages + 1 + static_cast<int>(i)>(this->elapsed_before_, y_old_, lost_new_, h), ...);
    }(std::make_index_sequence<static_cast<std::size_t>(C::dense_stages)>{});
  });
  write_quotients(h, k_new, complete);
  multiply_out();
  std::copy_n(k_start.data(), size(), k_.data());
  dense_is_current_ = true;
}

template <class C, int N>
void RungeKuttaStepper<C, N>::write_quotients(double h, const Y& k_new, bool complete) {
  const Eigen::Index n = size();
  double* const first = quotient_.data();
  detail::in_components<N>(n, [&]<class Some>(Eigen::Index i) __attribute__((always_inline)) {
    Some before, after, slope, slope_after;
    detail::read(before, y_old_.data() + i);
    detail::read(after, y_new_.data() + i);
    detail::read(slope, k_first_.data() + i);
    detail::read(slope_after, k_new.data() + i);
    const Some change = after - before;
    detail::write(first + i, change);
    detail::write(first + n + i, h * slope - change);
    detail::write(first + 2 * n + i, 2.0 * change - h * (slope + slope_after));
  });
  double* const others = first + 3 * n;
  if (!complete) {
    std::fill_n(others, n * (degree - 3), 0.0);
    return;
  }
  [&]<std::size_t... m>(std::index_sequence<m...>) {
    (detail::write_weighted_sums<detail::DenseRow<C, m>>(k_, h, others + static_cast<Eigen::Index>(m) * n), ...);
  }(std::make_index_sequence<C::dense.size()>{});
}

template <class C, int N>
void RungeKuttaStepper<C, N>::multiply_out() {
  const Eigen::Index n = size();
  const auto power = [&](int p) { return dense_.data() + p * n; };
  std::fill_n(power(0), dense_.size(), 0.0);
  std::copy_n(y_old_.data(), n, power(0));
  for (int m = degree - 1, top = m / 2 + 1; m >= 0; --m) {
    const int lowest = m / 2 + 1;
    detail::write_sum<N>(power(lowest), quotient_.data() + m * n, 1.0, n);
    if (m % 2 == 0) continue;
    for (int p = top++; p >= lowest; --p) detail::write_sum<N>(power(p + 1), power(p), -1.0, n);
  }
}

template <class C, int N>
[[noreturn, gnu::cold, gnu::noinline]] void RungeKuttaStepper<C, N>::throw_non_finite() const {
  for (Eigen::Index i = 0; i < size(); ++i)
    if (!std::isfinite(stage_[i]))
      throw NonFinite(detail::sentence({"the derivative of ", this->component_name(i)}), this->t_,
                      detail::sentence({"the derivative of ", this->component_name(i), " must be finite at the start, but is ", stage_[i],
                                        "; check the right-hand side there"}));
  throw NonFinite("the derivative", this->t_, "the derivative must be finite at the start; check the right-hand side");
}

/// Explicit Runge–Kutta of order 8 with dense output of order 7: smooth motion, 1e-5 to 1e-13.
struct Dop853 {
  template <int size>
  using StepperOfRates = RungeKuttaStepper<detail::Dop853Coefficients, size>;  ///< of so many components
  static constexpr std::string_view name = "dop853";  ///< as statistics call it

  /// A stepper for `system`, which it copies. Allocates all its memory here.
  template <FirstOrderSystem F>
  StepperOfRates<F::size_at_compile_time> stepper(const F& system, const Options& options) const {
    return {detail::rates_of(system), std::string(name), options};
  }
};

/// Explicit Runge–Kutta of order 5 with dense output of order 4: smooth motion, few digits.
struct Dopri5 {
  template <int size>
  using StepperOfRates = RungeKuttaStepper<detail::Dopri5Coefficients, size>;  ///< for so many components, or Dynamic
  static constexpr std::string_view name = "dopri5";  ///< as statistics call it

  /// A stepper for `system`, which it copies. Allocates all its memory here.
  template <FirstOrderSystem F>
  StepperOfRates<F::size_at_compile_time> stepper(const F& system, const Options& options) const {
    return {detail::rates_of(system), std::string(name), options};
  }
};

}  // namespace qdot
