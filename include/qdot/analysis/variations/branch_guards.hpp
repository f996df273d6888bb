#pragma once
// SPDX-License-Identifier: MIT
//
// The branch that the functors of a model are on, its guards, and how they change: what derivatives across a switch (branches.hpp) ask for.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "qdot/analysis/variations/equations.hpp"
#include "qdot/analysis/variations/slope.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/steps/neighbouring_branches.hpp"

namespace qdot::detail {

template <class = void>  // compiled only where it is made
class BranchGuards {
 public:
  explicit BranchGuards(VariationalEquations& equations) : equations_(equations), size_(equations.state_size()), dof_(equations.dof()) {}
  BranchGuards(const BranchGuards&) = delete;
  BranchGuards& operator=(const BranchGuards&) = delete;

  // Where the motion has turned back at a guard, and why there is no derivative.
  struct Grazing {
    double t;
    Failure failure;
  };
  const std::optional<Grazing>& grazed() const { return grazed_; }

 protected:
  static constexpr double hidden = 10;  // so many times what the tolerances tell apart is no difference

  const std::vector<formula::Guard>& guards() const { return branch_->branches.met; }
  formula::Graph& graph() const { return branch_->motion.recording.graph; }
  RunFunctors runner(Eigen::Index column, double s) const {
    return [this, column, s](RecordedBranch& branch) { equations_.record(branch, column, s); };
  }

  // Guard k where values_ belong to; a closed one holds at zero.
  double guard(std::size_t k) const {
    const formula::Guard& g = guards()[k];
    const double value = g.sign * (values_[static_cast<std::size_t>(g.node)] - g.level);
    return value == 0.0 && g.closed ? std::numeric_limits<double>::denorm_min() : value;
  }
  double least() const {
    evaluate();
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < guards().size(); ++k)
      if (const double g = guard(k); g < least) least = g;  // not where it has no value, beyond another guard
    return std::isfinite(least) ? least : 1.0;
  }
  // The number of the least guard where values_ belong to.
  std::size_t nearest() const {
    std::size_t k = 0;
    for (std::size_t i = 1; i < guards().size(); ++i)
      if (guard(i) < guard(k)) k = i;
    return k;
  }
  void evaluate() const {
    int last = -1;
    for (const formula::Guard& g : guards()) last = std::max(last, g.node);
    values_.clear();
    formula::evaluate_nodes(graph(), at_, values_, static_cast<std::size_t>(last) + 1);
  }
  double least_at(double t, const Eigen::VectorXd& y) const {
    number_variables(dof_, t, y, at_);
    return least();
  }

  // Whether the guards of a member of the family have the same signs.
  bool is_same(Eigen::Index column, double s, double t, const double* y) {
    const Eigen::Map<const Eigen::VectorXd> state(y, size_);
    number_variables(dof_, t, state, at_);
    evaluate();
    std::unique_ptr<RecordedBranch>& beside = near_[{column, s}];
    if (!beside) beside = recorded_branch(dof_, t, state, runner(column, s), &guards());
    const auto& met = beside->branches.met;
    if (met.size() != guards().size()) return false;
    beside->branches.values.clear();
    formula::evaluate_nodes(beside->motion.recording.graph, at_, beside->branches.values, beside->motion.recording.graph.nodes().size());
    for (std::size_t k = 0; k < met.size(); ++k) {
      const double there = met[k].sign * (beside->branches.values[static_cast<std::size_t>(met[k].node)] - met[k].level);
      if ((there < 0.0 || (there == 0.0 && !met[k].closed)) != (guard(k) <= 0.0)) return false;
    }
    return true;
  }

  // The motion a time s later or earlier, to second order.
  Eigen::VectorXd moved(double t, const Eigen::VectorXd& y, double s) const {
    const Eigen::VectorXd f = equations_.state_rate(t, y);
    return y + 0.5 * s * (f + equations_.state_rate(t + s, y + s * f));
  }
  // The shortest time in which the positions or the velocities change by their size, at most the run. Sizes are those that steps have kept, for
  // stages may be anywhere.
  double way(double t, const Eigen::VectorXd& y) const {
    const Eigen::VectorXd f = equations_.state_rate(t, y);
    note_size(y);
    double least = length_;
    for (const Eigen::Index first : {Eigen::Index(0), dof_}) {
      const double size = sizes_.segment(first, dof_).maxCoeff(), speed = f.segment(first, dof_).cwiseAbs().maxCoeff();
      if (speed > 0.0) least = std::min(least, (size > 0.0 ? size : 1.0) / speed);
    }
    return least;
  }
  void note_size(const Eigen::VectorXd& y) const {
    if (sizes_.size() == 0) sizes_ = Eigen::VectorXd::Zero(2 * dof_);
    for (Eigen::Index i = 0; i < 2 * dof_; ++i) sizes_[i] = std::max(sizes_[i], std::abs(y[i]));
  }
  double shortest(double t, double way) const { return std::max(0x1p-44 * way, 16 * std::numeric_limits<double>::epsilon() * std::abs(t)); }

  void take(std::unique_ptr<RecordedBranch> branch) { branch_ = std::move(branch), near_.clear(), largest_ = 0.0; }

  // Takes the branch into which the motion goes from y: as far ahead as it takes to leave every tie.
  void enter(double t, const Eigen::VectorXd& y) {
    const double span = way(t, y);
    double s = shortest(t, span);
    for (int k = 0; k < 12; ++k, s *= 16) {
      const Eigen::VectorXd ahead = moved(t, y, direction_ * s);
      take(recorded_branch(dof_, t + direction_ * s, ahead, runner(-1, 0.0)));
      least_at(t + direction_ * s, ahead);
      const bool decided = std::none_of(guards().begin(), guards().end(),
                                        [&](const formula::Guard& g) { return values_[static_cast<std::size_t>(g.node)] == g.level; });
      if (decided || s > 1e-3 * span) break;
    }
  }

  // The least guard at a state, less as much as tolerances hide of it: zero where the motion comes so close that it may graze. Evaluated there it notes
  // whether the guard turns back before it has clearly crossed, if the equations behind it are others.
  double nearness(double t, const Eigen::VectorXd& y) const {
    const double g = least_at(t, y);
    largest_ = std::max(largest_, g);
    if (grazed_ || g > 1e-4 * largest_) return g;
    const std::size_t k = nearest();
    const double band = hidden * slope(k, t, y).by_y.cwiseAbs().dot(equations_.resolution(y));
    if (std::abs(g - band) < 0.1 * band && turns_back(k, t, y, band)) note_grazing(k, t, y);
    return g - band;
  }
  // Whether a guard that is so near to zero has its least value there, by its parabola along the motion.
  bool turns_back(std::size_t k, double t, const Eigen::VectorXd& y, double band) const {
    const Parabola g = along_motion(k, t, y, equations_.state_rate(t, y), way(t, y));
    return g.curvature > 0.0 && g.value - 0.5 * g.speed * g.speed / g.curvature > -band;
  }
  // A guard along the motion near y, whose rate there is f, by its values a little before and behind. The rate a little before gives the motion its bend.
  struct Parabola {
    double value, speed, curvature;
  };
  Parabola along_motion(std::size_t k, double t, const Eigen::VectorXd& y, const Eigen::VectorXd& f, double span) const {
    const double d = 1e-4 * direction_ * span;
    const Eigen::VectorXd bend = (f - equations_.state_rate(t - d, y - d * f)) / d;
    const auto on_motion = [&](double later) {
      number_variables(dof_, t + later, y + later * f + 0.5 * later * later * bend, at_);
      evaluate();
      return guard(k);
    };
    const double before = on_motion(-d), here = on_motion(0.0), behind = on_motion(d);
    return {here, (behind - before) / (2 * d), (behind - 2 * here + before) / (d * d)};
  }
  void note_grazing(std::size_t k, double t, const Eigen::VectorXd& y) const {
    const auto other = neighbour(*branch_, k, dof_, t, y, runner(-1, 0.0));
    std::vector<double> at;
    number_variables(dof_, t, y, at);
    if (!differ(*branch_, *other, at, 0)) return;
    try {
      end_grazing(k, t, y);
    } catch (EndOfRun& end) {
      grazed_ = {t, std::move(end.failure)};
    }
  }
  [[noreturn]] void end_grazing(std::size_t k, double t, const Eigen::VectorXd& y) const {
    end_undifferentiable(guards()[k].what, t,
                         {"is only touched", where(y), ": the equations behind it are others, and the motion on either side of a grazing differs, so there "
                          "is no derivative; choose a start or parameters that cross or miss it clearly"});
  }

  std::string where(const Eigen::VectorXd& y) const {
    std::string text = ", at ";
    for (Eigen::Index i = 0; i < std::min<Eigen::Index>(size_, 4); ++i) text += sentence({i > 0 ? ", " : "", equations_.state_name(i), " = ", y[i]});
    return text;
  }

  // ∂g/∂(t, y) of guard k.
  struct Slope {
    double by_t = 0.0;
    Eigen::VectorXd by_y{};
  };
  Slope slope(std::size_t k, double t, const Eigen::VectorXd& y) const {
    const std::vector<int> nodes = graph().gradient(guards()[k].node, branch_->variables());
    std::vector<double> at;
    number_variables(dof_, t, y, at);
    const std::vector<double> values = branch_->values(nodes, at);
    Slope slope{guards()[k].sign * values.back(), Eigen::VectorXd(size_)};
    for (Eigen::Index i = 0; i < size_; ++i) slope.by_y[i] = guards()[k].sign * values[static_cast<std::size_t>(i)];
    return slope;
  }
  // ∂g/∂x of guard k at a fixed time, a column of Φ after the other.
  Eigen::VectorXd along_columns(std::size_t k, double t, const Eigen::VectorXd& both, const Slope& slope) const {
    const Eigen::VectorXd y = both.head(size_);
    Eigen::VectorXd along(equations_.columns());
    for (Eigen::Index j = 0; j < along.size(); ++j) {
      along[j] = slope.by_y.dot(both.segment(size_ * (j + 1), size_));
      if (!std::isfinite(equations_.parameter_size(j))) continue;
      const auto displaced = [&](double s) {
        const auto beside = recorded_branch(dof_, t, y, runner(j, s), &guards());
        if (beside->branches.met.size() <= k) throw InvalidValue("a member of the family compares less than others");
        const formula::Guard& g = beside->branches.met[k];
        formula::evaluate_nodes(beside->motion.recording.graph, beside->branches.variables, beside->branches.values, static_cast<std::size_t>(g.node) + 1);
        return Eigen::VectorXd(Eigen::VectorXd::Constant(1, g.sign * (beside->branches.values[static_cast<std::size_t>(g.node)] - g.level)));
      };
      const auto by_p = slope_at_zero(displaced, equations_.parameter_size(j));
      if (!by_p) end_undifferentiable(guards()[k].what, t, {"depends on ", equations_.column_name(j), " without a derivative; let it depend smoothly on it"});
      along[j] += (*by_p)[0];
    }
    return along;
  }

  VariationalEquations& equations_;
  Eigen::Index size_, dof_;
  double direction_ = 1.0, length_ = 1.0;  // of the run
  std::unique_ptr<RecordedBranch> branch_{};
  std::map<std::pair<Eigen::Index, double>, std::unique_ptr<RecordedBranch>> near_{};  // members of a family on this branch
  mutable std::vector<double> at_{}, values_{};
  mutable Eigen::VectorXd sizes_{};
  mutable double largest_ = 0.0;  // of the least guard
  mutable std::optional<Grazing> grazed_{};
};

#ifdef QDOT_COMPILED_ANALYSIS
extern template class BranchGuards<void>;
#endif

}  // namespace qdot::detail
