// SPDX-License-Identifier: MIT
//
// Pinocchio's articulated-body algorithm. Its joints turn relative to each other; angles from the vertical are their sums.
#include <pinocchio/multibody.hpp>

#include <pinocchio/algorithm/aba.hpp>

#include "bench/peers/peer.hpp"

namespace {

template <int n>
void chain(const double* q, const double* qdot, double* qddot) {
  static const pinocchio::Model model = [] {
    pinocchio::Model m;
    m.gravity.linear(Eigen::Vector3d(0.0, 0.0, -9.81));
    pinocchio::JointIndex parent = 0;
    for (int i = 0; i < n; ++i) {
      const pinocchio::SE3 place(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0.0, 0.0, i == 0 ? 0.0 : -1.0));
      parent = m.addJoint(parent, pinocchio::JointModelRY(), place, "joint" + std::to_string(i));
      m.appendBodyToJoint(parent, pinocchio::Inertia(1.0, Eigen::Vector3d(0.0, 0.0, -1.0), Eigen::Matrix3d::Zero()),
                          pinocchio::SE3::Identity());
    }
    return m;
  }();
  static pinocchio::Data data(model);
  static Eigen::VectorXd x(n), v(n);
  static const Eigen::VectorXd none = Eigen::VectorXd::Zero(n);
  for (int i = 0; i < n; ++i) {
    x[i] = q[i] - (i == 0 ? 0.0 : q[i - 1]);
    v[i] = qdot[i] - (i == 0 ? 0.0 : qdot[i - 1]);
  }
  const Eigen::VectorXd& a = pinocchio::aba(model, data, x, v, none);
  double sum = 0.0;
  for (int i = 0; i < n; ++i) qddot[i] = sum += a[i];
}

}  // namespace

extern "C" ChainAcceleration acceleration_of_chain(int n) {
  return of_links<1, 2, 4, 8, 16>(n, []<int links>() -> ChainAcceleration { return chain<links>; });
}
