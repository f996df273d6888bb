#pragma once
// SPDX-License-Identifier: MIT
//
// From a task to a motion: solve on a mesh, run the result, refine where it disagrees
// ===================================================================================
//
// A program on a mesh knows nothing of what happens between its points. So each interval is run again by an integrator with error control, from x_k
// with the polynomial u(t), and the distance of its end from x_{k+1} is the error of the interval. Where it is larger than the tolerance, the
// interval is cut into pieces, as many as the order 2s + 1 of the error of an interval asks for. Then the program is solved again from what is
// known. At last the whole motion is run in one go: what it misses at the end is the error that counts.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "qdot/analysis/optimal/collocation.hpp"
#include "qdot/analysis/optimal/controlled.hpp"
#include "qdot/analysis/optimal/sparse_program.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/steps/gauss_table.hpp"

namespace qdot {

/// How a search for an optimal motion ended.
enum class OptimalOutcome {
  solved,           ///< optimal on its mesh, and a run of it agrees to the tolerance
  not_accurate,     ///< optimal on its mesh, but a run of it does not agree: as many refinements or intervals as were allowed
  infeasible,       ///< no motion near by meets all conditions; OptimalTrajectory::missed says which, and by how much
  iteration_limit,  ///< the solver needed more iterations than were allowed
  failed            ///< the solver ended otherwise; the message has its words
};

/// The outcome's name, "not_accurate".
constexpr const char* name(OptimalOutcome outcome) noexcept {
  return detail::name_in({"solved", "not_accurate", "infeasible", "iteration_limit", "failed"}, outcome);
}

/// A condition at the end that a motion misses.
struct MissedCondition {
  std::string name;  ///< of a coordinate or velocity
  double wanted = 0.0, reached = 0.0;
};

/// What a search for an optimal motion found, or how far it came.
struct OptimalEnd {
  OptimalOutcome outcome = OptimalOutcome::failed;  ///< how the search ended
  std::string message{};  ///< what was found or missed, with the numbers
  double cost = std::numeric_limits<double>::quiet_NaN();  ///< of the motion on its mesh; NaN where none was found
  std::vector<double> t{};  ///< the mesh
  Eigen::VectorXd error{};  ///< of each interval: what a run of it differs by, in extents of the motion
  Eigen::VectorXd miss{};   ///< of each condition at the end: what the run of the whole motion differs by
  std::vector<MissedCondition> missed{};  ///< conditions that cannot be met, with what comes nearest
  std::vector<std::string> at_bounds{};   ///< what is at a bound on the way there
  int iterations = 0, refinements = 0;    ///< of the optimizer on all meshes, and of the mesh
  std::vector<Run<Dynamic>> legs{};       ///< runs of the intervals, one after the other

  /// Whether it is optimal on its mesh and a run of it agrees.
  bool solved() const noexcept { return outcome == OptimalOutcome::solved; }
};

/// How an optimal motion is sought.
struct OptimalOptions {
  int intervals = 20;         ///< of the first mesh
  int stages = 3;             ///< s of each interval: the order is 2s
  double tolerance = 1e-8;    ///< of the run of an interval, as part of the extents of the motion
  int most_refinements = 8;
  int most_intervals = 1000;  ///< of the last mesh
  int most_iterations = 500;  ///< of the solver, on each mesh
  Options integration = {.rtol = 1e-11};  ///< of the runs
};

namespace detail {

// Σ values_j ℓ_j(x) through the nodes.
template <class = void>  // compiled only where it is called
Eigen::VectorXd interpolated(const Eigen::VectorXd& nodes, const Eigen::MatrixXd& values, double x) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(values.rows());
  for (Eigen::Index j = 0; j < nodes.size(); ++j) {
    double l = 1.0;
    for (Eigen::Index i = 0; i < nodes.size(); ++i)
      if (i != j) l *= (x - nodes[i]) / (nodes[j] - nodes[i]);
    for (Eigen::Index r = 0; r < sum.size(); ++r) sum[r] += l * values(r, j);
  }
  return sum;
}

// What a search found, and the last mesh.
struct OptimalSearchEnd : OptimalEnd {
  ControlMesh mesh{};
};

// ẋ = f(t, x, u(t)) within interval k. Models FirstOrderSystem.
template <class = void>  // compiled only where it is made
class ControlledForm {
 public:
  static constexpr int size_at_compile_time = Eigen::Dynamic;
  static constexpr int dof_at_compile_time = Eigen::Dynamic;

  ControlledForm(const ControlTask& task, const Eigen::VectorXd& c, const Eigen::MatrixXd& stages, double from, double to)
      : task_(&task), c_(&c), inputs_(stages.bottomRows(task.of->inputs())), from_(from), to_(to) {}

  Eigen::Index size() const noexcept { return task_->of->states(); }
  Eigen::Index dof() const noexcept { return task_->of->states() / 2; }
  void derivative(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot) const {
    ydot = task_->of->rates(t, y, input(t));
  }
  // The explicit methods, which alone are used, never ask.
  void jacobian(double, const Eigen::Ref<const Eigen::VectorXd>&, Eigen::Ref<Eigen::MatrixXd> J) const {
    J.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  std::string component_name(Eigen::Index i) const { return task_->of->state_name(i); }

  Eigen::VectorXd input(double t) const {
    Eigen::VectorXd u = interpolated(*c_, inputs_, (t - from_) / (to_ - from_));
    const Eigen::Index first = task_->of->states();
    for (Eigen::Index i = 0; i < u.size(); ++i) u[i] = std::clamp(u[i], task_->lower[first + i], task_->upper[first + i]);
    return u;
  }

 private:
  const ControlTask* task_;
  const Eigen::VectorXd* c_;
  Eigen::MatrixXd inputs_;
  double from_, to_;
};

using ProgramSolver = std::function<ProgramSolution(SparseProgram&, const ProgramOptions&)>;

template <class = void>  // compiled only where it is made
class OptimalSearch {
 public:
  OptimalSearch(ControlTask task, const OptimalOptions& options, ProgramSolver solver)
      : task_(std::move(task)), options_(options), solver_(std::move(solver)), table_(options.stages) {}

  OptimalSearchEnd end(ControlMesh mesh) {
    OptimalSearchEnd end;
    end.mesh = std::move(mesh);
    for (;; ++end.refinements) {
      Collocation program(task_, end.mesh, options_.stages, false);
      const ProgramSolution solution = solver_(program, solver_options());
      end.iterations += solution.iterations;
      if (solution.outcome != ProgramOutcome::solved) return missed(std::move(end), solution);
      end.mesh = program.mesh(solution.x);
      end.cost = program.cost(solution.x);
      if (!run(end)) return end;
      if (end.error.maxCoeff() <= options_.tolerance || end.refinements == options_.most_refinements) break;
      ControlMesh finer = refined(end.mesh, end.error);
      if (static_cast<Eigen::Index>(finer.part.size()) > options_.most_intervals) break;
      end.mesh = std::move(finer);
    }
    const bool accurate = end.error.maxCoeff() <= options_.tolerance;
    end.outcome = accurate ? OptimalOutcome::solved : OptimalOutcome::not_accurate;
    Eigen::Index worst = 0;
    end.error.maxCoeff(&worst);
    end.message = sentence({accurate ? "solved: on " : "trajectory_optimization: the run must agree with the mesh, but on ", end.error.size(),
                            " intervals it differs by ",
                            {end.error[worst], 3}, " of its extents between t = ", {end.t[static_cast<std::size_t>(worst)], 6}, " and ",
                            {end.t[static_cast<std::size_t>(worst + 1)], 6},
                            "; the run in one go misses the end", most_missed(end),
                            accurate ? "" : "; allow more refinements, or a larger tolerance where an input jumps"});
    return end;
  }

 private:
  std::string most_missed(const OptimalSearchEnd& end) const {
    Eigen::Index worst = 0;
    if (end.miss.size() == 0) return " nowhere, for it is free";
    const double most = end.miss.cwiseAbs().maxCoeff(&worst);
    return sentence({" by at most ", {most, 2}, " in ", task_.of->state_name(task_.held[static_cast<std::size_t>(worst)])});
  }

  ProgramOptions solver_options() const { return {1e-10, options_.most_iterations}; }

  // Runs each interval for its error, and the whole for what it misses.
  bool run(OptimalSearchEnd& end) const {
    const ControlMesh& mesh = end.mesh;
    const auto K = static_cast<Eigen::Index>(mesh.part.size());
    const Eigen::Index N = task_.of->states();
    end.t.assign(1, task_.t_a);
    double sum = 0.0;
    for (const double part : mesh.part) end.t.push_back(task_.t_a + (sum += part) * (mesh.t_b - task_.t_a));
    end.t.back() = mesh.t_b;
    Eigen::VectorXd extent = mesh.x.rowwise().maxCoeff() - mesh.x.rowwise().minCoeff();
    // Of the largest one among coordinates, or among velocities: what rounding makes of a place that stays is no extent.
    constexpr double least_extent = 1e-6;
    for (Eigen::Index half = 0; half < N; half += N / 2) {
      const double largest = extent.segment(half, N / 2).maxCoeff();
      for (Eigen::Index i = half; i < half + N / 2; ++i) extent[i] = largest > 0.0 ? std::max(extent[i], least_extent * largest) : 1.0;
    }
    end.error.resize(K);
    end.legs.clear();
    Eigen::VectorXd x = task_.start;
    Options local = options_.integration;
    local.keep_trajectory = false;
    for (Eigen::Index k = 0; k < K; ++k) {
      const double from = end.t[static_cast<std::size_t>(k)], to = end.t[static_cast<std::size_t>(k + 1)];
      const ControlledForm form(task_, table_.c, mesh.stages[static_cast<std::size_t>(k)], from, to);
      Run<Dynamic> leg = simulate(form, FirstOrderState{from, mesh.x.col(k)}, to, Dop853{}, local);
      end.legs.push_back(simulate(form, FirstOrderState{from, x}, to, Dop853{}, options_.integration));
      for (const Run<Dynamic>* each : {&leg, &end.legs.back()})
        if (!each->completed()) {
          end.message = "trajectory_optimization: a run of the motion that was found must come to its end, but did not, " + each->message;
          return false;
        }
      x = end.legs.back().y;
      end.error[k] = 0.0;
      for (Eigen::Index i = 0; i < N; ++i) end.error[k] = std::max(end.error[k], std::abs(leg.y[i] - mesh.x(i, k + 1)) / extent[i]);
    }
    end.miss = x(task_.held) - task_.target;
    return true;
  }

  ControlMesh refined(const ControlMesh& mesh, const Eigen::VectorXd& error) const {
    const Eigen::Index N = task_.of->states(), m = task_.of->inputs(), s = table_.c.size();
    Eigen::VectorXd nodes(s + 2);
    nodes << 0.0, table_.c, 1.0;
    ControlMesh finer;
    finer.t_b = mesh.t_b;
    std::vector<Eigen::VectorXd> x{mesh.x.col(0)};
    for (Eigen::Index k = 0; k < error.size(); ++k) {
      const auto place = static_cast<std::size_t>(k);
      const double pieces_wanted = std::ceil(std::pow(error[k] / (0.3 * options_.tolerance), 1.0 / static_cast<double>(2 * s + 1)));
      const int pieces = error[k] <= options_.tolerance ? 1 : static_cast<int>(std::clamp(pieces_wanted, 2.0, 4.0));
      Eigen::MatrixXd through(N, s + 2);
      through << mesh.x.col(k), mesh.stages[place].topRows(N), mesh.x.col(k + 1);
      const Eigen::MatrixXd inputs = mesh.stages[place].bottomRows(m);
      for (int piece = 0; piece < pieces; ++piece) {
        finer.part.push_back(mesh.part[place] / pieces);
        Eigen::MatrixXd stages(N + m, s);
        for (Eigen::Index j = 0; j < s; ++j) {
          const double at = (piece + table_.c[j]) / pieces;
          stages.col(j) << interpolated(nodes, through, at), interpolated(table_.c, inputs, at);
        }
        finer.stages.push_back(std::move(stages));
        x.push_back(piece + 1 < pieces ? interpolated(nodes, through, (piece + 1.0) / pieces) : Eigen::VectorXd(mesh.x.col(k + 1)));
      }
    }
    finer.x.resize(N, static_cast<Eigen::Index>(x.size()));
    for (std::size_t k = 0; k < x.size(); ++k) finer.x.col(static_cast<Eigen::Index>(k)) = x[k];
    return finer;
  }

  // Where the solver found nothing: whether the conditions at the end are to blame.
  OptimalSearchEnd missed(OptimalSearchEnd end, const ProgramSolution& first) {
    constexpr double negligible = 1e-6;  // of an extent
    end.outcome = first.outcome == ProgramOutcome::iteration_limit ? OptimalOutcome::iteration_limit : OptimalOutcome::failed;
    end.message = sentence({"trajectory_optimization: the solver must come to an end, but said: ", first.status,
                            "; give a guess that is nearer to a motion, other intervals, or more iterations"});
    Collocation program(task_, end.mesh, options_.stages, true);
    const ProgramSolution nearest = solver_(program, solver_options());
    end.iterations += nearest.iterations;
    if (nearest.outcome != ProgramOutcome::solved || nearest.objective <= negligible) return end;
    end.outcome = OptimalOutcome::infeasible;
    end.mesh = program.mesh(nearest.x);
    std::string conditions;
    for (Eigen::Index e = 0; e < task_.target.size(); ++e) {
      const Eigen::Index i = task_.held[static_cast<std::size_t>(e)];
      const double by = program.missed(nearest.x, e);
      if (std::abs(by) <= negligible * task_.scale[i]) continue;
      end.missed.push_back({task_.of->state_name(i), task_.target[e], task_.target[e] + by});
      conditions += sentence({conditions.empty() ? "" : ", and ", task_.of->state_name(i), " must be ", {task_.target[e], 6},
                              " at the end, but comes no nearer than ",
                              {task_.target[e] + by, 6}, " (off by ", {by, 3}, ")"});
    }
    const Eigen::Index N = task_.of->states(), m = task_.of->inputs();
    std::string bounds;
    for (Eigen::Index i = 0; i < N + m; ++i) {
      const std::string name = i < N ? task_.of->state_name(i) : task_.of->input_name(i - N);
      for (const double bound : {task_.lower[i], task_.upper[i]}) {
        if (!std::isfinite(bound)) continue;
        Eigen::Index there = 0, all = 0;
        for (const Eigen::MatrixXd& stages : end.mesh.stages)
          for (Eigen::Index j = 0; j < stages.cols(); ++j, ++all)
            if (std::abs(stages(i, j) - bound) <= 1e-5 * std::max(1.0, std::abs(bound))) ++there;
        if (there == 0) continue;
        end.at_bounds.push_back(name);
        bounds += sentence({bounds.empty() ? "" : ", ", name, " at its bound ", {bound, 6}, " for ", (100 * there + all / 2) / all, " % of the time"});
      }
    }
    end.message = sentence({"trajectory_optimization: no motion near by meets all conditions: ", conditions, bounds.empty() ? "" : "; the nearest one has ",
                            bounds,
                            "; widen a bound, give it more time, or free a condition"});
    return end;
  }

  ControlTask task_;
  OptimalOptions options_;
  ProgramSolver solver_;
  GaussTable table_;
};

}  // namespace detail

}  // namespace qdot
