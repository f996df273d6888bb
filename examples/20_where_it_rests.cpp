// SPDX-License-Identifier: MIT
//
// Where a scene rests as a parameter changes: a bead on a hoop that is turned faster and faster. And a column that is pressed by a force that
// follows it, or does not.

#include <cstdio>
#include <vector>

#include <qdot/analysis/equilibrium_branch.hpp>
#include <qdot/effects/forces.hpp>
#include <qdot/qdot.hpp>

using namespace qdot;

struct Bead {
  double Omega = 0.0;  // rad/s; the hoop has a radius of 1 m
  auto T(const auto& q, const auto& qdot) const {
    using std::sin;
    const auto s = sin(q[0]);
    return 0.5 * (qdot[0] * qdot[0] + Omega * Omega * s * s);
  }
  auto V(const auto& q) const {
    using std::cos;
    return -9.81 * cos(q[0]);
  }
};

// Two links of length and stiffness 1, masses 2 and 1 at their ends, and a force P on the tip along the second link, or along the x axis.
struct Column {
  auto T(const auto& q, const auto& qdot) const {
    using std::cos;
    return 1.5 * qdot[0] * qdot[0] + 0.5 * qdot[1] * qdot[1] + qdot[0] * qdot[1] * cos(q[0] - q[1]);
  }
  auto V(const auto& q) const { return 0.5 * q[0] * q[0] + 0.5 * (q[1] - q[0]) * (q[1] - q[0]); }
};
auto pressed_column(double P, bool follows) {
  return scene(mechanical_system<2>(Column{}), generalized_force([P, follows](const auto& q, const auto&) {
                 using std::sin;
                 return follows ? vector(P * sin(q[0] - q[1]), 0.0 * q[1]) : vector(P * sin(q[0]), P * sin(q[1]));
               }));
}

void print(const std::vector<EquilibriumBranch>& branches) {
  for (const EquilibriumBranch& branch : branches) {
    for (const BranchPoint& point : branch.points) {
      if (point.kind == BranchKind::regular) continue;
      std::printf("  %-6s  p = %9.6f  q = (", std::string(name(point.kind)).c_str(), point.p);
      for (Eigen::Index i = 0; i < point.q.size(); ++i) std::printf(i == 0 ? "%.4f" : ", %.4f", point.q[i] == 0.0 ? 0.0 : point.q[i]);
      const bool decided = point.kind == BranchKind::start || point.kind == BranchKind::end;
      std::printf(")  %s\n", decided ? description(point.stability) : "stability changes");
    }
    std::printf("  %s\n", branch.message.c_str());
  }
}

int main() {
  std::printf("bead on a hoop, p = Omega\n");
  print(equilibrium_branches([](double Omega) { return mechanical_system<1>(Bead{Omega}); }, Eigen::VectorXd::Zero(1), 2.0, 5.0));
  for (const bool follows : {false, true}) {
    std::printf("column, p = P, %s\n", follows ? "the force follows it" : "the force keeps its direction");
    print(equilibrium_branches([follows](double P) { return pressed_column(P, follows); }, Eigen::VectorXd::Zero(2), 0.1, 2.5, {.most_branches = 1}));
  }
}
