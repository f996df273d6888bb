// SPDX-License-Identifier: MIT
//
// Thousands of coordinates: a string of ten thousand masses along which a pulse travels, and a chain of three hundred rods that is let go.
//
// T and V are loops over neighbours, as one writes them, with the number of coordinates known at run time. A run traces them when it begins and
// finds which coordinates occur together. The cost of a step is then proportional to the number of coordinates.
#include <cmath>
#include <cstdio>

#include <qdot/effects/constraints.hpp>
#include <qdot/effects/scene_form.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/simulate.hpp>
#include <qdot/integrate/symplectic.hpp>

struct String {  // of unit masses and springs, the waves of which have speed 1
  auto T(const auto& qdot) const { return 0.5 * qdot.squaredNorm(); }
  auto V(const auto& q) const {
    auto sum = 0.5 * (q[0] * q[0] + q[q.size() - 1] * q[q.size() - 1]);
    for (Eigen::Index i = 1; i < q.size(); ++i) sum += 0.5 * (q[i] - q[i - 1]) * (q[i] - q[i - 1]);
    return sum;
  }
};

struct Beads {  // of unit mass in a vertical plane, x and y in turn
  auto T(const auto& qdot) const { return 0.5 * qdot.squaredNorm(); }
  auto V(const auto& q) const {
    auto sum = 9.81 * q[1];
    for (Eigen::Index i = 3; i < q.size(); i += 2) sum += 9.81 * q[i];
    return sum;
  }
};

int main() {
  constexpr Eigen::Index n = 10'000;
  const auto string = qdot::mechanical_system(n, String{});
  qdot::State<qdot::Dynamic> pulse{0.0, Eigen::VectorXd(n), Eigen::VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const double x = (static_cast<double>(i) - 300.0) / 60.0;
    pulse.q[i] = std::exp(-x * x);
    pulse.qdot[i] = 2.0 * x / 60.0 * pulse.q[i];  // to the right
  }
  const auto run = simulate(string, pulse, 50.0, qdot::Splitting{.step = 0.5}, {.keep_trajectory = false});
  if (!run.completed()) return std::fprintf(stderr, "%s\n", run.message.c_str()), 1;
  Eigen::Index top = 0;
  run.state().q.maxCoeff(&top);
  std::printf("string of %ld masses: after t = 50 the pulse has come from mass 300 to mass %ld, its height is %.3f\n",
              static_cast<long>(n), static_cast<long>(top),
              run.state().q[top]);
  std::printf("energy %.9f, at the start %.9f\n", energy(string, run.state()), energy(string, pulse));

  constexpr Eigen::Index rods = 300;
  const auto chain = scene(qdot::mechanical_system(2 * rods, Beads{}), qdot::holonomic("rods", [](const auto& q) {
                             using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
                             qdot::Vector<S, qdot::Dynamic> rows(q.size() / 2);
                             for (Eigen::Index k = 0; k < rows.size(); ++k) {
                               const S x = k == 0 ? S(q[0]) : q[2 * k] - q[2 * k - 2], y = k == 0 ? S(q[1]) : q[2 * k + 1] - q[2 * k - 1];
                               rows[k] = 0.5 * (x * x + y * y - 1.0);
                             }
                             return rows;
                           }));
  qdot::State<qdot::Dynamic> level{0.0, Eigen::VectorXd::Zero(2 * rods), Eigen::VectorXd::Zero(2 * rods)};
  for (Eigen::Index k = 0; k < rods; ++k) level.q[2 * k] = static_cast<double>(k + 1);
  const auto fall = simulate(chain, level, 1.0, qdot::Dop853{}, {.rtol = 1e-8, .atol = 1e-8, .keep_trajectory = false});
  if (!fall.completed()) return std::fprintf(stderr, "%s\n", fall.message.c_str()), 1;
  const auto end = fall.state();
  std::printf("chain of %ld rods, level and let go: after t = 1 its tip is %.4f lower and has speed %.4f\n", static_cast<long>(rods), -end.q[2 * rods - 1],
              end.qdot.tail(2).norm());
  const double worst = constraint_residual(chain, end.q, end.t).cwiseAbs().maxCoeff();
  std::printf("rods are as long as they were to 1e-12: %s\n", worst < 1e-12 ? "yes" : "no");
}
