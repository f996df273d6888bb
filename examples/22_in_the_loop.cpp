// SPDX-License-Identifier: MIT
//
// A pole on a cart, held up by a controller that looks a thousand times a second. The program owns the clock, and the simulator goes on when it is told
// to.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include <qdot/effects/dissipation.hpp>
#include <qdot/effects/input.hpp>
#include <qdot/effects/scene_form.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/simulator.hpp>

// q = (s, θ): the cart of 1 kg on its track, a bob of 0.2 kg on a rod of 0.5 m, θ from the upward vertical.
struct CartAndPole {
  double M = 1.0, m = 0.2, l = 0.5, g = 9.81;

  auto T(const auto& q, const auto& v) const {
    using std::cos;
    return 0.5 * (M + m) * v[0] * v[0] + m * l * v[0] * v[1] * cos(q[1]) + 0.5 * m * l * l * v[1] * v[1];
  }
  auto V(const auto& q) const {
    using std::cos;
    return m * g * l * cos(q[1]);
  }
};

int main() {
  using namespace qdot;
  const auto scene = qdot::scene(mechanical_system<2>(CartAndPole{}), viscous_damping(Vector<double, 2>(0.5, 0.01)), input("motor", 0));
  const State<2> leaning{0.0, {0.0, 0.3}, {0.0, 0.0}};
  const auto falls = event("fallen", [](const auto& q) { return std::cos(q[1]); }).stop();
  Simulator plant(scene, leaning, Dop853{}, {.rtol = 1e-9, .max_steps = 1000}, falls);

  using Clock = std::chrono::steady_clock;
  double worst = 0.0, sum = 0.0;
  SimulatorState after_two_seconds;
  for (long k = 1; k <= 5000; ++k) {
    const auto q = plant.q(), v = plant.qdot();
    plant.set_input("motor", std::clamp(40.0 * q[1] + 8.0 * v[1] + 2.0 * q[0] + 4.0 * v[0], -12.0, 12.0));
    const auto before = Clock::now();
    if (!plant.advance_to(1e-3 * static_cast<double>(k))) return std::printf("%s\n", plant.message().c_str()), 1;
    const double spent = std::chrono::duration<double, std::micro>(Clock::now() - before).count();
    worst = std::max(worst, spent);
    sum += spent;
    if (k == 2000) after_two_seconds = plant.save();
    if (k % 1000 == 0) std::printf("t = %.0f s   s = %7.4f m   theta = %7.4f   force %7.3f N\n", plant.t(), q[0], q[1], plant.input("motor"));
  }
  std::fprintf(stderr, "a call of 1 ms took %.1f us, the longest of %d %.1f us\n", sum / 5000, 5000, worst);

  // What if the motor had failed at t = 2 s? Go back and see.
  plant.restore(after_two_seconds);
  plant.set_input("motor", 0.0);
  const Advance end = plant.advance(60.0);
  std::printf("without the motor from t = 2 s on: %s at t = %.3f s, theta = %.4f\n", std::string(name(end.outcome)).c_str(), end.t, plant.q()[1]);
}
