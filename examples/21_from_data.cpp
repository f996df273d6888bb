// SPDX-License-Identifier: MIT
//
// Parameters from measurements of a motion: the length and the friction of a pendulum that was filmed twice, and the restitution of a ball by its
// bounces. And masses that no film of a free swing can tell.

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <qdot/analysis/parameter_fit.hpp>
#include <qdot/effects/contact.hpp>
#include <qdot/effects/dissipation.hpp>
#include <qdot/qdot.hpp>

using namespace qdot;

void print(const ParameterFit& fit) {
  for (std::size_t i = 0; i < fit.names.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (std::isfinite(fit.standard_deviation[k])) std::printf("  %-35s %7.4f +- %.4f\n", fit.names[i].c_str(), fit.p[k], fit.standard_deviation[k]);
    else std::printf("  %-35s open\n", fit.names[i].c_str());
  }
  std::printf("  %s: %s\n\n", std::string(name(fit.outcome)).c_str(), fit.message.substr(fit.message.find(": ") + 2).c_str());
}

// A measurement every `step` seconds, with an error of about sigma that is the same in each run of this program.
template <class Motion>
Experiment<1> filmed(const Motion& motion, const State<1>& start, double step, int count, double sigma) {
  Experiment<1> film{.start = start, .times = {}, .measured = Eigen::MatrixXd(1, count)};
  const auto run = simulate(motion, start, step * count, Dop853{}, {.rtol = 1e-10});
  for (int k = 0; k < count; ++k) {
    const double t = step * (k + 1), x = 1e4 * std::sin(78.233 * (k + 1));
    film.times.push_back(t);
    film.measured(0, k) = run.trajectory.at(t).q[0] + std::sqrt(12.0) * sigma * (x - std::floor(x) - 0.5);
  }
  return film;
}

int main() {
  // p = (length, friction in the joint) of a bob of 1 kg
  const auto pendulum = [](const auto& p) {
    const auto swing = mechanical_system<1>([l = p[0]](const auto& v) { return 0.5 * l * l * v[0] * v[0]; },
                                            [l = p[0]](const auto& q) {
                                              using std::cos;
                                              return -9.81 * l * cos(q[0]);
                                            });
    return scene(swing, viscous_damping(Vector<double, 1>(p[1])));
  };
  const Eigen::Vector2d truth(0.83, 0.11);
  std::vector<Experiment<1>> films{filmed(pendulum(truth), {0.0, {1.2}, {0.0}}, 0.04, 100, 0.01),
                                   filmed(pendulum(truth), {0.0, {0.3}, {2.0}}, 0.04, 100, 0.01)};
  films[1].start = State<1>{0.0, {0.0}, {1.0}};  // the beginning of this one was not filmed
  films[1].unknown = {0, 1};
  std::printf("a pendulum of 0.83 m with friction 0.11, filmed twice\n");
  print(parameter_fit(pendulum, {{"length", 1.0, 0.1, 10.0}, {"friction", 0.0, 0.0}}, films, Dop853{}));

  const auto ball = [](const auto& p) {
    const auto fall = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 9.81 * q[0]; });
    return scene(fall, contact("floor", [](const auto& q) { return q[0]; }, restitution(p[0])));
  };
  const auto bounces = filmed(ball(Vector<double, 1>(0.72)), {0.0, {1.0}, {0.0}}, 0.02, 70, 0.004);
  std::printf("a ball with restitution 0.72\n");
  print(parameter_fit(ball, {{"restitution", 0.6, 0.0, 1.0}}, bounces, Dop853{}));

  std::printf("the same pendulum with its mass\n");
  const auto with_mass = [](const auto& p) {
    const auto swing = mechanical_system<1>([m = p[0], l = p[1]](const auto& v) { return 0.5 * m * l * l * v[0] * v[0]; },
                                            [m = p[0], l = p[1]](const auto& q) {
                                              using std::cos;
                                              return -9.81 * m * l * cos(q[0]);
                                            });
    return scene(swing, viscous_damping(Vector<double, 1>(p[2])));
  };
  print(parameter_fit(with_mass, {{"mass", 1.2}, {"length", 1.0, 0.1, 10.0}, {"friction", 0.1, 0.0}}, films[0], Dop853{}));
}
