#pragma once
// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench steppers`: for a problem, a method and each error asked for, the cheapest setting that reaches the error.

#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "bench/bench.hpp"
#include "bench/motion_problems.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot::bench {

/// The methods' times for one problem; the first method is the baseline of all.
class MotionRows {
 public:
  MotionRows(std::vector<Row>& rows, const MotionProblem& problem)
      : rows_(rows), problem_(problem), baseline_(problem.errors.size(), 0.0) {}

  /// A method that chooses its steps: its cheapest tolerance.
  template <class System, class Method>
  void adaptive(const System& system, const Method& method) {
    add(std::string(Method::name), system, decades(1e-3, 2.4e-15, 4),
        [&](double tol, const auto& form) { return method.stepper(form, {.rtol = tol, .atol = tol}); });
  }

  /// A method with steps of one length: its cheapest one. `make(step)` returns the method.
  template <class System, class Make>
  void fixed(const std::string& name, const System& system, const Make& make) {
    add(name, system, decades(problem_.t_end / 10, problem_.t_end / 2e5, 4),
        [&](double step, const auto& form) { return make(step).stepper(form, Options{}); });
  }

 private:
  template <class System, class MakeStepper>
  void add(const std::string& name, const System& system, const std::vector<double>& settings, const MakeStepper& make) {
    const auto form = first_order_form(system);
    const Eigen::VectorXd y0 = Eigen::Map<const Eigen::VectorXd>(problem_.start.data(), 2 * problem_.n);
    const double t_end = problem_.t_end;
    std::size_t next = 0;
    for (const double setting : settings) {
      auto stepper = make(setting, form);
      const auto go = [&] {
        stepper.reset(0.0, y0);
        while (stepper.t() != t_end && stepper.step(t_end)) {
        }
      };
      go();
      const double error = stepper.t() == t_end ? problem_.error(stepper.y()) : std::numeric_limits<double>::infinity();
      const long evaluations = stepper.statistics().evaluations;
      for (; next < problem_.errors.size() && error <= problem_.errors[next]; ++next) {
        const double microseconds = least_microseconds(go);
        if (baseline_name_.empty()) baseline_name_ = name;
        if (name == baseline_name_) baseline_[next] = microseconds;
        char text[200];
        std::snprintf(text, sizeof text, "%s, error <= %.0e, %s: setting %.1e, error %.1e, %ld evaluations", problem_.name.c_str(),
                      problem_.errors[next], name.c_str(), setting, error, evaluations);
        rows_.push_back({text, microseconds, baseline_[next], baseline_name_, "us"});
      }
      if (next == problem_.errors.size() || evaluations > 1'000'000) break;
    }
    for (; next < problem_.errors.size(); ++next) {
      char text[200];
      std::snprintf(text, sizeof text, "%s, error <= %.0e, %s: not reached", problem_.name.c_str(), problem_.errors[next], name.c_str());
      rows_.push_back({text, 0.0, 0.0, baseline_name_, "us"});
    }
  }

  std::vector<Row>& rows_;
  const MotionProblem& problem_;
  std::string baseline_name_;
  std::vector<double> baseline_;
};

/// Rows of chains of 1 to 4 and of 6 to 16 links: in files of their own, since each length is compiled for itself.
void short_chain_rows(std::vector<Row>& rows);
void long_chain_rows(std::vector<Row>& rows);

}  // namespace qdot::bench
