// A swing whose rope is drawn in and let out twice in a swing, as a child does that stands up and squats: it grows from next to nothing.
//
//     T = ½ m (l(t)² θ̇² + l̇(t)²),   V = −m g l(t) cos θ,   l(t) = l (1 + a cos 2ωt),   ω² = g/l
#include <scenes/own_scene.hpp>
using namespace qdot::scenes;

struct PumpedSwing {
  double m = 30.0, l = 2.5, g = 9.81, a = 0.05;

  constexpr auto length(const auto& t) const {
    using std::cos;
    return l * (1.0 + a * cos(2.0 * std::sqrt(g / l) * t));
  }
  constexpr auto T(const auto&, const auto& qdot, const auto& t) const {
    using std::sin;
    const double rate = 2.0 * std::sqrt(g / l);
    const auto speed = -l * a * rate * sin(rate * t), turning = length(t) * qdot[0];
    return 0.5 * m * (turning * turning + speed * speed);
  }
  constexpr auto V(const auto& q, const auto& t) const {
    using std::cos;
    return -m * g * length(t) * cos(q[0]);
  }
};

OwnScene qdot_scene() {
  return runnable(
      Scene<PumpedSwing, 1>{
          .title = "Swing that pumps itself up",
          .summary = "The rope is drawn in and let out twice in a swing; the angle is measured from the downward vertical.",
          .parameters = {{"m", &PumpedSwing::m, "kg", Range::positive, "mass of the child"},
                         {"l", &PumpedSwing::l, "m", Range::positive, "mean length of the rope"},
                         {"g", &PumpedSwing::g, "m/s^2", Range::positive, "gravity"},
                         {"a", &PumpedSwing::a, "", Range::between(0, 0.5), "amplitude of the length over its mean"}},
          .coordinates = {{"theta", "rad"}},
          .start = {0.02},
          .t_end = 60,
          .drawing = [](const PumpedSwing& s) -> Drawing {  // a function, because the ground depends on a parameter
            return {.shapes = {line({0, 1}), pivot(0), disk(1)}, .backdrop = {{{-s.l, -1.6 * s.l}, {s.l, -1.6 * s.l}}}};
          },
          .positions = [](const PumpedSwing& s, const auto& q, double t) -> std::vector<Point> {
            return {{0, 0}, {s.length(t) * std::sin(q[0]), -s.length(t) * std::cos(q[0])}};
          }},
      optional_effect<PumpedSwing>("drag", 1.0, "kg/m", Range::non_negative, "force of the air over squared speed", [](const PumpedSwing& s, double b) {
        return qdot::generalized_force([s, b](const auto&, const auto& qdot, const auto& t) {
          using std::sqrt;
          const auto speed = s.length(t) * qdot[0];
          return -b * s.length(t) * speed * sqrt(speed * speed + 1e-12);
        });
      }));
}
