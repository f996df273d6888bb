#pragma once
// SPDX-License-Identifier: MIT
//
// Equilibria along a parameter
// ============================
//
//     const auto found = equilibrium_branches([](double Omega) { return mechanical_system<1>(Bead{.Omega = Omega}); }, q, 1.0, 6.0);
//     for (const auto& branch : found) for (const auto& point : branch.points) … point.p, point.q, point.stability, point.kind
//
// The equilibrium near a start is followed along its curve (branches/curve.hpp) as a parameter p goes from one value to
// another, round folds where p turns back. Steady motions are followed alike, with the rates of cyclic coordinates held.
// Special points are located by a test that changes its sign there:
//
//     fold      the curve turns back: two equilibria meet, and beyond there is none         (an exponent passes 0)
//     branch    another curve crosses, such as a pitchfork; it is followed to both sides    (an exponent passes 0)
//     hopf      oscillations begin, or without damping flutter                              (a pair leaves the imaginary axis)
// Without damping, exponents lie on the axis until two of them meet.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "qdot/analysis/branches/curve.hpp"
#include "qdot/analysis/damped_modes.hpp"
#include "qdot/analysis/linearization.hpp"
#include "qdot/effects/scene.hpp"
#include "qdot/error.hpp"

namespace qdot {

/// What a point of a branch of equilibria is.
enum class BranchKind {
  start,    ///< where it was begun
  regular,  ///< nothing special
  fold,     ///< the parameter turns back
  branch,   ///< another branch crosses
  hopf,     ///< a pair of exponents crosses the imaginary axis
  end       ///< the last one
};

/// The kind's name, "fold".
constexpr std::string_view name(BranchKind kind) noexcept {
  return detail::name_in({"start", "regular", "fold", "branch", "hopf", "end"}, kind);
}

/// An equilibrium, or a steady motion, of a family.
struct BranchPoint {
  BranchKind kind = BranchKind::regular;      ///< what is special about it
  double p = 0.0;                             ///< the parameter
  Eigen::VectorXd q, z;                       ///< and the effects' own states
  Eigen::VectorXcd exponents;                 ///< of small motions beside it
  int growing = 0;                            ///< how many of them grow
  Stability stability = Stability::unstable;  ///< at special points decided by rounding
};

/// One curve of equilibria, in order.
struct EquilibriumBranch {
  std::vector<BranchPoint> points;                            ///< in order
  std::string message;                                        ///< how it ended: at the end of the range, or why not there
  std::optional<std::pair<std::size_t, std::size_t>> from{};  ///< the branch and its point that this one begins at; none for the first

  /// Points of one kind.
  std::vector<BranchPoint> all(BranchKind kind) const {
    std::vector<BranchPoint> chosen;
    for (const BranchPoint& point : points)
      if (point.kind == kind) chosen.push_back(point);
    return chosen;
  }
};

/// How branches are followed.
struct BranchOptions {
  Eigen::VectorXd qdot{};          ///< rates of cyclic coordinates, n, for steady motions; empty for rest
  double longest_step = 0.05;      ///< along the curve; p counts in parts of its range, q and z in 1, or the larger or smaller size in which slopes change
  int most_points = 1000;          ///< of a branch
  std::size_t most_branches = 16;  ///< in all
};

namespace detail {

template <class Curve = SteadyCurve<>>  // compiled only where it is made
class BranchSearch {
  static constexpr const char* who = "equilibrium_branches";

 public:
  BranchSearch(const FlowAt& flow_at, const Eigen::VectorXd& q, double from, double to, const BranchOptions& options) : options_(options) {
    if (!std::isfinite(from) || !std::isfinite(to) || from == to)
      throw_invalid_value({who, ": the range of the parameter must be finite and not empty, but goes from ", from, " to ", to, "; give it two values"});
    if (!(options.longest_step > 0.0 && options.longest_step <= 1.0) || options.most_points < 2 || options.most_branches < 1)
      throw_invalid_value({who, ": the longest step must lie between 0 and 1, and there must be points and branches, but they are ", options.longest_step, ", ",
                           options.most_points, " and ", options.most_branches, "; leave them out for 0.05, 1000 and 16"});
    const auto flow = flow_at(from);
    const Eigen::Index n = flow->dof();
    if (q.size() != n) throw DimensionError("q", static_cast<long>(n), static_cast<long>(q.size()), "pass one entry for each coordinate");
    Eigen::VectorXd qdot = options.qdot.size() > 0 ? options.qdot : Eigen::VectorXd(Eigen::VectorXd::Zero(n));
    if (qdot.size() != n)
      throw DimensionError("qdot", static_cast<long>(n), static_cast<long>(qdot.size()),
                           "pass one rate for each coordinate, or none at all");
    Eigen::VectorXd y(flow->size());
    y << q, qdot, Eigen::VectorXd::Zero(flow->size() - 2 * n);
    y = steady_state_near(*flow, {who, 100, 1e-12}, 0.0, y);
    Eigen::VectorXd X(flow->size() - n + 1);
    X << y.head(n), y.tail(flow->size() - 2 * n), from;
    curve_.emplace(flow_at, 0.0, qdot, X, std::min(from, to), std::max(from, to));
    low_ = curve_->scaled_parameter(std::min(from, to));
    high_ = curve_->scaled_parameter(std::max(from, to));
    dof_ = n;
    const Eigen::VectorXd ahead = (to > from ? 1.0 : -1.0) * Eigen::VectorXd::Unit(curve_->parameter() + 1, curve_->parameter());
    const CurvePoint start = curve_->point(curve_->scaled(X), ahead, nullptr);
    if (start.tangent.dot(ahead) < 0.0)
      throw InvalidValue(
          "equilibrium_branches: the curve must go on from the start, but there it has no direction; begin beside this value");
    waiting_.push_back({start, {}});
  }

  std::vector<EquilibriumBranch> branches() {
    for (std::size_t next = 0; next < waiting_.size() && found_.size() < options_.most_branches; ++next) {
      const Waiting begin = waiting_[next];
      unfollowed_.clear();
      EquilibriumBranch branch;
      branch.from = begin.from;
      try {
        follow(branch, begin);
      } catch (const Error& error) {
        branch.message = branch.points.empty() ? error.what() : sentence({"lost behind p = ", {branch.points.back().p, 8}, ": ", error.what()});
      }
      branch.message += unfollowed_;
      found_.push_back(std::move(branch));
    }
    if (const std::size_t left = waiting_.size() - found_.size(); left > 0)
      found_.back().message += sentence(
          {"; ", left, left == 1 ? " branch that crosses was" : " branches that cross were", " not followed: as many as were allowed"});
    return std::move(found_);
  }

 private:
  struct Waiting {
    CurvePoint start;
    std::optional<std::pair<std::size_t, std::size_t>> from;
  };
  struct Special {
    double s;
    BranchKind kind;
    CurvePoint point;
  };

  BranchPoint described(const CurvePoint& here, BranchKind kind) const {
    BranchPoint point;
    point.kind = kind;
    point.p = curve_->p(here.X);
    const Eigen::VectorXd x = curve_->values(here.X);
    point.q = x.head(dof_);
    point.z = x.segment(dof_, x.size() - 1 - dof_);
    curve_->require_steady_at(who, here.X);
    const auto flow = curve_->flow(here.X);
    const Linearization linear = linearized(*flow, 0.0, curve_->y(here.X));
    const Exponents all = exponents_of(linear.A);
    for (Eigen::Index i = 0; i < all.lambda.size(); ++i) point.growing += all.grows(i) ? 1 : 0;
    point.exponents = sorted_exponents(all.lambda);
    point.stability = stability_of_exponents(all);
    return point;
  }
  int growing(const CurvePoint& here) const { return described(here, BranchKind::regular).growing; }

  // The point at a distance s from another one.
  std::optional<CurvePoint> ahead(const CurvePoint& from, double s) const {
    try {
      const auto X = curve_->on_plane(curve_->moved(from.X, from.tangent, s), from.tangent);
      if (X) return curve_->point(*X, from.tangent, &from);
    } catch (const Error& error) {  // no model there
      trouble_ = error.what();
    }
    return std::nullopt;
  }

  // The point where the range ends, near the one at a distance s.
  std::optional<CurvePoint> at_end(const CurvePoint& from, double s, double bound) const {
    try {
      Eigen::VectorXd guess = curve_->moved(from.X, from.tangent, s);
      guess[guess.size() - 1] = bound;
      const auto X = curve_->on_plane(guess, Eigen::VectorXd::Unit(from.tangent.size(), from.tangent.size() - 1));
      if (X) return curve_->point(*X, from.tangent, &from);
    } catch (const Error& error) {  // no model there
      trouble_ = error.what();
    }
    return std::nullopt;
  }

  // The guess at a distance s from a point, by the cubic through two points of the curve beside it. Next to a crossing, Newton's
  // method goes to the nearer curve. So the guess must be closer to its own curve than that is to the other.
  struct Beside {
    double s;
    CurvePoint point;
  };
  std::optional<CurvePoint> between(const CurvePoint& from, const Beside& low, const Beside& high, double s, bool corrected) const {
    const double length = high.s - low.s, x = (s - low.s) / length, rest = 1.0 - x;
    const double at_low = length * x * rest * rest / low.point.tangent.dot(from.tangent);
    const double at_high = length * x * x * rest / high.point.tangent.dot(from.tangent);
    Eigen::VectorXd X = (1.0 + 2.0 * x) * rest * rest * low.point.X + (1.0 + 2.0 * rest) * x * x * high.point.X;
    X = curve_->moved(curve_->moved(X, low.point.tangent, at_low), high.point.tangent, -at_high);
    try {
      if (!corrected) return curve_->point(X, from.tangent, &from);
      const auto there = curve_->on_plane(X, from.tangent);
      if (there) return curve_->point(*there, from.tangent, &from);
    } catch (const Error& error) {  // no model there
      trouble_ = error.what();
    }
    return std::nullopt;
  }

  // Where a test changes its sign between two neighbours, by bisection to rounding; nothing where they lie on two curves that do not meet.
  template <class Test>
  std::optional<Special> located(const CurvePoint& from, const CurvePoint& to, BranchKind kind, const Test& has_changed) const {
    const double s = from.tangent.dot(curve_->difference(to.X, from.X));
    Beside low{0.0, from}, high{s, to};
    constexpr double same = 1e-6;
    for (int halving = 0; halving < 60 && high.s - low.s > 1e-13 * (s + 1e-3); ++halving) {
      const double middle = 0.5 * (low.s + high.s);
      auto here = between(from, low, high, middle, true);
      // Nearer to the crossing than the cubic is to the curve: that is exact enough.
      if (!here && high.s - low.s < same) here = between(from, low, high, middle, false);
      if (!here) return std::nullopt;
      (has_changed(*here) ? high : low) = Beside{middle, *here};
    }
    if (curve_->difference(high.point.X, low.point.X).norm() > same) return std::nullopt;
    return Special{high.s, kind, high.point};
  }

  // Adds its points to a branch, and says how it ended.
  void follow(EquilibriumBranch& branch, const Waiting& begin) {
    constexpr double least_step = 1e-6, straight = 0.9, aside = 0.1;  // another curve need not cross at a right angle
    trouble_.clear();
    CurvePoint here = begin.start;
    branch.points.push_back(described(here, begin.from ? BranchKind::branch : BranchKind::start));
    double step = 0.25 * options_.longest_step;
    bool fresh = begin.from.has_value();  // next to a crossing nothing has a sign yet
    int count = branch.points[0].growing;
    const Eigen::Index last = curve_->parameter();
    while (static_cast<int>(branch.points.size()) < options_.most_points) {
      // A step that would leave the range goes to its end: scenes beyond may not exist.
      const double place = here.X[here.X.size() - 1], to = place + step * here.tangent[last];
      const double bound = to > high_ ? high_ : low_;
      const bool leaves = to > high_ || to < low_;
      const double part = leaves ? (bound - place) / (to - place) : 1.0;
      if (part <= 1e-9) {
        branch.message = "reached the end of the range";
        return;
      }
      const auto next = leaves ? at_end(here, part * step, bound) : ahead(here, step);
      const double there = next ? next->X[next->X.size() - 1] : place;
      const bool astray = !next || next->tangent.dot(here.tangent) < (fresh ? aside : straight) || there > high_ || there < low_;
      if (astray || !add_specials(branch, here, *next, fresh, count, begin)) {  // no point, or one of another curve
        step *= 0.5;
        if (step < least_step) {
          branch.message = sentence({"lost at p = ", {curve_->p(here.X), 8}, ": no equilibrium was found ahead however short the step",
                                     trouble_.empty() ? "" : "; ", trouble_});
          return;
        }
        continue;
      }
      if (leaves) {
        branch.points.push_back(described(*next, BranchKind::end));
        branch.message = "reached the end of the range";
        return;
      }
      branch.points.push_back(described(*next, BranchKind::regular));
      count = branch.points.back().growing;
      here = *next;
      fresh = false;
      step = std::min(1.4 * step, options_.longest_step);
    }
    branch.message = sentence({"ended at p = ", {curve_->p(here.X), 8}, " with as many points as were allowed; allow more"});
  }

  // The special points between two neighbours; false where these lie on two curves.
  bool add_specials(EquilibriumBranch& branch, const CurvePoint& here, const CurvePoint& next, bool fresh, int count, const Waiting& begin) {
    if (fresh) return true;
    const Eigen::Index last = curve_->parameter();
    std::vector<Special> specials;
    if (here.crossing * next.crossing < 0.0) {
      const auto found = located(here, next, BranchKind::branch, [&](const CurvePoint& x) { return here.crossing * x.crossing < 0.0; });
      if (!found) return false;
      specials.push_back(*found);
    }
    if (here.tangent[last] * next.tangent[last] < 0.0) {
      const auto found = located(here, next, BranchKind::fold, [&](const CurvePoint& x) { return here.tangent[last] * x.tangent[last] < 0.0; });
      const bool is_crossing = found && !specials.empty() && std::abs(specials[0].s - found->s) < 1e-5;
      if (found && !is_crossing) specials.push_back(*found);
    }
    if (specials.empty()) {
      const int after = growing(next);
      if (std::abs(after - count) > 1) {
        const auto found = located(here, next, BranchKind::hopf,
                                   [&](const CurvePoint& x) { return std::abs(growing(x) - after) < std::abs(growing(x) - count); });
        if (found) specials.push_back(*found);
      }
    }
    std::sort(specials.begin(), specials.end(), [](const Special& a, const Special& b) { return a.s < b.s; });
    for (const Special& special : specials) {
      branch.points.push_back(described(special.point, special.kind));
      if (special.kind == BranchKind::branch) begin_others(special.point, {found_.size(), branch.points.size() - 1}, begin);
    }
    return true;
  }

  // The other curve through a crossing, to both sides, unless it is known.
  void begin_others(const CurvePoint& at, std::pair<std::size_t, std::size_t> from, const Waiting& begin) {
    constexpr double same = 1e-5;
    for (const Eigen::VectorXd& known : crossings_)
      if ((known - at.X).norm() < same) return;
    if (begin.from && (begin.start.X - at.X).norm() < same) return;
    crossings_.push_back(at.X);
    const Eigen::MatrixXd others = Curve::crossing_directions(at);
    if (others.cols() == 0)
      unfollowed_ += sentence({"; another curve crosses at p = ", {curve_->p(at.X), 8}, ", but its direction is not known there: begin on it to follow it"});
    for (Eigen::Index k = 0; k < others.cols(); ++k) {
      Eigen::Index largest = 0;
      for (Eigen::Index i = 0; i < others.rows(); ++i)
        if (std::abs(others(i, k)) > std::abs(others(largest, k)) + 1e-6) largest = i;
      for (const double side : {1.0, -1.0}) {  // first to where the coordinate that changes most grows
        CurvePoint start = at;
        start.tangent = others(largest, k) < 0.0 ? Eigen::VectorXd(-side * others.col(k)) : Eigen::VectorXd(side * others.col(k));
        waiting_.push_back({start, from});
      }
    }
  }

  BranchOptions options_;
  std::optional<Curve> curve_;
  double low_ = 0.0, high_ = 0.0;
  mutable std::string trouble_;  // the last error on the way
  std::string unfollowed_;       // what is said of curves that cross this branch
  Eigen::Index dof_ = 0;
  std::vector<EquilibriumBranch> found_;
  std::vector<Waiting> waiting_;
  std::vector<Eigen::VectorXd> crossings_;
};

template <class = void>  // compiled only where it is called
std::vector<EquilibriumBranch> branches_from(const FlowAt& flow_at, const Eigen::VectorXd& q, double from, double to, const BranchOptions& options) {
  return BranchSearch(flow_at, q, from, to, options).branches();
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template std::vector<EquilibriumBranch> branches_from<void>(const FlowAt&, const Eigen::VectorXd&, double, double, const BranchOptions&);
#endif

}  // namespace detail

/// The equilibria of a family of scenes from one value of a parameter to another, and those that branch off.
///
/// Some ten evaluations of the accelerations and one Jacobian for each step of Newton's method, three of which make a point. Special points are located to
/// some 1e-10 of the range.
///
/// @param family  p ↦ a system or scene, for a double p; smooth in p
/// @param q       where to begin, n: near an equilibrium of family(from)
/// @param from, to  range of p
/// @return        the branch that begins at q first; then those that cross, to both sides
/// @throws        as equilibrium_near() at the start; InvalidValue for a range, steps or rates that cannot be, and where the family has no slope in p
template <class Family>
  requires std::is_invocable_v<const Family&, double>
std::vector<EquilibriumBranch> equilibrium_branches(const Family& family, const Eigen::VectorXd& q, double from, double to, const BranchOptions& options = {}) {
  const detail::FlowAt flow_at = [&family](double p) { return detail::owned_flow(scene(family(p))); };
  return detail::branches_from(flow_at, q, from, to, options);
}

}  // namespace qdot
