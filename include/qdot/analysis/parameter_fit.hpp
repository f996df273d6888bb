#pragma once
// SPDX-License-Identifier: MIT
//
// Parameters from data
// ====================
//
//     const auto fit = parameter_fit([](const auto& p) { return Pendulum{p[0], p[1]}; }, {{"l", 1.0, 0.1, 3.0}, {"c", 0.0}}, experiments, Dop853{});
//     fit.p, fit.standard_deviation, fit.covariance, fit.outcome, fit.message
//
//     Σ r² = min ,     r = (y_i(t_k; p) − measured)/σ_i ,     lower ≤ p ≤ upper ,      covariance of p = (JᵀJ)⁻¹ to first order.
//
// The start may be sought as well. J = ∂r/∂p is the motion's own sensitivity (sensitivity.hpp), through events and on
// constraints, and no difference of two runs; fit/least_squares.hpp finds the minimum. Σ r² is about the number of
// residuals less that of parameters, if the model is right and σ is known. A σ that is not given is estimated from
// this. Data may leave parameters open: where J v = 0, nothing that was measured changes along v, such as (m₁, m₂) of a
// free motion. Combinations of J's columns below the accuracy of the runs are named, and their parameters have the
// standard deviation ∞.

#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "qdot/analysis/fit/best_parameters.hpp"
#include "qdot/analysis/fit/prediction.hpp"
#include "qdot/analysis/sensitivity.hpp"
#include "qdot/integrate/options.hpp"

namespace qdot {

/// A motion that was measured.
template <int n>
struct Experiment {
  std::optional<State<n>> start{};      ///< where it began, or where to begin the search for that; none where the family's own problem() says
  std::vector<double> times{};          ///< of the measurements, in the direction of the run, from the start on
  Eigen::MatrixXd measured{};           ///< outputs × times
  Eigen::VectorXd sigma{};              ///< standard deviation of each output; empty in all experiments: the same for all, and unknown
  std::vector<Eigen::Index> unknown{};  ///< entries of [q; q̇] of the start that are sought as well
};

/// What is measured unless something else is said: the coordinates.
struct AllCoordinates {
  /// q itself.
  template <class X>
  X operator()(const X& q) const {
    return q;
  }
};

/// The parameters of a family of motions that fit measurements best.
///
/// A run with its sensitivities for each experiment and each step, some ten of them from a fair guess.
///
/// @param family       p ↦ an object with members T and V, which takes duals as sensitivities() has it: ∂q̈/∂p is exact; or, for numbers,
///                     p ↦ a system or scene, or p ↦ problem(scene, start, events(…)), whose start holds where an experiment has none
/// @param parameters   {{"name", guess, lower, upper}, …}, bounds if there are any
/// @param experiments  a vector of them, to all of which the parameters are common
/// @param method       Dop853{} or Dopri5{}
/// @param options      of the runs; stop_times of all experiments
/// @param outputs      what is measured: h(q), h(q, q̇) or h(q, q̇, p), a number or a vector, for duals; the coordinates unless given
/// @return             a named outcome with what was found so far, whatever it is
/// @throws             InvalidValue, DimensionError for a question that cannot be; whatever the family throws at the guess
template <class Family, int m, int n, class Method, class Outputs = AllCoordinates>
ParameterFit parameter_fit(const Family& family, const FitParameter (&parameters)[m], const std::vector<Experiment<n>>& experiments, const Method& method,
                           const Options& options = {}, const Outputs& outputs = {}, const FitOptions& search = {}) {
  using P = Vector<double, m>;
  using Member = std::remove_cvref_t<std::invoke_result_t<const Family&, const P&>>;
  constexpr bool is_problem = requires(Member member) { member.system, member.start, member.events; };
  constexpr bool is_system = requires { Member::dof_at_compile_time; };

  detail::FitTask task{{parameters, parameters + m}, {}, search, options.rtol};
  for (const Experiment<n>& each : experiments) {
    detail::FitExperiment erased{{}, {}, each.times, each.measured, each.sigma, each.unknown};
    if (each.start) {
      erased.begins = each.start->t;
      erased.start.resize(each.start->q.size() + each.start->qdot.size());
      erased.start << each.start->q, each.start->qdot;
    } else if (!is_problem || !each.unknown.empty()) {
      throw InvalidValue("parameter_fit: an experiment must have a start, unless the family has problems with starts of their own and none of it is "
                         "unknown; give it a start");
    }
    erased.predict = [&, t = erased.begins](const Eigen::VectorXd& p, const Eigen::VectorXd& y0, bool by_start) {
      Options run = options;
      run.output_times = each.times;
      run.keep_trajectory = false;
      const Eigen::Index k = y0.size() / 2;
      const auto start = [&] { return State<n>{t, y0.head(k), y0.tail(k)}; };
      const WithRespectTo wanted{.start = by_start};
      const double t_end = each.times.back();
      const auto asked = [&] {
        if constexpr (is_problem) {
          const auto from_start = [&](const P& at) {
            auto member = family(at);
            if (each.start) member.start = start();
            return member;
          };
          return sensitivities(from_start, P(p), t_end, method, run, wanted);
        } else if constexpr (is_system) {
          return sensitivities([&](const P& at) { return problem(family(at), start()); }, P(p), t_end, method, run, wanted);
        } else {
          return sensitivities(family, P(p), start(), t_end, method, run, {}, wanted);
        }
      };
      return detail::predicted<n>(outputs, asked(), each.times.size(), p);
    };
    task.experiments.push_back(std::move(erased));
  }
  return detail::best_parameters(task);
}

/// A fit of parameters to one experiment.
template <class Family, int m, int n, class Method, class Outputs = AllCoordinates>
ParameterFit parameter_fit(const Family& family, const FitParameter (&parameters)[m], const Experiment<n>& experiment, const Method& method,
                           const Options& options = {}, const Outputs& outputs = {}, const FitOptions& search = {}) {
  return parameter_fit(family, parameters, std::vector<Experiment<n>>{experiment}, method, options, outputs, search);
}

}  // namespace qdot
