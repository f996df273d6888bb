// SPDX-License-Identifier: MIT
// message: qdot: second derivatives do not go through events that change the state: let events stop the run or be recorded, or difference sensitivities()
#include <qdot/analysis/second_sensitivity.hpp>
#include <qdot/qdot.hpp>

int main() {
  const auto ball = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 9.81 * q[0]; });
  const auto bounce = [](qdot::State<1>& s) { s.qdot[0] *= -0.8; };
  const auto floor = qdot::events(qdot::event("floor", [](const auto& q) { return q[0]; }).falling().then(bounce));
  return qdot::second_sensitivities(ball, qdot::State<1>{0.0, {1.0}, {0.0}}, 1.0, qdot::Taylor{}, {}, floor).completed() ? 0 : 1;
}
