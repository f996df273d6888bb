#pragma once
// SPDX-License-Identifier: MIT
//
// Which phases follow from the accelerations, when velocities are known.
//
// A contact at φ = 0 without velocity may be closed, friction at v = 0 may stick; these are the candidates, all others have no choice.
// Their forces minimize ½ λᵀA λ + bᵀλ within their bounds (effects/rows/bounded_minimum.hpp), where b are the accelerations without them. This
// is Gauss's principle with one-sided constraints. Its accelerations w are unique, whether rows depend on each other or not. Then
//
//     contact      opens where w > 0; is closed where λ > 0, or where it was closed and is not asked to open
//     friction     slides where w ≠ 0, in that direction; sticks otherwise
//
// With F_k < F_s that is not all: what slides has F_k, and the rest is judged again. What slid before, or has left its limit of sticking
// in this moment, goes on to slide as long as w agrees. If no phases agree, no motion is made up: ConstraintError.
//
// Friction whose v the lasting constraints alone decide (a slider at its dead centre, a driven coordinate) is no candidate: no friction, however
// strong, could hold it there. It slides on to where they take it.

#include <Eigen/Core>
#include <cmath>
#include <vector>

namespace qdot::detail {

class SwitchingScene;  // effects/equations/switching_scene.hpp

// What is known of one effect while phases are chosen.
struct Switch {
  bool contact = false, fired = false, touches = false, candidate = false;
  double u = 0.0;       // φ̇ or v
  double still = 0.0;   // the size of velocities that count as none
  double lowest = 0.0;  // the height of hops that count as none
  int slips = 0;        // the direction in which it slips, where it has left its limit of sticking; in a plane 1, and
  Eigen::Vector3d along = Eigen::Vector3d::Zero();  // that direction
};

// z ← the phases at a state, from those before.
//
// @throws ConstraintError  no phases fit together, or contacts contradict each other
template <class = void>
[[gnu::cold]] void choose_phases(const SwitchingScene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& before,
                                 std::vector<Switch>& all, Eigen::VectorXd& z);

inline constexpr double negligible_force = 1e-9;  // to which forces and accelerations are told from zero

inline double weighted(const Eigen::MatrixXd& jacobian, Eigen::Index row, const Eigen::Ref<const Eigen::VectorXd>& weights) {
  double sum = 0.0;
  for (Eigen::Index j = 0; j < jacobian.cols(); ++j) sum += std::abs(jacobian(row, j)) * weights[j];
  return sum;
}

// Of several rows the length of their weighted sums.
inline double weighted(const Eigen::MatrixXd& jacobian, Eigen::Index row, Eigen::Index rows, const Eigen::Ref<const Eigen::VectorXd>& weights) {
  double square = 0.0;
  for (Eigen::Index i = row; i < row + rows; ++i) square += weighted(jacobian, i, weights) * weighted(jacobian, i, weights);
  return rows == 1 ? weighted(jacobian, row, weights) : std::sqrt(square);
}

// The multiplier that would balance the applied forces along a row.
inline double force_scale(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& f, Eigen::Index row) {
  double square = 0.0, sum = 0.0;
  for (Eigen::Index j = 0; j < jacobian.cols(); ++j) {
    const double entry = jacobian(row, j);
    square += entry * entry;
    sum += std::abs(entry) * std::abs(f[j]);
  }
  return square > 0 ? sum / square : 0.0;
}

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template void choose_phases<void>(const SwitchingScene&, double, const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::VectorXd&,
                                         std::vector<Switch>&, Eigen::VectorXd&);
}  // namespace qdot::detail
#else
#include "qdot/effects/equations/phase_choice.ipp"
#endif
