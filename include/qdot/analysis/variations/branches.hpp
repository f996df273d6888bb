#pragma once
// SPDX-License-Identifier: MIT
//
// Derivatives across a branch of a functor.
//
// Where T, V or a force compares, f may jump, and ∂f/∂y does not contain the jump. A run looks once at its start whether a
// functor compares anything (ad/formula/branches.hpp). Where one does, the least of the guards of the branch is an event of
// the run. At its zero, with g the guard that fires, and f⁻ and f⁺ in front of it and behind it,
//
//     ∂t_e/∂x = −(∇g·Φ⁻ + ∂g/∂p) / (∇g·f⁻ + ∂g/∂t) ,        Φ⁺ = Φ⁻ + (f⁻ − f⁺) ∂t_e/∂x .
//
// ∇g is exact, from the graph; ∂g/∂p is that of the same branch of the members of a family. The run ends as not_differentiable
//     · where T or p = ∂T/∂q̇ jump, or V at a place, or a constraint or its slope: a blow, which no branch gives;
//     · where g grazes zero, or both sides lead back to it, so that the motion slides along it;
//     · where two guards that depend on different things switch in one moment;
//     · where the motion begins or rests on a switch, and beyond it the equations are others.
// What a functor decides by a plain number (innermost_value, a cast) is not seen, nor what a system of first order does.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "qdot/analysis/variations/branch_guards.hpp"
#include "qdot/analysis/variations/equations.hpp"
#include "qdot/integrate/event.hpp"
#include "qdot/integrate/steps/neighbouring_branches.hpp"

namespace qdot::detail {

template <class Kind = void>  // compiled only where it is made
class FunctorBranches : private BranchGuards<Kind> {
  using Base = BranchGuards<Kind>;
  using Slope = typename Base::Slope;
  using Base::along_columns, Base::along_motion, Base::at_, Base::branch_, Base::direction_, Base::dof_, Base::end_grazing, Base::enter, Base::equations_;
  using Base::guard, Base::guards, Base::hidden, Base::is_same, Base::least_at, Base::length_, Base::moved, Base::nearest, Base::note_size, Base::runner;
  using Base::shortest, Base::size_, Base::slope, Base::take, Base::way, Base::where;

 public:
  using Base::Base;
  ~FunctorBranches() {
    equations_.switch_branch = nullptr, equations_.branch_anew = nullptr;
    equations_.is_same_branch = nullptr, equations_.leap = nullptr;
  }

  // Whether there is anything to watch from here on.
  //
  // @throws EndOfRun  not_differentiable, where the motion begins or rests on a switch
  bool begin(double t, const Eigen::VectorXd& both, double t_end) {
    if (!equations_.records_functors() || dof_ < 1 || t_end == t) return false;
    direction_ = t_end < t ? -1.0 : 1.0, length_ = std::abs(t_end - t);
    const Eigen::VectorXd y = both.head(size_);
    branch_ = recorded_branch(dof_, t, y, runner(-1, 0.0));
    if (guards().empty()) return false;
    enter(t, y);
    for (std::size_t k = 0; k < guards().size(); ++k) require_off(k, t, y, both);
    equations_.switch_branch = [this](double at, Eigen::VectorXd& of) { pass(at, of); };
    equations_.branch_anew = [this](double at, const Eigen::VectorXd& of) { enter(at, of); };
    equations_.is_same_branch = [this](Eigen::Index column, double s, double at, const double* of) { return is_same(column, s, at, of); };
    equations_.leap = [this](double at, Eigen::VectorXd& of) { return leap(at, of); };
    return true;
  }

  // The event function: crosses zero where a guard does, with changing signs from branch to branch.
  double operator()(const auto& q, const auto& qdot, const auto& z, const double& t) const {
    const Eigen::VectorXd y = joined(q, qdot, z);
    note_size(y);
    return side_ * least_at(t, y);
  }
  // The function of another event, with the zeros of nearness().
  double guard_distance(const auto& q, const auto& qdot, const auto& z, const double& t) const { return this->nearness(t, joined(q, qdot, z)); }
  using Base::grazed;

 private:
  // y of an event's arguments; behind the effects' own states z has the columns of Φ.
  Eigen::VectorXd joined(const auto& q, const auto& qdot, const auto& z) const {
    Eigen::VectorXd y(size_);
    y << q, qdot, z.head(size_ - 2 * dof_);
    return y;
  }
  // The motion must not begin, or go on, on guard k, where that has a meaning.
  void require_off(std::size_t k, double t, const Eigen::VectorXd& y, const Eigen::VectorXd& both) {
    std::vector<double> at;
    number_variables(dof_, t, y, at);
    const formula::Guard& g = guards()[k];
    if (branch_->values({g.node}, at)[0] != g.level) return;
    const double span = way(t, y), s = 1e-3 * direction_ * span;
    number_variables(dof_, t + s, moved(t, y, s), at);
    const bool rests = branch_->values({g.node}, at)[0] == g.level;
    number_variables(dof_, t, y, at);
    const auto other = neighbour(*branch_, k, dof_, t, y, runner(-1, 0.0));
    if (!differ(*branch_, *other, at, rests ? 1 : 0)) return;
    const Slope by = slope(k, t, y);
    const Eigen::VectorXd f = equations_.state_rate(t, y), along = along_columns(k, t, both, by);
    const auto starts = static_cast<Eigen::Index>(equations_.start_entries().size());
    for (Eigen::Index j = 0; j < along.size(); ++j) {
      const bool of_time = equations_.column_name(j) == "the time of the start" && j >= starts;
      if (along[j] == 0.0 && !(of_time && by.by_t != 0.0)) continue;
      end_undifferentiable(g.what, t, {rests ? "stays undecided along the motion" : "is undecided where the motion begins", where(y),
                                       ": on either side of it the equations differ, so there is no derivative with respect to ", equations_.column_name(j),
                                       "; begin beside it"});
    }
  }

  // Whether what two branches return differs at a switch in a way that is a blow: the name of it.
  const char* blow(RecordedBranch& before, RecordedBranch& behind, double t, const Eigen::VectorXd& y, bool at_a_place) const {
    constexpr double rounding = 1e-9;
    std::vector<double> at;
    number_variables(dof_, t, y, at);
    const auto& a = before.motion.returned;
    const auto& b = behind.motion.returned;
    if (a.size() < 2 || b.size() != a.size()) return nullptr;
    const auto jumps = [&](std::size_t i, const std::vector<int>& by, bool slopes_too, double size) {
      const auto here = before.values(derivatives_of(before.motion.recording.graph, a[i], by, 1), at);
      const auto there = behind.values(derivatives_of(behind.motion.recording.graph, b[i], by, 1), at);
      double steepest = 0.0;
      for (std::size_t k = 1; k < here.size(); ++k) {
        const double x = at[static_cast<std::size_t>(before.motion.recording.graph[by[k - 1]].a)];
        size += (std::abs(here[k]) + std::abs(there[k])) * std::abs(x);
        steepest = std::max({steepest, std::abs(here[k]), std::abs(there[k])});
      }
      bool far_apart = std::abs(here[0] - there[0]) > rounding * (size + std::abs(here[0]) + std::abs(there[0]));
      for (std::size_t k = 1; slopes_too && k < here.size(); ++k) far_apart = far_apart || std::abs(here[k] - there[k]) > rounding * steepest;
      return far_apart;
    };
    const std::vector<int> q = before.motion.q, qdot = before.motion.qdot;
    const double T = std::abs(before.values({a[0]}, at)[0]);
    if (jumps(0, qdot, true, T)) return "the kinetic energy or the momenta";
    if (at_a_place && jumps(1, q, false, T)) return "the potential energy";
    std::vector<int> all = q;
    all.insert(all.end(), qdot.begin(), qdot.end());
    for (std::size_t i = 2 + before.forces; i < a.size(); ++i)
      if (jumps(i, all, true, 0.0)) return "a constraint or its slope";
    return nullptr;
  }

  // Behind the zero of a guard.
  void pass(double t, Eigen::VectorXd& both) {
    const Eigen::VectorXd y = both.head(size_);
    const double span = way(t, y);
    double s = shortest(t, span);
    Eigen::VectorXd ahead, back;
    for (;; s *= 8) {
      ahead = moved(t, y, direction_ * s), back = moved(t, y, -direction_ * s);
      if (least_at(t - direction_ * s, back) > 0.0 && least_at(t + direction_ * s, ahead) < 0.0) break;
      if (s > 1e-5 * span) return touched(t, y);
    }
    s *= 4;
    ahead = moved(t, y, direction_ * s), back = moved(t, y, -direction_ * s);
    least_at(t + direction_ * s, ahead);
    std::vector<std::size_t> fired;
    for (std::size_t k = 0; k < guards().size(); ++k)
      if (guard(k) < 0.0) fired.push_back(k);
    const Eigen::VectorXd f_before = equations_.state_rate(t - direction_ * s, back), f_behind = equations_.state_rate(t + direction_ * s, ahead);
    auto behind = recorded_branch(dof_, t + direction_ * s, ahead, runner(-1, 0.0));
    const formula::Guard& first = guards()[fired.front()];
    const Slope by = slope(fired.front(), t, y);
    if (const char* what = blow(*branch_, *behind, t, y, by.by_y.cwiseAbs().maxCoeff() > 0.0))
      end_undifferentiable(first.what, t, {"decides", where(y), ", about ", what,
                                           ", which jumps there: that is a blow, and no equations of motion say what it does; let it be continuous, or use an event"});
    if (jumps(t, y, s, f_before, f_behind)) go_through(t, both, distinct(fired), s, f_before, f_behind, span);
    take(std::move(behind));
    side_ = -side_;
    put_behind(t, both);
  }

  // One of each guard among those that fired.
  std::vector<std::size_t> distinct(const std::vector<std::size_t>& fired) const {
    std::vector<std::size_t> some;
    for (const std::size_t k : fired)
      if (std::none_of(some.begin(), some.end(),
                       [&](std::size_t i) { return guards()[i].node == guards()[k].node && guards()[i].level == guards()[k].level; }))
        some.push_back(k);
    return some;
  }

  // Φ behind guards at which f jumps: of one, or of several at the same time that do not see each other.
  void go_through(double t, Eigen::VectorXd& both, const std::vector<std::size_t>& fired, double s, const Eigen::VectorXd& f_before,
                  const Eigen::VectorXd& f_behind, double span) {
    const Eigen::VectorXd y = both.head(size_);
    const std::string& what = guards()[fired.front()].what;
    std::vector<Slope> slopes;
    std::vector<Eigen::VectorXd> times;
    for (const std::size_t k : fired) {
      slopes.push_back(slope(k, t, y));
      times.push_back(crossing(k, t, both, slopes.back(), f_before, f_behind, span));
    }
    const auto equal = [](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
      return (a - b).cwiseAbs().maxCoeff() <= 1e-9 * std::max(a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff());
    };
    const bool same_times = std::all_of(times.begin(), times.end(), [&](const Eigen::VectorXd& time) { return equal(time, times.front()); });
    if (!equations_.passed().empty() && std::abs(equations_.passed().back().t - t) <= 64 * std::numeric_limits<double>::epsilon() * std::abs(t) &&
        !(same_times && equal(equations_.passed().back().time, times.front())))
      end_together(what, "an event or another comparison", t, y);
    std::vector<Eigen::VectorXd> alone{f_behind};
    for (std::size_t i = 0; i < fired.size() && !same_times; ++i) {
      alone.resize(fired.size());
      alone[i] = rate_behind(i, slopes, t, y, s * span);
    }
    if (!same_times) {  // what each of them does alone adds up, and leaves the rates of the other guards as they are
      Eigen::VectorXd sum = f_before;
      bool apart = true;
      for (std::size_t i = 0; i < fired.size(); ++i) {
        const Eigen::VectorXd change = alone[i] - f_before;
        sum += change;
        for (std::size_t k = 0; k < fired.size(); ++k)
          apart = apart && (k == i || std::abs(slopes[k].by_y.dot(change)) <= 1e-6 * std::abs(slopes[k].by_t + slopes[k].by_y.dot(f_before)));
      }
      if (!apart || !((sum - f_behind).cwiseAbs().maxCoeff() <= 1e-6 * (f_behind - f_before).cwiseAbs().maxCoeff()))
        end_together(what, guards()[fired[1]].what, t, y);
    }
    for (std::size_t i = 0; i < alone.size(); ++i)
      for (Eigen::Index j = 0; j < equations_.columns(); ++j) both.segment(size_ * (j + 1), size_) += (f_before - alone[i]) * times[i][j];
    Eigen::VectorXd time = times.front();
    equations_.note_passed(t, time);
  }
  [[noreturn]] void end_together(const std::string& what, const std::string& with, double t, const Eigen::VectorXd& y) const {
    end_undifferentiable(what, t, {"switches in one moment with '", with, "'", where(y), ": which comes first decides what follows, so there is no derivative; "
                                   "choose a start or parameters that separate them"});
  }

  // f where of the guards that fire only number i has, at a state beside y.
  Eigen::VectorXd rate_behind(std::size_t i, const std::vector<Slope>& slopes, double t, const Eigen::VectorXd& y, double) const {
    const auto count = static_cast<Eigen::Index>(slopes.size());
    Eigen::MatrixXd G(count, size_ + 1);
    Eigen::VectorXd wanted(count);
    const Eigen::VectorXd f = equations_.state_rate(t, y);
    for (Eigen::Index k = 0; k < count; ++k) {
      const Slope& by = slopes[static_cast<std::size_t>(k)];
      G.row(k) << by.by_y.transpose(), by.by_t;
      wanted[k] = (k == static_cast<Eigen::Index>(i) ? 1.0 : -1.0) * direction_ * 1e-10 * way(t, y) * (by.by_t + by.by_y.dot(f));
    }
    const Eigen::VectorXd beside = G.transpose() * (G * G.transpose()).ldlt().solve(wanted);
    return equations_.state_rate(t + beside[size_], y + beside.head(size_));
  }

  // Over a guard that is so close that t can hardly tell: no step gets over it, where the rates jump by more than the tolerances can take. The little time
  // that is left is gone on the old branch, without t.
  bool leap(double t, Eigen::VectorXd& both) {
    const Eigen::VectorXd y = both.head(size_);
    const double ulp = std::numeric_limits<double>::epsilon() * std::max(std::abs(t), 1e-3 * way(t, y));
    const auto is_ahead = [&](double s) { return least_at(t, moved(t, y, direction_ * s)) < 0.0; };
    if (both.size() != equations_.size() || !(least_at(t, y) > 0.0) || !is_ahead(4096 * ulp)) return false;
    double before = 0.0, behind = 4096 * ulp;
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (before + behind);
      (is_ahead(middle) ? behind : before) = middle;
    }
    Eigen::VectorXd rates(both.size());
    equations_.write_rates(t, both.data(), rates.data());
    both += direction_ * before * rates;
    pass(t, both);
    return least_at(t, both.head(size_)) > 0.0;
  }

  // y ← the next state that rounding leaves no doubt about, on the branch that has been entered; a guard of time alone stays where it is.
  void put_behind(double t, Eigen::VectorXd& both) const {
    const Eigen::VectorXd y = both.head(size_);
    double s = 0x1p-70 * way(t, y);
    for (int k = 0; k < 30 && least_at(t, both.head(size_)) <= 0.0; ++k, s *= 2) both.head(size_) = moved(t, y, direction_ * s);
    if (!(least_at(t, both.head(size_)) > 0.0)) both.head(size_) = y;
  }

  // A guard came to zero and goes back.
  void touched(double t, const Eigen::VectorXd& y) {
    least_at(t, y);
    const std::size_t k = nearest();
    const std::vector<double> at = at_;
    const auto other = neighbour(*branch_, k, dof_, t, y, runner(-1, 0.0));
    if (differ(*branch_, *other, at, 0)) {
      const double span = way(t, y), s = 1e-5 * direction_ * span;
      const Eigen::VectorXd back = y - s * equations_.state_rate(t, y), f = equations_.state_rate(t - s, back);
      const Slope by = slope(k, t, y);
      if (std::abs(by.by_t + by.by_y.dot(f)) > 1e-3 * (std::abs(by.by_t) + by.by_y.cwiseAbs().dot(f.cwiseAbs()))) end_sliding(k, t, y);
      end_grazing(k, t, y);
    }
    enter(t, y);
  }
  [[noreturn]] void end_sliding(std::size_t k, double t, const Eigen::VectorXd& y) const {
    end_undifferentiable(guards()[k].what, t,
                         {"is approached from both sides", where(y), ": the motion slides along it, and neither branch has its equations; use an effect that "
                          "sticks, or a smooth passage"});
  }
  // Whether f differs on the two sides by more than the way between them makes it: that grows with s.
  bool jumps(double t, const Eigen::VectorXd& y, double s, const Eigen::VectorXd& f_before, const Eigen::VectorXd& f_behind) const {
    const double longer = 256 * direction_ * s;
    const Eigen::VectorXd wide = equations_.state_rate(t + longer, moved(t, y, longer)) - equations_.state_rate(t - longer, moved(t, y, -longer));
    const double jump = (f_behind - f_before).tail(size_ - dof_).cwiseAbs().maxCoeff(), change = wide.tail(size_ - dof_).cwiseAbs().maxCoeff();
    const double size = std::max(f_before.tail(size_ - dof_).cwiseAbs().maxCoeff(), f_behind.tail(size_ - dof_).cwiseAbs().maxCoeff());
    return jump > 1e-11 * size && jump > 0.05 * change;
  }

  // ∂t_e/∂x of guard k.
  Eigen::VectorXd crossing(std::size_t k, double t, const Eigen::VectorXd& both, const Slope& by, const Eigen::VectorXd& f_before,
                           const Eigen::VectorXd& f_behind, double span) const {
    const Eigen::VectorXd y = both.head(size_);
    const double speed = by.by_t + by.by_y.dot(f_before), speed_behind = by.by_t + by.by_y.dot(f_behind);
    // What the method cannot tell from zero, and at which depth the guard would turn in front of it.
    const double dark = by.by_y.cwiseAbs().dot(equations_.resolution(y)), curvature = along_motion(k, t, y, f_before, span).curvature;
    if (!(speed * speed > 2 * hidden * dark * std::abs(curvature)) || !(std::abs(speed) * span > hidden * dark)) end_grazing(k, t, y);
    if (!(direction_ * speed < 0.0 && direction_ * speed_behind < 0.0) || std::abs(speed_behind) * span <= hidden * dark)
      end_sliding(k, t, y);
    return -along_columns(k, t, both, by) / speed;
  }

  double side_ = 1.0;
};

#ifdef QDOT_COMPILED_ANALYSIS
extern template class FunctorBranches<void>;
#endif

// The zero of a guard as an event of a run.
struct GuardOfBranches {
  const FunctorBranches<>* branches;
  double operator()(const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const OwnStates& z, const double& t) const { return (*branches)(q, qdot, z, t); }
};
// Zero where the motion is so close to a guard that it may graze it.
struct NearBranches {
  const FunctorBranches<>* branches;
  double operator()(const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const OwnStates& z, const double& t) const {
    return branches->guard_distance(q, qdot, z, t);
  }
};
struct ChangeOfBranch {
  VariationalEquations* changes;
  void operator()(double t, Eigen::VectorXd& both) const { changes->pass_branch(t, both); }
};
inline const char* const name_of_branch_event = "a branch of a functor";

template <class... Events>
auto with_branches(const EventList<Events...>& list, const FunctorBranches<>& branches, VariationalEquations& changes) {
  using NearGuards = Event<NearBranches, RecordOnly>;
  using AtGuards = Event<GuardOfBranches, ChangeOfBranch>;
  return EventList<Events..., NearGuards, AtGuards>{
      std::tuple_cat(list.list, std::tuple(NearGuards{name_of_branch_event, NearBranches{&branches}, Direction::either, {}},
                                           AtGuards{name_of_branch_event, GuardOfBranches{&branches}, Direction::either, ChangeOfBranch{&changes}}))};
}

// What the run recorded without the switches, which are no events of its caller.
inline void leave_branches_out(std::vector<RecordedEvent>& events) {
  std::erase_if(events, [](const RecordedEvent& event) { return event.name == name_of_branch_event; });
}

}  // namespace qdot::detail
