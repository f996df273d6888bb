#pragma once
// SPDX-License-Identifier: MIT
//
// The variational equations, and what jumps and constraints make of them.
//
//     ẏ = f(t, y, p) ,     Φ̇ = (∂f/∂y) Φ + ∂f/∂p       a column of Φ for each direction x in (y₀, t₀, p)
//
// [y; columns of Φ] is one first-order system: a method takes the same steps for both, and controls the error of both.
// At an event, h(y, t, p) = 0, the state becomes g(y, t, p), and Φ jumps by the saltation matrix, a column at a time:
//
//     ∂t_e/∂x = −(∇h·Φ⁻ + ∂h/∂p) / (∇h·f⁻ + ∂h/∂t) ,       w = Φ⁻ + f⁻ ∂t_e/∂x ,
//     Φ⁺ = ∂g·w + ∂g/∂t ∂t_e/∂x + ∂g/∂p − f⁺ ∂t_e/∂x        (M. Kunze, Non-Smooth Dynamical Systems, 2000).
//
// ∂g is asked along w only, which is tangent to h = 0. Where ∇h·f⁻ ≈ 0, or the order of two events matters, there is no
// Φ⁺, and the run ends with that outcome. On constraints a projection takes the nearest tangent vector in the metric of
// M, J δq + ∂φ/∂p = 0 and d(J q̇ + ∂φ/∂t) = 0 along (δq, δq̇). What is left out is as small as what is projected.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "qdot/analysis/variations/slope.hpp"
#include "qdot/effects/projection_report.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/watch/any_watch.hpp"

namespace qdot::detail {

// A moment at which a run's events were differentiated.
struct EventSlope {
  double t = 0.0;
  Eigen::VectorXd time;    // ∂t_e/∂x
  std::string name = {};   // none for a branch of a functor
  Eigen::VectorXd before = {}, after = {};  // y; empty for a branch, which leaves it as it is
};

// How a motion goes through h = 0.
struct Crossing {
  Eigen::VectorXd time;  // ∂t_e/∂x
  double speed = 0.0;    // dh/dt along the motion
  double by_time = 0.0;  // ∂h/∂t
  double way = 0.0;      // the time in which h would change by the size of what it is the difference of: to its rounding t_e is known
};

class VariationalRecorder;  // recorder.hpp
struct RecordedBranch;      // integrate/steps/recorded_branches.hpp

// What an event is where parameter `column` is displaced by s.
struct Surface {
  std::function<double(double t, const Eigen::VectorXd& y, Eigen::Index column, double s)> h;
  std::function<void(double t, Eigen::VectorXd& y, Eigen::Index column, double s)> jump;  // none where nothing changes
};

// What an event makes of the second derivatives that stand behind Φ (analysis/variations/second_saltation.hpp).
struct PairsBehind {
  virtual ~PairsBehind() = default;
  virtual void write(const Surface& surface, const Crossing& crossing, const Eigen::VectorXd& after, Eigen::VectorXd& both) const = 0;
};

// y, f and Φ of a model without its type; every y is [y; columns of Φ].
template <class = void>  // compiled only where it is made
class BasicVariationalEquations {
 public:
  virtual ~BasicVariationalEquations() = default;

  Eigen::Index state_size() const noexcept { return size_; }
  Eigen::Index columns() const noexcept { return columns_; }
  Eigen::Index size() const noexcept { return size_ * (1 + columns_ + pairs); }
  Eigen::Index dof() const noexcept { return dof_; }

  // Of the columns of Φ for the state at the start, which entry of y each of them displaces.
  const std::vector<Eigen::Index>& start_entries() const noexcept { return entries_; }

  // [y; Φ] with Φ as it would be had the motion begun at y.
  Eigen::VectorXd seeded(const Eigen::VectorXd& y) const {
    Eigen::VectorXd both = Eigen::VectorXd::Zero(size());
    both.head(size_) = y;
    for (std::size_t j = 0; j < entries_.size(); ++j) both[size_ * (static_cast<Eigen::Index>(j) + 1) + entries_[j]] = 1.0;
    return both;
  }

  virtual void write_rates(double t, const double* y, double* ydot) const = 0;
  virtual void write_state_rates(double t, const double* y, double* ydot) const = 0;  // of y alone
  virtual void write_state_jacobian(double, const double*, Eigen::Ref<Eigen::MatrixXd> J) const {
    J.setConstant(std::numeric_limits<double>::quiet_NaN());  // of equations that explicit methods alone are given
  }
  // ∂(λ·f)/∂p at fixed y, for less than ∂f/∂p costs; asked of models that go backwards.
  virtual bool goes_backwards() const { return false; }
  virtual Eigen::VectorXd parameter_gradient(double, const double*, const double*, const Eigen::VectorXd&) const { return {}; }
  bool leaves_parameters_out = false;  // the columns of parameters, of write_rates()
  bool bends_projections = false;      // columns are what the projection of y itself makes of them, not its tangent map alone
  virtual Eigen::VectorXd state_rate(double t, const Eigen::VectorXd& y) const = 0;
  virtual ProjectionReport project(double t, Eigen::Ref<Eigen::VectorXd> y) const = 0;  // or of y alone
  virtual Eigen::Index guard_count() const = 0;
  virtual std::string ending(Eigen::Index k) const = 0;
  virtual void guards(double t, const Eigen::VectorXd& y, Eigen::Ref<Eigen::VectorXd> g) const = 0;
  virtual void guard_bands(double t, const Eigen::VectorXd& y, const Eigen::VectorXd& tolerance, Eigen::Ref<Eigen::VectorXd> g) const = 0;
  virtual std::vector<std::string> switched(double t, Eigen::VectorXd& y, const std::vector<bool>& fired, const Eigen::VectorXd& tolerance) = 0;
  virtual std::string state_name(Eigen::Index i) const = 0;
  virtual std::string column_name(Eigen::Index j) const = 0;
  virtual void renew() = 0;
  virtual std::unique_ptr<AnyWatch> watch(const Options& options) const = 0;  // of y
  virtual double parameter_size(Eigen::Index column) const = 0;  // infinite for a column of another kind

  // At y in front of an event.
  //
  // @throws EndOfRun  not_differentiable, where the event grazes or h has no derivative
  Crossing crossing(const std::string& name, double t, const Eigen::Ref<const Eigen::VectorXd>& both, const Surface& surface) const;

  // y ← the state behind an event, with Φ⁺.
  virtual void pass(const std::string& name, double t, Eigen::VectorXd& both, const Surface& surface);

  // Of all moments that changed the state, in their order.
  const std::vector<EventSlope>& passed() const noexcept { return passed_; }

  void note_passed(double t, Eigen::VectorXd time) { passed_.push_back({t, std::move(time), {}, {}, {}}); }

  // Where functors compare (branches.hpp): what a switch makes of Φ, and that the branch is to be taken anew behind a jump.
  virtual bool records_functors() const { return false; }
  virtual void record(RecordedBranch&, Eigen::Index, double) const {}  // with parameter `column` displaced by s
  virtual void pass_branch(double t, Eigen::VectorXd& both) { switch_branch(t, both); }
  std::function<void(double t, Eigen::VectorXd& both)> switch_branch;
  std::function<void(double t, const Eigen::VectorXd& y)> branch_anew;
  std::function<bool(Eigen::Index column, double s, double t, const double* y)> is_same_branch;  // as that of the displaced parameter
  std::function<bool(double t, Eigen::VectorXd& both)> leap;                                     // over a switch that no step gets over

  // When an action last changed what f itself is, not only its state: in front of this, f is not known any more.
  std::optional<double> changed() const noexcept { return changed_; }

  // |yᵢ| at a state of the motion, for the scale of what is differenced.
  void note_size(const double* y) const {
    for (Eigen::Index i = 0; i < size_; ++i) largest_[i] = std::max(largest_[i], std::abs(y[i]));
  }

  std::shared_ptr<const VariationalRecorder> recorder;  // for Taylor series; otherwise none
  std::function<std::unique_ptr<PairsBehind>(const std::string& name, double t, const Eigen::VectorXd& both)> pairs_at;  // an event, in front of it
  Eigen::Index pairs = 0;          // of columns of Φ whose second derivatives stand behind it, row by row of the upper triangle; of Taylor series only
  // How far a state may be displaced along a direction: by what it, or the parameter of a column, is large in this run; 1 where nothing says how far.
  double reach(const Eigen::VectorXd& y, const Eigen::VectorXd& along, Eigen::Index column) const;
  const Eigen::VectorXd& largest() const noexcept { return largest_; }

  double rtol = 0.0, began = std::numeric_limits<double>::quiet_NaN();  // where the run begins
  Eigen::VectorXd atol;                                                 // of each component of the state
  Eigen::VectorXd resolution(const Eigen::VectorXd& y) const { return rtol * y.head(size_).cwiseAbs() + atol; }

 protected:
  BasicVariationalEquations() = default;
  BasicVariationalEquations(const BasicVariationalEquations&) = default;
  BasicVariationalEquations& operator=(const BasicVariationalEquations&) = default;

  Eigen::Index size_ = 0, dof_ = 0, columns_ = 0;
  std::vector<Eigen::Index> entries_;
  mutable Eigen::VectorXd largest_;  // |yᵢ| of all states at which f was asked for

 private:
  double scale(const Eigen::VectorXd& y, const Eigen::VectorXd& along) const;
  double way_ahead(double t, const Eigen::VectorXd& y, const Eigen::VectorXd& f) const;

  struct Passage {
    std::string name;
    Surface surface;
  };
  struct Together {
    Eigen::VectorXd before{};  // [y; columns of Φ]
    std::vector<Passage> passed{};
  };
  void require_any_order(double t);
  Eigen::VectorXd go_through(const std::string& name, double t, Eigen::VectorXd& both, const Surface& surface);

  std::vector<EventSlope> passed_;
  Together moment_;  // of the last moment
  std::optional<double> changed_;
};

using VariationalEquations = BasicVariationalEquations<>;

[[noreturn, gnu::cold, gnu::noinline]] inline void end_undifferentiable(const std::string& name, double t, std::initializer_list<Phrase> why) {
  throw EndOfRun({Outcome::not_differentiable, sentence({"at t = ", t, " '", name, "' ", sentence(why)})});
}

// How far along a direction y goes before it has changed by as much as it is large in this run, positions and velocities apart.
template <class Kind>
double BasicVariationalEquations<Kind>::scale(const Eigen::VectorXd& y, const Eigen::VectorXd& along) const {
  double distant = std::numeric_limits<double>::infinity();
  const auto limit = [&](Eigen::Index first, Eigen::Index count) {
    double most = 0.0, size = 0.0;
    for (Eigen::Index i = first; i < first + count; ++i) {
      most = std::max(most, std::abs(along[i]));
      size = std::max({size, std::abs(y[i]), largest_[i]});
    }
    if (most > 0) distant = std::min(distant, (size > 0 ? size : 1.0) / most);
  };
  limit(0, dof_);
  limit(dof_, dof_);
  limit(2 * dof_, y.size() - 2 * dof_);
  return distant;  // infinite where nothing moves
}

// scale(y, along), but at most a parameter's size; 1 where both are infinite.
template <class Kind>
double BasicVariationalEquations<Kind>::reach(const Eigen::VectorXd& y, const Eigen::VectorXd& along, Eigen::Index column) const {
  const double distant = std::min(scale(y, along), column < 0 ? std::numeric_limits<double>::infinity() : parameter_size(column));
  return std::isfinite(distant) ? distant : 1.0;
}

// The time in which a motion goes far. What has gone nowhere since the run began, but for rounding, waits for a moment: that time itself.
template <class Kind>
double BasicVariationalEquations<Kind>::way_ahead(double t, const Eigen::VectorXd& y, const Eigen::VectorXd& f) const {
  constexpr double rounding = 1e-13;
  const double span = std::abs(t - began);
  bool waits = span > 0.0;
  for (Eigen::Index i = 0; i < size_ && waits; ++i) {
    const bool is_velocity = i >= dof_ && i < 2 * dof_;
    const double size = std::max(std::abs(y[is_velocity ? i - dof_ : i]), largest_[is_velocity ? i - dof_ : i]);
    waits = std::abs(f[i]) * span * (is_velocity ? span : 1.0) <= rounding * size;
  }
  return waits ? span : reach(y, f, -1);
}

template <class Kind>
Crossing BasicVariationalEquations<Kind>::crossing(const std::string& name, double t, const Eigen::Ref<const Eigen::VectorXd>& both,
                                                   const Surface& surface) const {
  const Eigen::VectorXd y = both.head(size_), f = state_rate(t, y);
  const auto along = [&](const Eigen::VectorXd& direction, double rate, Eigen::Index column, double size) {
    const auto slope = slope_at_zero(
        [&](double s) { return Eigen::VectorXd(Eigen::VectorXd::Constant(1, surface.h(t + s * rate, y + s * direction, column, s))); },
        rate != 0.0 ? way_ahead(t, y, direction) : reach(y, direction, column), Eigen::VectorXd::Constant(1, size));
    if (!slope) end_undifferentiable(name, t, {"has a function without a derivative; let it be smooth where it crosses zero"});
    return (*slope)[0];
  };
  const double speed = along(f, 1.0, -1, 0.0), way = way_ahead(t, y, f);
  // Second order along the motion, and what the method cannot tell from zero.
  const double d = 1e-3 * way, step = 1e-5 * way;
  const Eigen::VectorXd bend = (state_rate(t + step, y + step * f) - state_rate(t - step, y - step * f)) / (2 * step);
  const auto on_motion = [&](double s) { return surface.h(t + s, y + s * f + 0.5 * s * s * bend, -1, 0.0); };
  const double curvature = (on_motion(d) + on_motion(-d) - 2 * on_motion(0.0)) / (d * d);
  const double here = surface.h(t, y, -1, 0.0), by_time = (surface.h(t + d, y, -1, 0.0) - surface.h(t - d, y, -1, 0.0)) / (2 * d);
  double dark = 0.0, parts = std::abs(by_time * t);  // of h, which cancel
  for (Eigen::Index i = 0; i < size_; ++i) {
    const double unseen = rtol * std::abs(y[i]) + atol[i];
    Eigen::VectorXd nearby = y;
    nearby[i] += unseen;
    const double change = std::abs(surface.h(t, nearby, -1, 0.0) - here);
    dark += change;
    if (change > 0.0) parts += change / unseen * std::abs(y[i]);
  }
  constexpr double hidden = 10;
  if (!(speed * speed > 2 * hidden * dark * std::abs(curvature)) || !(std::abs(speed) * way > hidden * dark))
    end_undifferentiable(name, t,
                         {"only grazes zero: its function goes through it at a rate of ", {speed, 4}, " and would turn at a depth of ",
                          {curvature != 0.0 ? 0.5 * speed * speed / std::abs(curvature) : 0.0, 4}, ", of which the tolerances cannot tell ", {dark, 4},
                          "; the motion on either side of a grazing differs, so there is no derivative: choose a start or parameters that hit or miss clearly"});
  Crossing found{Eigen::VectorXd(columns_), speed, by_time, std::max(way, parts / std::abs(speed))};
  // h is the difference of values that are as large as elsewhere on the motion, and known to their rounding. A parameter without
  // influence changes it by nothing more.
  for (Eigen::Index j = 0; j < columns_; ++j) found.time[j] = -along(both.segment(size_ * (j + 1), size_), 0.0, j, std::abs(speed) * found.way) / speed;
  return found;
}

template <class Kind>
void BasicVariationalEquations<Kind>::pass(const std::string& name, double t, Eigen::VectorXd& both, const Surface& surface) {
  const bool together = !passed_.empty() && passed_.back().t == t;
  if (!together) moment_ = {both, {}};
  moment_.passed.push_back({name, surface});
  if (together) require_any_order(t);
  const Eigen::VectorXd before = both.head(size_);
  Eigen::VectorXd time = go_through(name, t, both, surface);
  if (time.size() == 0) return;
  passed_.push_back({t, std::move(time), name, before, both.head(size_)});
  if (branch_anew) branch_anew(t, both.head(size_));
}

// What happens in one moment has a derivative if its order does not matter: the one that came last comes first, and the others follow.
template <class Kind>
void BasicVariationalEquations<Kind>::require_any_order(double t) {
  const auto& all = moment_.passed;
  Eigen::VectorXd in_order = moment_.before, other = moment_.before;
  bool apart = pairs == 0 && changed_ != t;
  for (std::size_t i = 0; i < all.size() && apart; ++i) {
    const auto& [name, surface] = all[(i + all.size() - 1) % all.size()];
    apart = go_through(all[i].name, t, in_order, all[i].surface).size() > 0 && go_through(name, t, other, surface).size() > 0;
  }
  constexpr double differenced = 1e-8;  // how well jumps are differentiated, with a margin
  for (Eigen::Index first = 0; first < in_order.size() && apart; first += size_) {
    const double size = std::max(in_order.segment(first, size_).cwiseAbs().maxCoeff(), moment_.before.segment(first, size_).cwiseAbs().maxCoeff());
    apart = (in_order - other).segment(first, size_).cwiseAbs().maxCoeff() <= differenced * size;
  }
  if (!apart)
    end_undifferentiable(all.back().name, t, {"coincides with '", all[all.size() - 2].name, "': which of them comes first decides what follows, so there is no "
                                              "derivative; choose a start or parameters that separate them"});
}

// y ← the state behind an event, with Φ⁺; ∂t_e/∂x, or nothing where the state is no numbers any more.
template <class Kind>
Eigen::VectorXd BasicVariationalEquations<Kind>::go_through(const std::string& name, double t, Eigen::VectorXd& both, const Surface& surface) {
  const Eigen::VectorXd y = both.head(size_), f_before = state_rate(t, y);
  const Crossing passage = crossing(name, t, both, surface);
  const auto& [time, speed, h_by_t, way] = passage;
  const std::unique_ptr<PairsBehind> pairs_behind = pairs > 0 ? pairs_at(name, t, both) : nullptr;
  Eigen::VectorXd after = y, again = y;
  surface.jump(t, after, -1, 0.0);
  if (!after.allFinite()) {
    both.head(size_) = after;  // the driver names it
    return {};
  }
  const Eigen::VectorXd f_after = state_rate(t, after);
  surface.jump(t, again, -1, 0.0);
  if (!(again.array() == after.array()).all() || !(state_rate(t, again).array() == f_after.array()).all())
    end_undifferentiable(
        name, t,
        {"has an action that does something else each time it is called; let it set what it changes, for it is called several times"});
  // An entry is known to the rounding of its own size, and moves as far as the moment is; one that is zero, to that of its neighbours.
  const Eigen::VectorXd beside = sizes_beside(after.cwiseAbs().cwiseMax(largest_), dof_);
  Eigen::VectorXd known = largest_;
  for (Eigen::Index i = 0; i < size_; ++i) known[i] = std::max(known[i], way * std::max(std::abs(f_before[i]), std::abs(f_after[i])));
  for (Eigen::Index j = 0; j < columns_; ++j) {
    const Eigen::VectorXd Phi = both.segment(size_ * (j + 1), size_);
    const auto behind = [&](double s) {
      // The moment t + later at which the displaced motion is at h = 0: beyond s ∂t_e/∂x by a way of order s², on one side of which friction would
      // still stick. What rounding takes from a late t is made good.
      double later = s * time[j];
      Eigen::VectorXd displaced;
      for (int k = 0; k < 3; ++k) {
        displaced = y + s * Phi + later * f_before;
        later -= (surface.h(t + later, displaced, j, s) + h_by_t * (later - ((t + later) - t))) / speed;
      }
      displaced = y + s * Phi + later * f_before;
      surface.jump(t + later, displaced, j, s);
      return Eigen::VectorXd(displaced - later * f_after);
    };
    // How far it arrives from y may be nothing but rounding, which says nothing; what it is the difference of does.
    constexpr double parts = 16;
    const double distant = parts * std::min(scale(y, Phi), scale(y, f_before * time[j]));
    const auto slope = slope_at_zero(behind, std::min(distant, reach(y, Phi + f_before * time[j], j)), known, beside);
    if (!slope)
      end_undifferentiable(
          name, t, {"changes the state in a way that has no derivative with respect to ", column_name(j), "; let its action be smooth"});
    both.segment(size_ * (j + 1), size_) = *slope;
  }
  if (pairs_behind) pairs_behind->write(surface, passage, after, both);
  surface.jump(t, again = y, -1, 0.0);  // what it sets besides the state is now as it belongs to y
  if (!(state_rate(t, y).array() == f_before.array()).all()) changed_ = t;
  both.head(size_) = after;
  return time;
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template Crossing BasicVariationalEquations<void>::crossing(const std::string&, double, const Eigen::Ref<const Eigen::VectorXd>&, const Surface&) const;
extern template void BasicVariationalEquations<void>::pass(const std::string&, double, Eigen::VectorXd&, const Surface&);
#endif

}  // namespace qdot::detail
