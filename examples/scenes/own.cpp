// A scene for the program qdot:  qdot run own.cpp --out out/own
#include <scenes/own_scene.hpp>
using namespace qdot::scenes;

struct Own {
  double m = 1.0, l = 1.0, g = 9.81;
  constexpr auto T(const auto& qdot) const { return 0.5 * m * l * l * qdot[0] * qdot[0]; }
  constexpr auto V(const auto& q) const { using std::cos; return -m * g * l * cos(q[0]); }
  auto bob(const auto& q) const { return Point{l * std::sin(q[0]), -l * std::cos(q[0])}; }
};

OwnScene qdot_scene() {
  return runnable(
      Scene<Own, 1>{.summary = "A bob on a massless rod; the angle is measured from the downward vertical.",
                    .parameters = {{"m", &Own::m, "kg", Range::positive, "mass of the bob"},
                                   {"l", &Own::l, "m", Range::positive, "length of the rod"},
                                   {"g", &Own::g, "m/s^2", Range::between(0, 100), "gravity"}},
                    .coordinates = {{"theta", "rad"}},
                    .start = {2.0},  // and the velocity after it, if it is not zero
                    .drawing = {trail(1), line({0, 1}), pivot(0), disk(1)},
                    .positions = [](const Own& s, const auto& q) -> std::vector<Point> { return {{0, 0}, s.bob(q)}; }},
      optional_effect<Own>("damping", 0.2, "N m s", Range::non_negative, "torque per angular velocity",
                           [](const Own&, double c) { return qdot::viscous_damping(qdot::Vector<double, 1>(c)); }));
}
