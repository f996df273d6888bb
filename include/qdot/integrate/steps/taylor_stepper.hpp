#pragma once
// SPDX-License-Identifier: MIT
//
// The stepper of the Taylor method. How it chooses its order and its steps is told in integrate/taylor.hpp.

#include <Eigen/Core>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "qdot/integrate/stepper.hpp"
#include "qdot/integrate/steps/fixed_step.hpp"
#include "qdot/integrate/steps/one_step.hpp"
#include "qdot/integrate/steps/taylor_branches.hpp"

namespace qdot {

/// A Stepper that expands the motion in a power series at each step. Movable.
template <int N>
class TaylorStepper : public detail::OneStep<N> {
  using Base = detail::OneStep<N>;
  using typename Base::Y;
  using Base::epsilon, Base::size;

 public:
  static constexpr bool projects_itself = true;

  /// @param make_series  of an order; may throw NotAnalytic
  /// @throws InvalidValue, DimensionError  for options outside their range
  template <class MakeSeries>
  TaylorStepper(std::unique_ptr<detail::Rates> system, const MakeSeries& make_series, int order, const Options& options)
      : Base(std::move(system), "taylor", order > 0 ? order : order_for(options.rtol), options),
        series_(make_series(this->order_)),
        branches_(series_->branches()),
        is_constrained_(branches_ != nullptr ? this->rates().is_constrained() : series_->constraints() != nullptr),
        ratio_(std::pow(options.rtol, 1.0 / (this->order_ + 1))),
        initial_step_(options.initial_step) {
    detail::require_option(this->order_ >= 4 && this->order_ <= 60, "order", "must lie between 4 and 60", this->order_,
                           "leave it out to have it chosen from rtol");
    this->statistics_.evaluated_by = "power series of recorded formulas";
    dense_.resize(size(), this->order_ + 1);
    std::fill_n(dense_.data(), dense_.size(), 0.0);
    y_new_ = lost_ = lost_new_ = f_new_ = slope_ = this->y_;
    if (branches_ != nullptr) weights_.setZero(size());
  }

  /// The order that costs least for a relative tolerance.
  static int order_for(double rtol) {
    return std::clamp(static_cast<int>(std::ceil(2.0 - 0.5 * std::log(rtol))), 6, 24);
  }

  /// Starts (afresh) at (t, y) with the functors as they are now; evaluates the equations once there.
  ///
  /// @throws as RungeKuttaStepper::reset; NotAnalytic where functors ask for plain numbers, or a constraint branches
  void reset(const TimePoint& at, const Eigen::Ref<const Eigen::VectorXd>& y) {
    this->begin(at, y);
    for (Eigen::Index i = 0; i < size(); ++i)
      if (this->y_[i] == 0.0 && this->atol_[i] == detail::positive_atol(0.0))
        detail::throw_invalid_value({"atol must be positive for taylor where a component starts at 0, as ", this->component_name(i),
                                     " does, but is 0; give it the size below which the component no longer matters, or take Dop853"});
    const double t = this->clock_.shown(this->elapsed_);
    series_->renew();
    if (branches_ != nullptr) branches_->begin(t, this->y_.data());
    steps_before_ = this->statistics_.steps;
    std::fill_n(lost_.data(), size(), 0.0);
    expansion_is_current_ = false;
    unit_ = guard_share_ = 1.0;
    h_last_ = 0.0;
    begin_expansion(t, this->y_);
    for (Eigen::Index i = 0; i < size(); ++i)
      if (!std::isfinite(series_->coefficients()(i, 1))) {
        this->rates().derivative(t, this->y_.data(), slope_.data());  // names what has no value, if that is known
        throw NonFinite(detail::sentence({"the derivative of ", this->component_name(i)}), t,
                        detail::sentence({"the derivative of ", this->component_name(i), " must be finite at the start, but is ",
                                          series_->coefficients()(i, 1),
                                          "; check T and V there for a division by zero, a root or a logarithm of zero"}));
      }
    expansion_is_current_ = true;
  }

  /// One accepted step towards t_limit, landing on it exactly if it comes that far.
  bool step(double t_limit) {
    this->head_for(t_limit);
    if (branches_ != nullptr ? !expand_on_branch() : !expand()) return this->give_up(0.0);
    double h = this->direction_ * std::min(guard_share_ * foretold_step(), this->max_step_);
    guard_share_ = std::min(1.0, 1.5 * guard_share_);
    if (this->statistics_.steps == 0 && initial_step_ > 0.0) h = this->direction_ * std::min(initial_step_, std::abs(h));
    for (int attempts = 0; attempts < 200; ++attempts) {
      const double distance = this->distance_left();
      const bool lands = !(std::abs(h) * (1 + 1e-3) < std::abs(distance));
      double end = lands ? this->clock_.length() : this->clock_.rounded(this->elapsed_ + h, h);
      if (branches_ != nullptr) end = branches_->edge(expansion(), this->clock_, end);
      h = end - this->elapsed_;  // what the sum was rounded to
      Eigen::Index worst = 0;
      double error = 0.0;
      expansion_is_current_ = false;
      const bool evaluated = this->attempt([&] { error = attempted_step(this->clock_.shown(end), h, worst); });
      if (evaluated && error <= 1.0) {
        std::swap(this->y_, y_new_);
        std::swap(lost_, lost_new_);
        expansion_is_current_ = true;
        h_last_ = h;
        if (branches_ != nullptr) expansion_is_current_ = !branches_->land(expansion(), end, this->clock_.length() - end);
        if (is_constrained_) count_projection();
        this->accept(end, worst);
        return true;
      }
      if (!evaluated && this->failure_.outcome == Outcome::stopped_by_model) break;
      ++this->statistics_.rejected_by_error_test;
      if (evaluated && error > 1.0) {
        this->blame_error_test(worst);
        const double shorter = std::clamp(0.9 * std::pow(error, -1.0 / (this->order_ + 1)), 0.05, 0.8);
        h *= shorter;
        if (error == disagreement_) guard_share_ *= shorter;
      } else {
        if (evaluated) this->failure_ = {Outcome::non_finite, "the equations of motion were not finite"};
        h *= 0.25;
      }
      if (std::abs(h) <= this->smallest_step()) break;
      if (is_constrained_)
        if (attempts + 1 >= most_rejections && beside_singular_position()) break;
      if (this->over_budget()) return false;
    }
    return this->give_up(h);
  }

  /// Whether the functors still are the formulas that were recorded at the last reset; asked for only when an observer may have come between.
  bool is_current() { return this->statistics_.steps <= steps_before_ + 1 || series_->is_current(); }

  /// Whether functors branch; then no step passes over a branch.
  bool ends_at_branches() const noexcept { return branches_ != nullptr; }
  /// How many branches have been recorded, those that were forgotten and recorded again counted as often.
  long recordings() const noexcept { return branches_ != nullptr ? branches_->recordings() : 0; }

  /// The last step's series.
  PolynomialView polynomial() {
    if (h_last_ == 0.0) return this->view(this->elapsed_, 1.0, this->y_.data(), 0);
    return this->view(this->elapsed_before_, dense_unit_, dense_.data(), this->order_);
  }

  /// out ← y(t) for t within the last step.
  void interpolate(double t, Eigen::Ref<Eigen::VectorXd> out) { polynomial().evaluate(t, out); }

 private:
  static constexpr int window = 6;  // coefficients that foretell the step
  static constexpr double rounding_wanted = 1e-14;  // below this rtol the series' own error must drown in rounding
  // What the series leaves out has a sign: it pulls the energy by 5e-13 over 10⁴ Kepler periods at rtol = 2.5e-15. With this margin, half as many
  // steps again, the energy walks at random, 1e-14 over the same time.
  static constexpr double rounding_margin = 256.0;
  static constexpr int most_rejections = 6;    // in a row, where constraints are nearly dependent
  static constexpr double weak_pivot = 1e-6;   // of nearly dependent rows: their sine is a thousandth

  void begin_expansion(double t, const Y& y) {
    ++this->statistics_.evaluations;
    series_->start(t, y.data(), unit_);
  }

  // The series about the present state, as a polynomial.
  PolynomialView expansion() const { return this->view(this->elapsed_, dense_unit_, dense_.data(), this->order_); }

  // As expand(), on the branch that the motion takes from here.
  [[gnu::cold]] bool expand_on_branch() {
    for (bool stays = false; !stays;) {
      const double t = this->clock_.shown(this->elapsed_);
      const bool turned = this->attempt([&] {
        if (!branches_->turn(t, this->y_.data())) return;
        expansion_is_current_ = false;
        unit_ = branch_unit_;
      });
      if (!turned || !expand()) return false;
      const double way = std::min({foretold_step(), this->max_step_, std::abs(this->distance_left())});
      branch_unit_ = std::exp2(std::round(std::log2(way)));
      const double least = this->clock_.least_step(this->elapsed_);
      if (!this->attempt([&] { stays = branches_->stays(this->elapsed_, this->direction_ * way, least); })) return false;
    }
    return true;
  }

  // All coefficients at the present state, in dense_; false if they are not finite in any unit of time.
  bool expand() {
    for (int attempts = 0; attempts < 4; ++attempts) {
      const bool expanded = this->attempt([&] {
        if (!expansion_is_current_) begin_expansion(this->clock_.shown(this->elapsed_), this->y_);
        series_->expand(this->order_);
      });
      if (!expanded) return false;
      std::copy_n(series_->coefficients().data(), dense_.size(), dense_.data());
      dense_unit_ = unit_;
      if (is_finite() && (branches_ == nullptr || branches_->not_finite().empty())) return true;
      unit_ *= 1e-6;  // too fast for this unit of time: coefficients overflow
      expansion_is_current_ = false;
    }
    unit_ = 1.0;
    const std::string guard = branches_ != nullptr && is_finite() ? branches_->not_finite() : std::string();
    this->failure_ = {Outcome::non_finite,
                      guard.empty() ? "the Taylor coefficients are not finite, so T or V are not analytic at this state (a root or a broken "
                                      "power of zero, a pole); Dop853 needs no more than finite forces"
                                    : detail::sentence({guard, " finds what has no power series here (a root or a broken power of zero, a pole, no "
                                                               "number at all), so it has no side to take"})};
    return false;
  }

  // Whether all coefficients are, column by column.
  bool is_finite() {
    Y& zero = slope_;
    std::fill_n(zero.data(), size(), 0.0);
    for (Eigen::Index k = 0; k < dense_.cols(); ++k)
      for (Eigen::Index i = 0; i < size(); ++i) zero[i] += dense_(i, k) - dense_(i, k);
    double sum = 0.0;
    for (Eigen::Index i = 0; i < size(); ++i) sum += zero[i];
    return sum == 0.0;
  }

  // log₂ x to 0.09, from its exponent and leading bits: enough to tell which of six coefficients asks for the shortest step.
  static double rough_log2(double x) { return static_cast<double>(std::bit_cast<std::int64_t>(x)) * 0x1p-52 - 1023.0; }

  // The longest |h| that the last coefficients allow.
  double foretold_step() {
    const int p = this->order_;
    Y& scale = slope_;
    for (Eigen::Index i = 0; i < size(); ++i) scale[i] = 1.0 / this->weight(i, this->y_[i], this->y_[i]);
    double steepest = -std::numeric_limits<double>::infinity(), decisive = 0.0;  // −log₂ h, roughly; the coefficient that decides it
    int at = 1;
    double share = this->rtol_ < rounding_wanted ? rounding_margin : 1.0;  // times σ^{p+1−j}
    for (int j = p; j > std::max(p - window, 0); --j) {
      share *= ratio_;
      double largest = 0.0;
      for (Eigen::Index i = 0; i < size(); ++i) largest = std::max(largest, std::abs(dense_(i, j)) * scale[i]);
      const double a = share * largest;
      const double slope = a > 0.0 ? rough_log2(a) / j : -std::numeric_limits<double>::infinity();
      if (slope > steepest) {
        steepest = slope;
        decisive = a;
        at = j;
      }
    }
    const double shortest = decisive > 0.0 ? std::pow(decisive, -1.0 / at) : std::numeric_limits<double>::infinity();
    return 0.95 * shortest * unit_;
  }

  // P(h), projected onto constraints, into y_new_, the next expansion begun there; returns the weighted defect. A rejection costs one evaluation,
  // not an expansion.
  double attempted_step(double t_new, double h, Eigen::Index& worst) {
    const int p = this->order_;
    const double s = h / dense_unit_;
    // P(h) − y and P′: the sum without its first term, so that the last addition can be compensated.
    double *const change = f_new_.data(), *const slope = slope_.data();
    for (Eigen::Index i = 0; i < size(); ++i) {
      change[i] = dense_(i, p);
      slope[i] = p * dense_(i, p);
    }
    for (int k = p - 1; k >= 1; --k)
      for (Eigen::Index i = 0; i < size(); ++i) {
        const double c = dense_(i, k);
        change[i] = change[i] * s + c;
        slope[i] = slope[i] * s + k * c;
      }
    y_new_ = this->y_;
    lost_new_ = lost_;
    for (Eigen::Index i = 0; i < size(); ++i) detail::add_compensated(y_new_[i], lost_new_[i], change[i] * s);
    unit_ = std::exp2(std::round(std::log2(std::abs(h))));
    if (is_constrained_) {
      const ProjectionReport report = this->rates().project(t_new, y_new_);
      residual_ = report.residual;
      velocity_residual_ = report.velocity_residual;
    }
    begin_expansion(t_new, y_new_);

    double largest = 0.0;
    for (Eigen::Index i = 0; i < size(); ++i) {
      const double there = h / unit_ * series_->coefficients()(i, 1);
      const double here = s * slope_[i];
      const double defect = std::abs(here - there);
      if (!std::isfinite(defect)) return std::numeric_limits<double>::quiet_NaN();
      const double rounding = 64 * epsilon * (std::abs(here) + std::abs(there)) + 4 * epsilon * std::abs(y_new_[i]);
      const double part = (defect - rounding) / ((p + 1) * this->weight(i, this->y_[i], y_new_[i]));
      if (part > largest) {
        largest = part;
        worst = i;
      }
    }
    if (branches_ != nullptr) largest = std::max(largest, disagreement_ = disagreement(t_new, h));
    return largest;
  }

  // Of guards with their series, at the end of a step, in units of what the tolerance makes of them.
  [[gnu::cold]] double disagreement(double t_new, double h) {
    for (Eigen::Index i = 0; i < size(); ++i) weights_[i] = 10 * this->weight(i, this->y_[i], y_new_[i]);
    return branches_->disagreement(this->elapsed_, this->elapsed_ + h, t_new, y_new_.data(), weights_);
  }

  // If so, with that as the failure.
  bool beside_singular_position() {
    const detail::ConstraintPart& rows = *series_->constraints();
    if (rows.weakest_pivot() > weak_pivot) return false;
    this->failure_ = {Outcome::constraint_failure,
                      detail::sentence({"'", rows.weakest_name(), "' hardly differs from the other constraints here (by a sine of ",
                                        std::sqrt(rows.weakest_pivot()),
                                        "), as in a singular position, and a power series needs them to be independent; use Dop853, or Automatic"})};
    return true;
  }

  void count_projection() {
    ++this->statistics_.projections;
    this->statistics_.constraint_residual = std::max(this->statistics_.constraint_residual, residual_);
    this->statistics_.constraint_velocity = std::max(this->statistics_.constraint_velocity, velocity_residual_);
  }

  std::unique_ptr<detail::PowerSeries> series_;
  detail::SeriesBranches* branches_;  // of series_, where there are some
  bool is_constrained_;
  double ratio_;  // of h to the radius of convergence that is aimed at
  double initial_step_;
  double unit_ = 1.0;        // of time in series_
  double dense_unit_ = 1.0;  // of time in dense_
  double branch_unit_ = 1.0; // that suits steps here, on whatever branch
  double guard_share_ = 1.0, disagreement_ = 0.0;  // of a step, for which series of guards are good; of guards in the last attempt
  double h_last_ = 0.0;
  long steps_before_ = 0;    // the last reset
  double residual_ = 0.0, velocity_residual_ = 0.0;  // of y_new_ on the constraints
  bool expansion_is_current_ = false;  // series_ was begun at the present state
  Y y_new_, f_new_, slope_, lost_, lost_new_;
  Matrix<double, Base::size_at_compile_time, Dynamic> dense_;
  Eigen::VectorXd weights_;  // of components, where there are branches
};

}  // namespace qdot
