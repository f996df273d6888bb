// SPDX-License-Identifier: MIT
#include "program/accurate_run.hpp"

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "qdot/integrate/simulate_to_accuracy.hpp"
#include "qdot/report/number.hpp"

namespace qdot::program {

namespace {

/// What the comparison of runs needs of a model.
struct ModelEquations {
  static constexpr int size_at_compile_time = Dynamic;
  const Model& model;

  Eigen::Index size() const { return model.size(); }
  void derivative(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot) const {
    model.derivative(t, y, ydot);
  }
  void jacobian(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::MatrixXd> J) const {
    model.jacobian(t, y, J);
  }
  std::string component_name(Eigen::Index i) const { return model.component_name(i); }
};

/// The samples and the end as they are compared.
detail::Motion motion_of(const Result& result, double t_begin) {
  const auto count = static_cast<Eigen::Index>(result.samples.size());
  detail::Motion motion{t_begin, {}, Eigen::MatrixXd(result.end.y.size(), count + 1), result.end.y.cwiseAbs(), result.events};
  for (Eigen::Index k = 0; k <= count; ++k) {
    const Sample& sample = k < count ? result.samples[static_cast<std::size_t>(k)] : result.end;
    motion.t.push_back(sample.t);
    motion.y.col(k) = sample.y;
    motion.sizes = motion.sizes.cwiseMax(sample.y.cwiseAbs());
  }
  if (result.sizes.size() == motion.sizes.size()) motion.sizes = motion.sizes.cwiseMax(result.sizes);
  return motion;
}

}  // namespace

Result simulated_to_accuracy(const std::shared_ptr<const Model>& model, Request& request, double accuracy,
                             const Watcher& watcher) {
  const ModelEquations equations{*model};
  const auto launch = [&](double rtol, const Eigen::VectorXd& atol) {
    Request tried = request;
    tried.rtol = tried.atol = rtol;
    tried.atol_each = atol;
    detail::Launched<Result> launched;
    launched.run = simulated(model, tried, watcher);
    launched.motion = motion_of(launched.run, request.start.t);
    return launched;
  };
  struct Accurate : AccuracyReport {
    Result run;
  };
  auto found = detail::accurate<Accurate>(equations, model->dof(), accuracy,
                                          detail::expected_sizes(equations, model->dof(), request.start.t, model->packed(request.start),
                                                                 request.t_end - request.start.t),
                                          launch);
  request.rtol = request.atol = found.rtol;
  request.atol_each = found.atol;
  Result result = std::move(found.run);
  result.accuracy = std::move(static_cast<AccuracyReport&>(found));
  return result;
}

std::string accuracy_text(const AccuracyReport& report) {
  if (!std::isfinite(report.error_estimate)) return "  no error could be estimated";
  std::string text = "  estimated error of the motion " + report::rounded_text(report.error_estimate, 2) + " of " +
                     report::rounded_text(report.accuracy, 2) + " asked for, from " + std::to_string(report.trials.size()) + " runs in " +
                     report::rounded_text(1e3 * report.seconds, 3) + " ms\n  more digits would cost";
  const char* separator = " ";
  for (const AccuracyForecast& forecast : report.forecast) {
    if (!forecast.reachable) return text + separator + "(" + report::rounded_text(forecast.accuracy, 2) + ": more than double has)";
    text += separator + report::rounded_text(forecast.factor, 2) + " times as much (" + report::rounded_text(forecast.accuracy, 2) + ": " +
            report::rounded_text(1e3 * forecast.seconds, 3) + " ms)";
    separator = ", ";
  }
  return text;
}

}  // namespace qdot::program
