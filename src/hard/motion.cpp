// SPDX-License-Identifier: MIT
#include "hard/motion.hpp"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <utility>

#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/runge_kutta.hpp"

namespace qdot::hard {

double digits_reached(const Problem& problem, const State_& y) {
  const Eigen::VectorXd found = problem.seen ? problem.seen(y) : Eigen::VectorXd(y);
  const Eigen::Index half = found.size() / 2;
  double worst = 0.0;
  for (Eigen::Index i = 0; i < found.size(); ++i) {
    const bool second = i >= half;
    const double scale = problem.scale.size() > 0 ? problem.scale[i]
                                                  : problem.exact.segment(second ? half : 0, second ? found.size() - half : half)
                                                        .cwiseAbs()
                                                        .maxCoeff();
    worst = std::max(worst, std::abs(found[i] - problem.exact[i]) / scale);
  }
  if (!std::isfinite(worst)) return 0.0;
  return std::clamp(-std::log10(std::max(worst, 1e-17)), 0.0, 17.0);
}

double digits_good(const Problem& problem) {
  return std::min(problem.reference_digits, -std::log10(std::numeric_limits<double>::epsilon() * std::max(1.0, problem.gain)));
}

EnergyWatch::EnergyWatch(const Motion& motion)
    : motion_(motion),
      meter_([&motion](double t, const State_& y) { return motion.energy(t, y); },
             [&motion](double t, const State_& y) { return motion.energy_rate(t, y); }) {}

void EnergyWatch::operator()(const StepView& step) {
  if (motion_.energy_rate) return meter_(step);
  if (!begun_) {
    first_ = motion_.energy(step.t_previous(), step.y_at(step.t_previous()));
    begun_ = true;
  }
  largest_ = std::max(largest_, std::abs(motion_.energy(step.t(), step.y()) - first_));
}

double EnergyWatch::largest() const { return motion_.energy_rate ? meter_.balance().residual : largest_; }

std::string text_of_tolerance(double tolerance) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", tolerance);
  return text;
}

namespace {

template <class Method>
Row solved_by(const Problem& problem, const Motion& motion, const Method& method, Options options) {
  options.keep_trajectory = false;
  options.max_wall_seconds = std::min(options.max_wall_seconds, 60.0);
  EnergyWatch watch(motion);
  const auto run = simulate(motion.system, FirstOrderState{0.0, problem.start}, problem.t_end, method, options, watch);
  return row_of(problem, motion, run, std::string(Method::name) + ", " + text_of_tolerance(options.rtol), watch.largest());
}

}  // namespace

Row solved(const Problem& problem, const Motion& motion, By method, const Options& options) {
  switch (method) {
    case By::dopri5: return solved_by(problem, motion, Dopri5{}, options);
    case By::adams: return solved_by(problem, motion, CvodeAdams{}, options);
    case By::bdf: return solved_by(problem, motion, CvodeBdf{}, options);
    default: return solved_by(problem, motion, Dop853{}, options);
  }
}

Row limited(Row row, std::string why) {
  row.limit = std::move(why);
  return row;
}

Eigen::VectorXd joined(const State_& q, const State_& v) {
  Eigen::VectorXd y(q.size() + v.size());
  y << q, v;
  return y;
}

Eigen::VectorXd numbers(std::initializer_list<double> values) {
  return Eigen::Map<const Eigen::VectorXd>(values.begin(), static_cast<Eigen::Index>(values.size()));
}

}  // namespace qdot::hard
