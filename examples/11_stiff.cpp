// SPDX-License-Identifier: MIT
//
// A stiff scene: a bob on a hard spring whose vibration is damped away at once. What is left moves slowly, but an explicit method must take steps
// as short as the vibration, or it becomes unstable. An implicit one need not, and one that chooses for itself finds out on the way.

#include <cmath>
#include <cstdio>
#include <string>

#include <qdot/effects/dissipation.hpp>
#include <qdot/effects/scene_form.hpp>
#include <qdot/integrate/cvode.hpp>
#include <qdot/integrate/cvode_automatic.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/simulate.hpp>

using namespace qdot;

int main() {
  const double m = 1.0, l = 1.0, g = 9.81, k = 1e7;
  const auto pendulum = mechanical_system<2>(
      [=](const auto& q, const auto& qdot) { return 0.5 * m * (qdot[0] * qdot[0] + q[0] * q[0] * qdot[1] * qdot[1]); },
      [=](const auto& q) {
        using std::cos;
        return 0.5 * k * (q[0] - l) * (q[0] - l) - m * g * q[0] * cos(q[1]);
      }).with_names({"r", "theta"});
  const auto damped = scene(pendulum, viscous_damping(vector(2.0 * std::sqrt(k * m), 0.0)));  // critically, along the spring
  const State<2> start{0.0, {l, 1.5}, {0.0, 0.0}};
  std::printf("the spring's own time %.0e s, the pendulum's %.1f s\n\n", std::sqrt(m / k), 2.0 * std::acos(-1.0) * std::sqrt(l / g));

  const Options options{.rtol = 1e-7, .atol = 1e-10};
  const auto explicitly = simulate(damped, start, 10.0, Dop853{}, options);
  const auto implicitly = simulate(damped, start, 10.0, CvodeBdf{}, options);
  const auto automatic = simulate(damped, start, 10.0, Automatic{}, options);
  const auto per_evaluation = [&](const auto& run) { return run.t / static_cast<double>(run.statistics.evaluations); };
  std::printf("dop853     steps within the spring's own time: %s\n",
              10.0 / static_cast<double>(explicitly.statistics.steps) < 10.0 * std::sqrt(m / k) ? "yes" : "no");
  std::printf("cvode_bdf  goes more than 50 times as far with an evaluation: %s\n",
              per_evaluation(implicitly) > 50.0 * per_evaluation(explicitly) ? "yes" : "no");
  std::printf("automatic  goes more than 20 times as far, too: %s; it took %s\n", per_evaluation(automatic) > 20.0 * per_evaluation(explicitly) ? "yes" : "no",
              automatic.statistics.method.c_str());
  std::printf("all three at the same place to 1e-3: %s\n\n",
              (explicitly.state().q - implicitly.state().q).norm() < 1e-3 && (explicitly.state().q - automatic.state().q).norm() < 1e-3
                  ? "yes"
                  : "no");

  // A run that is given too few steps tells why they are so short.
  const auto stopped = simulate(damped, start, 10.0, Dop853{}, {.rtol = 1e-7, .atol = 1e-10, .max_steps = 2000});
  std::printf("with max_steps = 2000: %s\n", std::string(name(stopped.outcome)).c_str());
  const std::size_t at = stopped.message.find("diagnosis: ");
  std::printf("%s\n", at == std::string::npos ? "no diagnosis" : stopped.message.substr(at, stopped.message.find(':', at + 11) - at).c_str());
}
