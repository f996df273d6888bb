// SPDX-License-Identifier: MIT
//
// A user of most of what the library has: power series, Dop853 and BDF by choice, recorded loops, a constraint, an event, and words of errors.
#include <qdot/integrate/cvode_automatic.hpp>
#include <qdot/integrate/simulate.hpp>
#include <qdot/qdot.hpp>

#include <cmath>
#include <string>

double position_after(double time);

int main() {
  const auto bob = qdot::mechanical_system<2>(
      [](const auto& qdot) {
        auto sum = 0.0 * qdot[0];
        for (int i = 0; i < 2; ++i) sum += 0.5 * qdot[i] * qdot[i];
        return sum;
      },
      [](const auto& q) { return 9.81 * q[1]; });
  const auto rod = qdot::holonomic("rod", [](const auto& q) { return 0.5 * (q[0] * q[0] + q[1] * q[1] - 1.0); });
  const auto top = qdot::event("top", [](const auto&, const auto& qdot) { return qdot[1]; }).falling();
  const auto swing = simulate(scene(bob, rod), qdot::State<2>{0.0, {0.8, -0.6}, {0.0, 0.0}}, 2.0, qdot::Automatic{}, top);
  const bool swings = swing.completed() && !swing.events.empty() && std::abs(swing.state().q.norm() - 1.0) < 1e-9;

  const auto massless = qdot::mechanical_system<2>([](const auto& qdot) { return 0.5 * qdot[0] * qdot[0]; }, [](const auto& q) { return q[0]; });
  std::string words;
  try {
    qdot::acceleration(massless, qdot::State<2>{0.0, {1.0, 0.0}, {0.0, 0.0}});
  } catch (const qdot::SingularMassMatrix& error) {
    words = error.what();
  }
  const double period = 2.0 * std::acos(-1.0);
  return swings && words.find("q1") != std::string::npos && std::abs(position_after(period) - 1.0) < 1e-6 ? 0 : 1;
}
