// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench scenes`: the Jacobian of a scene's first-order form, which implicit methods ask for, beside one q̈ of the same scene. A few
// scenes of each kind; each takes the compiler some seconds.
#include "bench/measured_scenes.hpp"
#include "bench/scenes.hpp"
#include "qdot/effects/scene_form.hpp"

namespace qdot::bench {

namespace {

template <class Case>
[[gnu::noinline]] void jacobian_of_scene(const double* q, const double* qdot, double* out) {
  constexpr int n = Case::n;
  static const auto form = as_in_a_run(first_order_form(Case::scene()));
  static Eigen::VectorXd y = form.packed(State<n>{0.0, Vector<double, n>::Zero(), Vector<double, n>::Zero()});
  static Eigen::MatrixXd J(form.size(), form.size());
  for (int i = 0; i < n; ++i) {
    y[i] = q[i];
    y[n + i] = qdot[i];
  }
  y.tail(y.size() - 2 * n) = benched_states<Case>;
  form.jacobian(0.0, y, J);
  for (int i = 0; i < n; ++i) out[i] = J(n + i, i);
}

template <class... Case>
std::vector<SceneRow> jacobian_rows_of() {
  std::vector<SceneRow> rows{row_beside<Case>(by_scene<Case>, "its q̈")...};
  const AccelerationFunction jacobians[] = {jacobian_of_scene<Case>...};
  for (std::size_t k = 0; k < rows.size(); ++k) {
    rows[k].evaluation.measured = jacobians[k];
    rows[k].effect += ", Jacobian";
  }
  return rows;
}

}  // namespace

std::vector<SceneRow> jacobian_scene_rows() {
  return jacobian_rows_of<DampedChain<LoopsInARun, 4>, DampedGuidedChain<LoopsInARun, 4>, DampedGuidedChain<LoopsInARun, 8>, BareChain<PlacedMasses, 4>,
                          DampedGuidedChain<PlacedMasses, 4>, DampedGuidedChain<PlacedMasses, 8>, FourBarLinkage, SleighOnBlade, TautRope,
                          CartpoleWithMotor>();
}

}  // namespace qdot::bench
