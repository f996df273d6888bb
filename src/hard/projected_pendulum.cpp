// SPDX-License-Identifier: MIT
//
// SUNDIALS 7.5, example cvPendulum_dns: a pendulum in Cartesian coordinates with g chosen for a period of exactly 2, fifteen
// periods by CVODE's BDF with and without its projection, rtol = atol. Its output file is the table below.
#include <cstdio>

#include "hard/motion.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/integrate/rattle.hpp"
#include "qdot/integrate/taylor.hpp"

namespace qdot::hard {
namespace {

constexpr double g = 13.750371636040745654980191559621114395801712;

struct Bob {
  auto T(const auto& v) const { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }
  auto V(const auto& q) const { return g * q[1]; }
};

struct Published {
  double tolerance;
  bool projected;
  double error_y, error_ydot;
};
constexpr Published table[] = {{1e-5, true, 0.00225, 0.0801}, {1e-5, false, 0.898, 2.1},   {1e-6, true, 0.000464, 0.0199},
                               {1e-6, false, 0.0574, 1.0},    {1e-7, true, 7.79e-5, 0.00351}, {1e-7, false, 0.0345, 1.11},
                               {1e-8, true, 1.37e-5, 0.000599}, {1e-8, false, 0.00852, 0.195}, {1e-9, true, 1.79e-6, 7.79e-5},
                               {1e-9, false, 0.0017, 0.039}};

/// The same equations, to a method that is not told of the constraint.
template <class Form>
struct Unprojected {
  static constexpr int size_at_compile_time = Form::size_at_compile_time;
  Form form;

  Eigen::Index dof() const { return form.dof(); }
  Eigen::Index size() const { return form.size(); }
  std::string component_name(Eigen::Index i) const { return form.component_name(i); }
  void derivative(double t, const State_& y, Eigen::Ref<Eigen::VectorXd> ydot) const { form.derivative(t, y, ydot); }
  void jacobian(double t, const State_& y, Eigen::Ref<Eigen::MatrixXd> J) const { form.jacobian(t, y, J); }
};

const auto pendulum = scene(mechanical_system<2>(Bob{}).with_names({"x", "y"}),
                            holonomic("rod", [](const auto& q) { return q[0] * q[0] + q[1] * q[1] - 1.0; }));

Motion drifting() {
  const auto form = first_order_form(pendulum);
  return {.system = Unprojected<std::remove_cv_t<decltype(form)>>{form}, .energy = motion(pendulum).energy};
}

/// The error of y or of its velocity beside what SUNDIALS published.
Row beside(const Published& known, bool velocity) {
  const double error = velocity ? known.error_ydot : known.error_y;
  char best[64];
  std::snprintf(best, sizeof best, "CVODE's own projection: %.2g", error);
  const Problem problem{.name = std::string("CVODE pendulum, ") + (velocity ? "y_d" : "y") + (known.projected ? "" : ", unprojected"),
                        .t_end = 30.0,
                        .start = numbers({1, 0, 0, 0}),
                        .exact = numbers({0.0}),
                        .reference_digits = -std::log10(error),
                        .best_published = known.projected ? best : "",
                        .scale = Eigen::VectorXd::Ones(1),
                        .seen = [velocity](const State_& y) { return numbers({y[velocity ? 3 : 1]}); }};
  return solved(problem, known.projected ? motion(pendulum) : drifting(), By::bdf, {.rtol = known.tolerance, .atol = known.tolerance});
}

std::vector<Row> rows() {
  std::vector<Row> rows;
  for (const Published& known : table)
    for (const bool velocity : {false, true}) rows.push_back(beside(known, velocity));
  // And what the problem allows.
  const Problem closed{.name = "CVODE pendulum, closed orbit",
                       .t_end = 30.0,
                       .start = numbers({1, 0, 0, 0}),
                       .exact = numbers({1, 0, 0, 0}),
                       .reference_digits = 24,
                       .gain = 18,
                       .best_published = "CVODE 1e-9: 4.8",
                       .scale = numbers({1, 1, std::sqrt(2 * g), std::sqrt(2 * g)})};
  const Motion moving = motion(pendulum);
  rows.push_back(solved(closed, moving, By::dop853, {.rtol = 2.5e-15, .atol = 2.5e-15}));
  rows.push_back(solved(closed, moving, pendulum, Taylor{}, "taylor, 2.5e-15", {.rtol = 2.5e-15, .atol = 2.5e-15}));
  rows.push_back(solved(closed, moving, pendulum, Rattle{.step = 0.005, .order = 8}, "rattle8, h = 0.005", {}));
  return rows;
}

}  // namespace

Case projected_pendulum() {
  return {"projected_pendulum", "CVODE's pendulum, with and without projection",
          "SUNDIALS' own table of what projection is worth. Good digits of these rows are those that SUNDIALS reached at the same "
          "tolerances, with a projection and equations written by hand for this problem; here both come from T, V and φ.",
          rows};
}

}  // namespace qdot::hard
