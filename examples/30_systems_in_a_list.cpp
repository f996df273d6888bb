// SPDX-License-Identifier: MIT
//
// Systems of different types in one list: the one that a user names is run, or all of them. One loop, one function that looks at a motion.
//
//     ./30_systems_in_a_list [NAME]
#include <cstdio>
#include <map>
#include <string>

#include <qdot/effects/constraints.hpp>
#include <qdot/effects/contact.hpp>
#include <qdot/effects/dissipation.hpp>
#include <qdot/effects/scene_form.hpp>
#include <qdot/integrate/any_system.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/simulate.hpp>

using namespace qdot;

struct Plant {
  AnySystem system;
  State<Dynamic> start;
};

int main(int count, char** arguments) {
  const double g = 9.81;
  const auto swing = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [g](const auto& q) { return -g * cos(q[0]); });
  const auto mass = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [g](const auto& q) { return g * q[0]; });
  const auto bob = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [g](const auto& q) { return g * q[1]; });
  const auto length = [](const auto& q) { return q.squaredNorm() - 1.0; };
  const Vector<double, 1> one(1.0), none(0.0);

  const std::map<std::string, Plant> plants = {
      {"ball", {scene(mass, contact("floor", [](const auto& q) { return q[0]; }, {.e = 0.7})), {0.0, one, none}}},
      {"bob", {scene(bob, holonomic("rod", length)), {0.0, Vector<double, 2>(0.6, -0.8), Vector<double, 2>(0.0, 0.0)}}},
      {"swing", {swing, {0.0, one, none}}},
      {"tired swing", {scene(swing, viscous_damping(Vector<double, 1>(0.2))), {0.0, one, none}}},
  };

  const std::string wanted = count > 1 ? arguments[1] : "";
  if (!wanted.empty() && !plants.contains(wanted)) {
    std::fprintf(stderr, "NAME must be ball, bob, swing or tired swing, given %s\n", wanted.c_str());
    return 2;
  }
  for (const auto& [name, plant] : plants) {
    if (!wanted.empty() && name != wanted) continue;
    const auto run = simulate(plant.system, plant.start, 2.0, Dop853{}, {.rtol = 1e-10, .atol = 1e-12});
    const double before = energy(plant.system, plant.start), after = energy(plant.system, run.state());
    std::printf("%-12s %ld coordinates, %s(2) = %8.5f, energy %8.5f -> %8.5f, %zu events\n", name.c_str(), static_cast<long>(plant.system.dof()),
                plant.system.component_name(0).c_str(), run.y[0], before, after, run.events.size());
  }
}
