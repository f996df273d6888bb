#pragma once
// SPDX-License-Identifier: MIT
//
// A fit of parameters to measurements of any motion: residuals of all experiments as one function of all unknowns, and its least squares. It also
// tells how well the data determine the result.
//
//     x = [p; unknown start values of experiment 0; of experiment 1; …]

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "qdot/analysis/fit/least_squares.hpp"
#include "qdot/analysis/fit/prediction.hpp"
#include "qdot/analysis/linear/shortest_step.hpp"
#include "qdot/error.hpp"

namespace qdot {

/// A parameter that is sought; or held, where both bounds are the guess.
struct FitParameter {
  std::string name{};
  double guess = 0.0;  ///< where the search begins
  double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();
};

/// How parameters are sought.
struct FitOptions {
  int most_runs = 200;       ///< runs of each experiment
  double tolerance = 1e-10;  ///< what a last step may take from Σr², as part of it; with data that fit exactly, a step as part of p
};

/// How a fit ended.
enum class FitOutcome { converged, at_bound, undetermined, no_progress, run_limit, motion_failed };

/// The outcome's name, "at_bound".
constexpr std::string_view name(FitOutcome outcome) noexcept {
  return detail::name_in({"converged", "at_bound", "undetermined", "no_progress", "run_limit", "motion_failed"}, outcome);
}

/// What a fit found.
struct ParameterFit {
  FitOutcome outcome = FitOutcome::motion_failed;
  std::string message{};             ///< how it ended, with the numbers and what to do
  std::vector<std::string> names{};  ///< of the parameters, then of unknown start values
  Eigen::VectorXd p{};               ///< the best that was found, in the order of names
  Eigen::VectorXd standard_deviation{};  ///< of each; 0 where it is held at a bound, ∞ where the data leave it open
  Eigen::MatrixXd covariance{};          ///< of what the data determine; rows and columns of held parameters are 0
  Eigen::MatrixXd open{};                ///< a column for each direction of p in which nothing measured changes
  std::vector<std::string> at_bound{};   ///< names of parameters that the data would move beyond a bound
  double chi_squared = 0.0;              ///< Σ r² at p
  double sigma = 1.0;                    ///< of the measurements: estimated if it was not given, otherwise 1, in units of the one that was
  Eigen::Index degrees_of_freedom = 0;   ///< residuals less parameters that they determine
  std::vector<Eigen::MatrixXd> residuals{};  ///< of each experiment, outputs × times, in σ
  int runs = 0;                              ///< of each experiment

  bool converged() const noexcept { return outcome == FitOutcome::converged; }
};

namespace detail {

// An experiment without the types of what moves and is measured.
struct FitExperiment {
  Predict predict;
  Eigen::VectorXd start;
  std::vector<double> times;
  Eigen::MatrixXd measured;
  Eigen::VectorXd sigma;
  std::vector<Eigen::Index> unknown;
  double begins = std::numeric_limits<double>::quiet_NaN();
};

struct FitTask {
  std::vector<FitParameter> parameters;
  std::vector<FitExperiment> experiments;
  FitOptions options;
  double rtol = 0.0;
};

template <class = void>  // compiled only where it is called
void require_fit(const FitTask& task) {
  constexpr const char* who = "parameter_fit";
  const auto require = [](bool holds, std::initializer_list<Phrase> otherwise) {
    if (!holds) throw_invalid_value(otherwise);
  };
  require(!task.experiments.empty(), {who, ": there must be experiments, but there are none; give one at least"});
  require(task.options.most_runs >= 1 && task.options.tolerance > 0.0 && task.options.tolerance < 1.0,
          {who, ": there must be runs, and a tolerance between 0 and 1, but they are ", task.options.most_runs, " and ", task.options.tolerance,
           "; leave them out for 200 and 1e-10"});
  for (const FitParameter& each : task.parameters)
    require(std::isfinite(each.guess) && each.lower <= each.guess && each.guess <= each.upper,
            {who, ": the guess of '", each.name, "' must be finite and lie within its bounds, but is ", each.guess, " with bounds ", each.lower,
             " and ", each.upper, "; choose another guess or other bounds"});
  for (std::size_t e = 0; e < task.experiments.size(); ++e) {
    const FitExperiment& each = task.experiments[e];
    require(!each.times.empty(), {who, ": experiment ", e, " must have times, but has none; give the times of its measurements"});
    const bool backwards = each.times.back() < (std::isnan(each.begins) ? each.times.front() : each.begins);
    double before = std::isnan(each.begins) ? each.times.front() : each.begins;
    for (std::size_t k = 0; k < each.times.size(); ++k) {
      const bool follows = backwards ? each.times[k] < before : each.times[k] > before;
      require(follows || (k == 0 && each.times[k] == before && (each.times.size() > 1 || std::isnan(each.begins))),
              {who, ": the times of experiment ", e, " must go on from its start, but ", each.times[k], " comes after ", before, "; sort them"});
      before = each.times[k];
    }
    if (each.measured.cols() != static_cast<Eigen::Index>(each.times.size()))
      throw DimensionError(sentence({who, ": the measurements of experiment ", e, ", a column for each time,"}), static_cast<long>(each.times.size()),
                           static_cast<long>(each.measured.cols()), "give outputs × times");
    require(each.measured.allFinite(), {who, ": the measurements of experiment ", e, " must be finite, but one is not; leave its time out"});
    require((each.sigma.size() == 0) == (task.experiments[0].sigma.size() == 0),
            {who, ": standard deviations must be known in all experiments or in none, but in experiment ", e,
             " it is otherwise than in the first; give sigma to both"});
    if (each.sigma.size() > 0 && each.sigma.size() != each.measured.rows())
      throw DimensionError(sentence({who, ": sigma of experiment ", e}), static_cast<long>(each.measured.rows()), static_cast<long>(each.sigma.size()),
                           "give one for each output");
    for (Eigen::Index i = 0; i < each.sigma.size(); ++i)
      require(each.sigma[i] > 0.0 && std::isfinite(each.sigma[i]),
              {who, ": a standard deviation must be positive and finite, but sigma[", i, "] of experiment ", e, " is ", each.sigma[i],
               "; leave sigma out where it is unknown"});
    for (const Eigen::Index i : each.unknown)
      require(i >= 0 && i < each.start.size(),
              {who, ": unknown entries of a start must be those of [q; qdot], 0 to ", each.start.size() - 1, ", but one of experiment ", e, " is ", i,
               "; count from 0"});
  }
}

// Residuals of all experiments, and their slopes.
template <class = void>  // compiled only where it is made
class FitResiduals {
 public:
  explicit FitResiduals(const FitTask& task) : task_(task) {
    for (const FitExperiment& each : task.experiments) rows_ += each.measured.size();
  }

  Eigen::Index rows() const { return rows_; }

  ResidualsAt operator()(const Eigen::VectorXd& x) const {
    const auto m = static_cast<Eigen::Index>(task_.parameters.size());
    ResidualsAt at{x, Eigen::VectorXd::Zero(rows_), Eigen::MatrixXd::Zero(rows_, x.size()), {}};
    Eigen::Index row = 0, column = m;
    for (std::size_t e = 0; e < task_.experiments.size() && at.trouble.empty(); ++e) {
      const FitExperiment& each = task_.experiments[e];
      Eigen::VectorXd start = each.start;
      for (std::size_t k = 0; k < each.unknown.size(); ++k) start[each.unknown[k]] = x[column + static_cast<Eigen::Index>(k)];
      Predicted found;
      try {
        found = each.predict(x.head(m), start, !each.unknown.empty());
      } catch (const Error& error) {
        if (first_) throw;
        found.trouble = error.what();
      }
      if (!found.trouble.empty()) {
        at.trouble = sentence({"experiment ", e, ": ", found.trouble});
        break;
      }
      const Eigen::Index outputs = each.measured.rows(), starts = each.unknown.empty() ? 0 : start.size();
      if (found.values.rows() != outputs)
        throw DimensionError(sentence({"parameter_fit: a measurement of experiment ", e}), static_cast<long>(found.values.rows()),
                             static_cast<long>(outputs), "give a row for each output; without outputs these are the coordinates");
      for (Eigen::Index k = 0; k < each.measured.cols(); ++k)
        for (Eigen::Index i = 0; i < outputs; ++i, ++row) {
          const double weight = each.sigma.size() > 0 ? 1.0 / each.sigma[i] : 1.0;
          at.r[row] = weight * (found.values(i, k) - each.measured(i, k));
          for (Eigen::Index j = 0; j < m; ++j) at.J(row, j) = weight * found.slopes(k * outputs + i, starts + j);
          for (std::size_t j = 0; j < each.unknown.size(); ++j)
            at.J(row, column + static_cast<Eigen::Index>(j)) = weight * found.slopes(k * outputs + i, each.unknown[j]);
        }
      column += static_cast<Eigen::Index>(each.unknown.size());
    }
    if (at.trouble.empty() && !(at.r.allFinite() && at.J.allFinite())) at.trouble = "what is predicted of a measurement, or its slope, is not finite";
    first_ = false;
    return at;
  }

 private:
  const FitTask& task_;
  Eigen::Index rows_ = 0;
  mutable bool first_ = true;  // at the guess, errors are the caller's
};

// Why a minimum does not describe the data, and what to do; empty where it does. With known σ, Σr² is known to √(2·degrees of freedom); without, residuals
// are compared with the spread of the data about their means.
template <class = void>  // compiled only where it is called
std::string doubt_of_fit(const FitTask& task, const ParameterFit& fit) {
  constexpr double most_deviations = 10.0, most_of_spread = 0.5;
  constexpr const char* advice = ": this minimum does not describe the data; begin at another guess, or look for what the model leaves out";
  const auto freedom = static_cast<double>(fit.degrees_of_freedom);
  if (task.experiments[0].sigma.size() > 0) {
    if (fit.chi_squared <= freedom + most_deviations * std::sqrt(2.0 * std::max(freedom, 1.0))) return {};
    return sentence({"residuals are ", {std::sqrt(fit.chi_squared / std::max(freedom, 1.0)), 3}, " times sigma on average", advice, ", or sigma is too small"});
  }
  double spread = 0.0;
  for (const FitExperiment& each : task.experiments)
    for (Eigen::Index i = 0; i < each.measured.rows(); ++i) {
      double mean = 0.0;
      for (Eigen::Index k = 0; k < each.measured.cols(); ++k) mean += each.measured(i, k) / static_cast<double>(each.measured.cols());
      for (Eigen::Index k = 0; k < each.measured.cols(); ++k) spread += (each.measured(i, k) - mean) * (each.measured(i, k) - mean);
    }
  if (!(spread > 0.0) || fit.degrees_of_freedom < 1 || fit.chi_squared <= most_of_spread * spread) return {};
  return sentence({"residuals leave ", {100.0 * fit.chi_squared / spread, 3}, " % of what the data spread about their means", advice});
}

// What data leave open, in words: combinations as simple as they can be made, of which each begins with a change by 1.
//
// @param size  of each parameter
template <class = void>  // compiled only where it is called
std::string open_directions(Eigen::MatrixXd& open, const Eigen::VectorXd& size, const std::vector<std::string>& names) {
  constexpr double nothing = 1e-5, clearly = 1.001;
  std::string text;
  for (Eigen::Index i = 0; i < open.rows(); ++i) open.row(i) /= size[i];
  std::vector<Eigen::Index> pivots;
  for (Eigen::Index c = 0; c < open.cols(); ++c) {
    Eigen::Index pivot = 0;
    for (Eigen::Index i = 1; i < open.rows(); ++i)
      if (std::abs(open(i, c)) > clearly * std::abs(open(pivot, c))) pivot = i;
    pivots.push_back(pivot);
    open.col(c) /= open(pivot, c);
    for (Eigen::Index other = 0; other < open.cols(); ++other)
      if (other != c) open.col(other) -= open(pivot, other) * open.col(c);
  }
  for (Eigen::Index c = 0; c < open.cols(); ++c) {
    const Eigen::Index pivot = pivots[static_cast<std::size_t>(c)];
    const double most = open.col(c).cwiseAbs().maxCoeff();
    for (Eigen::Index i = 0; i < open.rows(); ++i) open(i, c) = std::abs(open(i, c)) > nothing * most ? open(i, c) * size[i] / size[pivot] : 0.0;
    std::string others;
    for (Eigen::Index i = 0; i < open.rows(); ++i)
      if (i != pivot && open(i, c) != 0.0) others += sentence({" and ", names[static_cast<std::size_t>(i)], " by ", {open(i, c), 4}});
    text += sentence({c == 0 ? "" : ", nor with ", names[static_cast<std::size_t>(pivot)], others.empty() ? "" : " by 1", others});
  }
  return text;
}

// All that is unknown, in the order of x: start values are not bounded.
template <class = void>  // compiled only where it is called
std::vector<FitParameter> fit_unknowns(const FitTask& task) {
  std::vector<FitParameter> unknown = task.parameters;
  for (std::size_t e = 0; e < task.experiments.size(); ++e) {
    const FitExperiment& each = task.experiments[e];
    for (const Eigen::Index i : each.unknown) {
      const Eigen::Index n = each.start.size() / 2;
      unknown.push_back({sentence({i < n ? "q" : "qdot", i % n, " at the start of experiment ", e}), each.start[i]});
    }
  }
  return unknown;
}

// The norm of all that was measured, in units of σ.
template <class = void>  // compiled only where it is called
double norm_of_data(const FitTask& task) {
  double data = 0.0;
  for (const FitExperiment& each : task.experiments)
    for (Eigen::Index k = 0; k < each.measured.size(); ++k) {
      const double weighed = each.measured.data()[k] / (each.sigma.size() > 0 ? each.sigma[k % each.measured.rows()] : 1.0);
      data += weighed * weighed;
    }
  return std::sqrt(data);
}

// J of what is free, its columns of length 1; those that change nothing, of length 0.
struct FreeSlopes {
  std::vector<Eigen::Index> free{};  // entries of x
  Eigen::MatrixXd J{};
  Eigen::VectorXd size{}, unit{};  // of each entry of x; unit is that of a column of J

  // Rows of x for those of a matrix that has a row for each column of J.
  Eigen::MatrixXd rows_of_all(const Eigen::MatrixXd& of_free) const {
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(size.size(), of_free.cols());
    for (std::size_t k = 0; k < free.size(); ++k) all.row(free[k]) = unit[free[k]] * of_free.row(static_cast<Eigen::Index>(k));
    return all;
  }
};
template <class = void>  // compiled only where it is called
FreeSlopes free_slopes(const ResidualsAt& best, const std::vector<Eigen::Index>& held, double data) {
  constexpr double rounding = 1e-14;
  const Eigen::Index count = best.x.size();
  FreeSlopes slopes;
  for (Eigen::Index j = 0; j < count; ++j)
    if (std::find(held.begin(), held.end(), j) == held.end()) slopes.free.push_back(j);
  slopes.J = Eigen::MatrixXd::Zero(best.J.rows(), static_cast<Eigen::Index>(slopes.free.size()));
  slopes.size = slopes.unit = Eigen::VectorXd::Ones(count);
  for (Eigen::Index j = 0; j < count; ++j)
    if (best.x[j] != 0.0) slopes.size[j] = std::abs(best.x[j]);
  for (std::size_t k = 0; k < slopes.free.size(); ++k) {
    const Eigen::Index j = slopes.free[k];
    const double length = best.J.col(j).norm();
    const bool matters = length * slopes.size[j] > rounding * data;
    slopes.unit[j] = matters ? 1.0 / length : slopes.size[j];
    if (matters) slopes.J.col(static_cast<Eigen::Index>(k)) = best.J.col(j) / length;
  }
  return slopes;
}

// χ², σ and standard deviations, where the data determine the columns of `seen` and leave fit.open open; residuals of each experiment.
template <class = void>  // compiled only where it is called
void write_statistics(ParameterFit& fit, const FitTask& task, const Eigen::VectorXd& r, const Eigen::MatrixXd& seen) {
  constexpr double anywhere = std::numeric_limits<double>::infinity();
  fit.chi_squared = r.squaredNorm();
  fit.degrees_of_freedom = r.size() - seen.cols();
  const bool known = task.experiments[0].sigma.size() > 0;
  if (!known) fit.sigma = fit.degrees_of_freedom > 0 ? std::sqrt(fit.chi_squared / static_cast<double>(fit.degrees_of_freedom)) : anywhere;
  fit.covariance = seen * seen.transpose();
  for (double& entry : fit.covariance.reshaped())
    if (entry != 0.0) entry *= fit.sigma * fit.sigma;  // which may be infinite
  for (Eigen::Index i = 0; i < fit.p.size(); ++i)
    fit.standard_deviation[i] = fit.open.cols() > 0 && fit.open.row(i).cwiseAbs().maxCoeff() > 0.0 ? anywhere : std::sqrt(fit.covariance(i, i));
  Eigen::Index row = 0;
  for (const FitExperiment& each : task.experiments) {
    fit.residuals.push_back(Eigen::Map<const Eigen::MatrixXd>(r.data() + row, each.measured.rows(), each.measured.cols()));
    row += each.measured.size();
  }
}

// @param ahead  the part of Σr² that a step of Newton's method would take away
// @param open   what the data leave open, in words
template <class = void>  // compiled only where it is called
void write_outcome(ParameterFit& fit, const FitTask& task, const LeastSquaresEnd& end, double ahead, const std::string& open) {
  constexpr double close = 1e-6;
  const bool at_minimum = ahead <= close;
  const auto says = [&](FitOutcome outcome, std::initializer_list<Phrase> why) {
    fit.outcome = outcome;
    fit.message = sentence({name(outcome), " after ", fit.runs, " runs, the sum of squares is ", {fit.chi_squared, 6}, " for ", fit.degrees_of_freedom,
                            " degrees of freedom: ", sentence(why)});
  };
  if (!at_minimum && end.exhausted)
    return says(FitOutcome::run_limit, {"a further step would still take ", {100 * ahead, 3}, " % of the sum away; allow more runs, or begin nearer"});
  if (!at_minimum && !end.trouble.empty())
    return says(FitOutcome::motion_failed, {"the way down leads where motions fail: ", end.trouble, "; give bounds that keep parameters away from there"});
  if (!open.empty())
    return says(FitOutcome::undetermined, {"nothing that was measured changes with ", open, "; hold one of each, or measure what depends on it"});
  if (!at_minimum)
    return says(FitOutcome::no_progress, {"no step takes anything away, though ", {100 * ahead, 3}, " % should be possible; tighten rtol, or begin elsewhere"});
  std::string bounded;
  for (const std::string& each : fit.at_bound) bounded += (bounded.empty() ? "" : ", ") + each;
  const std::string doubt = doubt_of_fit(task, fit);
  if (!bounded.empty())
    return says(FitOutcome::at_bound,
                {"the data would take ", bounded, " beyond the bound; what was found holds for the bound", doubt.empty() ? "" : "; ", doubt});
  says(FitOutcome::converged, {doubt.empty() ? "nothing to do." : doubt});
}

template <class = void>  // compiled only where it is called
ParameterFit best_parameters(const FitTask& task) {
  require_fit(task);
  const std::vector<FitParameter> unknown = fit_unknowns(task);
  const auto count = static_cast<Eigen::Index>(unknown.size());
  ParameterFit fit;
  Eigen::VectorXd guess(count), lower(count), upper(count);
  for (const FitParameter& each : unknown) {
    const auto j = static_cast<Eigen::Index>(fit.names.size());
    fit.names.push_back(each.name);
    guess[j] = each.guess;
    lower[j] = each.lower;
    upper[j] = each.upper;
  }
  const double data = norm_of_data(task);
  const FitResiduals residuals(task);
  const LeastSquaresSearch search{[&](const Eigen::VectorXd& x) { return residuals(x); }, lower, upper, task.options.most_runs, task.options.tolerance,
                                  10 * task.rtol * data};
  const LeastSquaresEnd end = BoundedLeastSquares(search).end(guess);
  const ResidualsAt& best = end.best;
  fit.p = best.x;
  fit.runs = end.evaluations;
  fit.covariance = Eigen::MatrixXd::Zero(count, count);
  fit.standard_deviation = Eigen::VectorXd::Constant(count, std::numeric_limits<double>::infinity());
  if (!best.trouble.empty()) {
    fit.message = sentence({"no motion at the guess: ", best.trouble, "; begin at parameters whose motion lasts as long as the measurements"});
    return fit;
  }
  for (const Eigen::Index j : end.held)
    if (lower[j] < upper[j]) fit.at_bound.push_back(fit.names[static_cast<std::size_t>(j)]);

  const double cutoff = std::max(1e-9, 100 * task.rtol);
  const FreeSlopes slopes = free_slopes(best, end.held, data);
  ShortestStep step{Eigen::VectorXd(0), Eigen::MatrixXd(0, 0), Eigen::MatrixXd(0, 0)};
  if (!slopes.free.empty()) step = shortest_step(slopes.J, -best.r, cutoff);
  fit.open = slopes.rows_of_all(step.open);
  const std::string open = open_directions(fit.open, slopes.size, fit.names);
  write_statistics(fit, task, best.r, slopes.rows_of_all(step.determined));

  const bool is_minimum = slopes.free.empty() || fit.chi_squared == 0.0 || best.r.norm() <= search.negligible;
  write_outcome(fit, task, end, is_minimum ? 0.0 : (slopes.J * step.x).squaredNorm() / fit.chi_squared, open);
  return fit;
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template ParameterFit best_parameters<void>(const FitTask&);
#endif

}  // namespace detail
}  // namespace qdot
