#pragma once
// SPDX-License-Identifier: MIT
//
// Forms of runs, evaluated until their accelerations come by lines (mechanics/derive/kept_rates.ipp).

#include <string>

#include <Eigen/Core>

#include "qdot/ad/native/line_evaluator.hpp"

namespace qdot {

inline constexpr int evaluations_until_lines = 3001;

template <class System>
auto form_of_run(const System& system) {
  auto form = first_order_form(system);
  form.renew();
  return form;
}
template <class Form>
void evaluate_until_lines(const Form& form, const Eigen::VectorXd& y) {
  Eigen::VectorXd ydot(y.size());
  for (int i = 0; i < evaluations_until_lines; ++i) form.derivative(0.0, y, ydot);
}
inline bool is_by_lines(const std::string& way) { return way.find("recorded formulas") != std::string::npos || !formula::native_lines_are_possible(); }

}  // namespace qdot
