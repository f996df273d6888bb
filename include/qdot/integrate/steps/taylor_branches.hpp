#pragma once
// SPDX-License-Identifier: MIT
//
// Power series of functors that branch.
//
// Functors that compare, take `abs`, `min` or `floor`, are one formula as long as their guards keep their signs (ad/formula/branches.hpp).
// Each branch that a motion meets is recorded once, with its guards g as outputs, and has series of its own:
//
//     the step        the branch's series is good for h; the first x ≤ h at which a guard changes sides is isolated (first_descent.hpp)
//     the edge        the step ends at x, where g itself and not only its series is zero to its last digits
//     beyond          the branch whose comparisons are the same up to this guard, and answer the other way there
//
// So every step lies on one branch and no order is lost, in both directions of time. At an edge rounding decides about the value of g,
// so its coefficients of higher order decide about the side. If they lead to another branch, that one is tried. If every branch leads
// to one that was tried, as friction does on a body at rest, or edges crowd, the run ends as zeno. A motion that starts on a guard and
// may leave it to both sides is not unique: refused_by_model. Functors that ask for a plain value (isnan, innermost_value) are refused,
// for no guard holds it; so are constraints that branch.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "qdot/ad/formula/branches.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/time_point.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/steps/first_descent.hpp"
#include "qdot/integrate/steps/kept_branches.hpp"
#include "qdot/integrate/steps/polynomial.hpp"
#include "qdot/integrate/steps/neighbouring_branches.hpp"
#include "qdot/integrate/steps/taylor_equations.hpp"

namespace qdot::detail {

/// What a stepper asks about the branches of a series. Times are what has elapsed; y is a state as doubles.
struct SeriesBranches {
  virtual ~SeriesBranches() = default;
  /// Begins at a state, on the branch that functors take there.
  virtual void begin(double t, const double* y) = 0;
  /// Goes over to the branch beyond the guard at which the present one ends; false if it does not end here.
  ///
  /// @throws EndOfRun  zeno, where no branch holds the motion
  virtual bool turn(double t, const double* y) = 0;
  /// Whether the motion, which has been expanded, stays on the branch for longer than `least`, on a way to which it looks ahead.
  virtual bool stays(double elapsed, double way, double least) = 0;
  /// `end`, or where the motion leaves the branch before it.
  virtual double edge(const PolynomialView& motion, const Clock& clock, double end) = 0;
  /// How far guards are from their series at the end of a step, in units of what weights of the components allow.
  virtual double disagreement(double from, double end, double t, const double* y, const Eigen::VectorXd& weights) = 0;
  /// Notes that a step ends here; true if the branch does as well.
  virtual bool land(const PolynomialView& motion, double end, double way_left) = 0;
  /// A guard whose series is not finite, for messages; empty where all are.
  virtual std::string not_finite() const = 0;
  /// How many branches have been recorded.
  virtual long recordings() const noexcept = 0;
};

/// The power series of a motion whose functors branch.
template <class = void>  // compiled only where it is made
class BranchedSeries final : public PowerSeries, public SeriesBranches {
 public:
  /// @throws InvalidValue  of a system that is to be evaluated by dual numbers
  BranchedSeries(std::shared_ptr<const MotionSource> source, int highest_order) : all_((static_cast<void>(source->by()), std::move(source)), highest_order) {}

  void renew() override {
    if (!is_current()) all_.clear(), now_ = nullptr, holds_ = true;
  }
  bool is_current() override {
    const bool held = std::exchange(holds_, false);  // as long as functors may throw
    return holds_ = held && all_.hold();
  }
  void start(double t, const double* y, double time_unit) override { now_->series->start(t_ = t, y, unit_ = time_unit); }
  void expand(int order) override { guard_unit_ = unit_, expanded_at_ = t_, now_->series->expand(order); }
  const Eigen::MatrixXd& coefficients() const noexcept override { return now_->series->coefficients(); }
  const ConstraintPart* constraints() const noexcept override { return now_->series->constraints(); }
  SeriesBranches* branches() noexcept override { return this; }

  void begin(double t, const double* y) override {
    sizes_.clear(), tried_.clear();
    left_at_ = none, is_fresh_ = true, edges_ = 0, is_crowded_ = false;
    now_ = all_.at({}, t, y, [](const Branch&, std::size_t) { return -1.0; });
  }
  bool turn(double t, const double* y) override;
  bool stays(double elapsed, double way, double least) override;
  double edge(const PolynomialView& motion, const Clock& clock, double end) override;
  double disagreement(double from, double end, double t, const double* y, const Eigen::VectorXd& weights) override;
  bool land(const PolynomialView& motion, double end, double way_left) override;
  long recordings() const noexcept override { return all_.recordings(); }
  std::string not_finite() const override {
    const Eigen::MatrixXd& c = now_->series->guard_coefficients();
    for (Index k = 0; k < c.rows(); ++k)
      if (!c.row(k).allFinite()) return now_->guards()[static_cast<std::size_t>(k)].what;
    return {};
  }

 private:
  using Index = Eigen::Index;
  using Branch = SeriesBranch;
  using Guards = SeriesBranch::Guards;
  static constexpr std::size_t none = static_cast<std::size_t>(-1);
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();
  static constexpr double rounding = 64 * epsilon;   // of a component, in units of its size in a step
  static constexpr double hiding = 1e6;              // a series whose last terms are so much larger than what it adds up to has diverged
  static constexpr int crowd = 128;                  // edges in a row that must take longer than …
  static constexpr double crowded = 1e-9;            // … this part of the way

  // The size of guard k that rounding alone makes at the present edge; nothing where the motion was set on it.
  double noise(const Branch& branch, std::size_t k, double t, const double* y) {
    return sizes_.empty() ? 0.0 : all_.change(branch, k, t, y, sizes_.data(), rounding * std::abs(t));
  }
  Branch* beyond(const Guards& answers, double t, const double* y) {
    return all_.at(answers, t, y, [&](const Branch& branch, std::size_t k) { return noise(branch, k, t, y); });
  }
  [[noreturn]] void refuse_here(const char* how) const;
  void refuse_two_ways(double way);

  // Guard k over a way, as a polynomial of the part of the way.
  ShortPolynomial along(std::size_t k, double way) const {
    const formula::Guard& guard = now_->guards()[k];
    const Eigen::MatrixXd& c = now_->series->guard_coefficients();
    ShortPolynomial p;
    p.degree = static_cast<int>(c.cols()) - 1;
    double power = guard.sign;
    for (Index j = 0; j < c.cols(); ++j, power *= way / guard_unit_) {
      const double coefficient = c(static_cast<Index>(k), j);
      p.c[static_cast<std::size_t>(j)] = coefficient == 0.0 ? 0.0 : power * coefficient;  // a long way may have powers that are infinite
    }
    p.c[0] = guard.sign * (c(static_cast<Index>(k), 0) - guard.level);
    return p;
  }
  bool is_tie(std::size_t k) const { return k < ties_.size() && ties_[k] != 0; }
  // The polynomial divided by its variable, where it begins at zero.
  static ShortPolynomial divided(ShortPolynomial p, double from) {
    std::copy(p.c.begin() + 1, p.c.begin() + p.degree + 1, p.c.begin());
    --p.degree;
    p.c[0] = std::max(p(from), 0.0);
    return p;
  }

  KeptBranches<> all_;
  bool holds_ = true;
  Branch* now_ = nullptr;
  double t_ = 0.0, unit_ = 1.0, guard_unit_ = 1.0, expanded_at_ = 0.0;
  std::size_t left_at_ = none;          // the guard at which the branch ends here
  std::size_t edge_guard_ = none;       // … at which the step does that is tried
  double edge_end_ = 0.0, least_ = 0.0;
  bool is_fresh_ = true;                // nothing is known yet of the guards at the present state
  std::vector<char> ties_{};            // guards that are zero here
  std::vector<double> sizes_{};         // of components, in units of their rounding, in the step to an edge
  std::vector<Branch*> tried_{};        // … that end here
  int edges_ = 0;
  double edges_since_ = 0.0;
  bool is_crowded_ = false;
  Eigen::VectorXd y_{};
};

template <class X>
[[noreturn]] void BranchedSeries<X>::refuse_here(const char* how) const {
  throw EndOfRun({Outcome::zeno, sentence({now_->guards()[left_at_].what, " is met at t = ", t_, ", and ", how})});
}

template <class X>
[[gnu::cold, gnu::noinline]] bool BranchedSeries<X>::turn(double t, const double* y) {
  if (left_at_ == none) return false;
  t_ = t;
  if (is_crowded_) refuse_here("branches follow each other there without letting t go on");
  const Guards answers = answers_behind(now_->guards(), left_at_);
  Branch* const next = [&] {
    try {
      return beyond(answers, t, y);
    } catch (const NotAnalytic& error) {  // a branch that has no series, in mid-run
      throw EndOfRun({Outcome::refused_by_model, error.what()});
    }
  }();
  if (std::find(tried_.begin(), tried_.end(), next) != tried_.end() || tried_.size() > KeptBranches<>::most)
    refuse_here("each of its sides leads the motion back to it, as friction does at rest, so that no branch holds it; give the system a phase for this, "
                "as dry_friction() and contact() have");
  now_ = next;
  left_at_ = none;
  is_fresh_ = true;
  return true;
}

template <class X>
bool BranchedSeries<X>::stays(double elapsed, double way, double least) {
  const Guards& guards = now_->guards();
  const double length = std::abs(way);
  least_ = std::max(least, epsilon * length);
  ties_.assign(guards.size(), 0);
  const Eigen::MatrixXd& state = now_->series->coefficients();
  for (std::size_t k = 0; k < guards.size(); ++k) {
    ShortPolynomial p = along(k, way);
    if (is_fresh_ && p.c[0] != 0.0 && !sizes_.empty() &&
        std::abs(p.c[0]) <= noise(*now_, k, t_, state.data()) + 8 * epsilon * std::abs(p.c[1] * elapsed / length))
      p.c[0] = 0.0;
    ties_[k] = p.c[0] <= 0.0;
    if (p(std::min(least_ / length, 1.0)) >= 0.0) continue;
    left_at_ = k;
    tried_.push_back(now_);
    return false;
  }
  if (is_fresh_ && sizes_.empty()) refuse_two_ways(way);
  tried_.clear();
  is_fresh_ = false;
  return true;
}

// Where a motion is set on a guard, and its other side would lead it away as well, by another motion.
template <class X>
[[gnu::cold, gnu::noinline]] void BranchedSeries<X>::refuse_two_ways(double way) {
  constexpr double equal = 1e-11;  // relative, of series
  Branch* const here = now_;
  const Eigen::MatrixXd motion = here->series->coefficients();
  const double part = std::min(least_ / std::abs(way), 1.0);
  for (std::size_t k = 0; k < ties_.size(); ++k) {
    if (ties_[k] == 0 || !(along(k, way)(part) > 0.0)) continue;
    const Guards answers = answers_behind(here->guards(), k);
    const std::size_t same_place = answers.size() - (here->guards()[k].of_floor && here->guards()[k].sign > 0.0 ? 0 : 1);
    bool is_other_motion = false;
    try {
      all_.use(*here);
      now_ = beyond(answers, t_, motion.data());
      now_->series->start(t_, motion.data(), guard_unit_);
      now_->series->expand(all_.highest_order());
      is_other_motion = along(same_place, way)(part) > 0.0 && !now_->series->coefficients().isApprox(motion, equal);
    } catch (...) {  // beyond the guard there is no model
    }
    now_ = here;
    if (is_other_motion)
      throw EndOfRun({Outcome::refused_by_model,
                      sentence({here->guards()[k].what, " is met at t = ", t_,
                                ", where the motion begins, and each of its sides leads it away from there, so that it is not unique; begin on one side"})});
  }
}

template <class X>
double BranchedSeries<X>::edge(const PolynomialView& motion, const Clock& clock, double end) {
  edge_guard_ = none;
  double way = end - motion.origin;
  for (std::size_t k = 0; k < now_->guards().size(); ++k) {
    ShortPolynomial p = along(k, way);
    if (is_tie(k)) p = divided(p, std::min(least_ / std::abs(way), 1.0));
    const double part = first_descent(p);
    if (part > 1.0) continue;
    way *= part;
    edge_guard_ = k;
  }
  if (edge_guard_ == none) return end;
  const double good_for = way;  // as far as the guard's series goes; from there to where the guard is zero
  y_.resize(motion.size);
  for (int k = 0; k < 8; ++k) {
    motion.at(motion.origin + way, y_);
    const double value = all_.above(*now_, edge_guard_, clock.shown(motion.origin + way), y_.data());
    const double slope = along(edge_guard_, way).slope(1.0) / way, by = -value / slope;
    if (!(std::abs(by) <= 0.01 * std::abs(good_for)) || std::abs(way + by) > std::abs(end - motion.origin)) break;
    way += by;
    if (std::abs(by) <= 4 * epsilon * std::abs(way)) break;
  }
  return edge_end_ = motion.origin + way;
}

template <class X>
double BranchedSeries<X>::disagreement(double from, double end, double t, const double* y, const Eigen::VectorXd& weights) {
  // Behind a switch functors are shown the same time for a while.
  const double of_t = rounding * std::abs(t) + std::abs(expanded_at_ + (end - from) - t);
  double largest = 0.0;
  for (std::size_t k = 0; k < now_->guards().size(); ++k) {
    const ShortPolynomial p = along(k, end - from);
    double size = 0.0, last = 0.0;
    for (int j = 0; j <= p.degree; ++j) {
      const double term = std::abs(p.c[static_cast<std::size_t>(j)]);
      size += term;
      if (j > p.degree - 3) last += term;
    }
    const double value = all_.above(*now_, k, t, y), apart = std::abs(value - p(1.0));
    if (std::isnan(apart)) {
      const std::string& what = now_->guards()[k].what;
      throw NonFinite(what, t, sentence({what, " must find numbers, but at t = ", t, " one of them is not a number, so it has no side to take"}));
    }
    // Far outside of its radius of convergence a series is large enough for rounding to hide anything.
    if (!std::isfinite(size)) {
      largest = std::max(largest, hiding);
      continue;
    }
    if (const double shown = std::max(std::abs(value), std::abs(p.c[0])); 2.0 * last > size && size > hiding * shown) {
      largest = std::max(largest, shown > 0.0 ? size / shown : hiding);
      continue;
    }
    if (apart <= rounding * size) continue;
    const double allowed = rounding * size + all_.change(*now_, k, t, y, weights.data(), of_t);
    largest = std::max(largest, apart <= allowed ? 0.0 : apart / allowed);
  }
  return largest;
}

template <class X>
bool BranchedSeries<X>::land(const PolynomialView& motion, double end, double way_left) {
  if (edge_guard_ == none || end != edge_end_) return false;
  left_at_ = std::exchange(edge_guard_, none);
  is_fresh_ = true;
  tried_.clear();
  sizes_.resize(static_cast<std::size_t>(motion.size));
  const double s = std::abs((end - motion.origin) / motion.scale);
  for (Index i = 0; i < motion.size; ++i) {
    double size = 0.0;
    for (int k = motion.degree; k >= 0; --k) size = size * s + std::abs(motion.coefficients[k * motion.size + i]);
    sizes_[static_cast<std::size_t>(i)] = rounding * size;
  }
  if (edges_ == 0) edges_since_ = end;
  if (++edges_ > crowd) {
    is_crowded_ = std::abs(end - edges_since_) < crowded * std::min(std::abs(end), std::abs(way_left));
    edges_ = 0;
  }
  return true;
}

#ifdef QDOT_COMPILED
extern template class BranchedSeries<>;
#endif

/// The series of a motion whose functors are run once, and once for each branch where they have some.
inline std::unique_ptr<PowerSeries> power_series(const std::shared_ptr<const MotionSource>& source, int highest_order) {
  try {
    return std::make_unique<LagrangeSeries<>>(source, highest_order);
  } catch (const NotAnalytic&) {  // what has no branches either is refused where the motion begins
    return std::make_unique<BranchedSeries<>>(source, highest_order);
  }
}

/// The series of a system or scene.
template <class F>
struct PowerSeriesOf {
  static std::unique_ptr<PowerSeries> made(const F& form, int highest_order) {
    const auto source = std::make_shared<MotionSourceOf<F>>(form);
    if constexpr (has_branches_recorded<F>) return power_series(source, highest_order);
    else return std::make_unique<LagrangeSeries<>>(source, highest_order);
  }
};

}  // namespace qdot::detail
