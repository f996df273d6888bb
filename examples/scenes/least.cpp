// The least that the program qdot takes for a scene: T, V, and how many coordinates there are.
#include <scenes/own_scene.hpp>

struct Hanging {
  constexpr auto T(const auto& qdot) const { return 0.5 * (qdot[0] * qdot[0] + qdot[1] * qdot[1]); }
  constexpr auto V(const auto& q) const { return 0.5 * (q[0] * q[0] + 4.0 * q[1] * q[1]) - q[0]; }
};

qdot::scenes::OwnScene qdot_scene() { return qdot::scenes::runnable(qdot::scenes::Scene<Hanging, 2>{}); }
