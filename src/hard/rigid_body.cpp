// SPDX-License-Identifier: MIT
//
// The free rigid body: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, II.10 (JACB), as a
// Lagrangian problem in unit quaternions. Rates in the scales of the book are (sn t, cn t, dn t) with parameter 0.51; values
// with 40 digits.
#include "hard/motion.hpp"
#include "qdot/effects/constraints.hpp"

namespace qdot::hard {
namespace {

constexpr double I1 = 2.0, I2 = 2.5, I3 = 1.0;

template <class Q, class V>
auto body_rates(const Q& e, const V& v) {
  using S = std::common_type_t<typename Q::Scalar, typename V::Scalar>;
  return Vector<S, 3>(2.0 * (-e[1] * v[0] + e[0] * v[1] + e[3] * v[2] - e[2] * v[3]),
                      2.0 * (-e[2] * v[0] - e[3] * v[1] + e[0] * v[2] + e[1] * v[3]),
                      2.0 * (-e[3] * v[0] + e[2] * v[1] - e[1] * v[2] + e[0] * v[3]));
}

// M has rank 3 of 4: a quaternion's length has no inertia, and the constraint holds it.
struct FreeBody {
  auto T(const auto& e, const auto& v) const {
    const auto w = body_rates(e, v);
    return 0.5 * (I1 * w[0] * w[0] + I2 * w[1] * w[1] + I3 * w[2] * w[2]);
  }
  auto V(const auto& e) const {
    using S = typename std::decay_t<decltype(e)>::Scalar;
    return S(0.0);
  }
};

std::vector<Row> rows() {
  const auto body = scene(mechanical_system<4>(FreeBody{}).with_indefinite_mass_matrix(),
                          holonomic("unit length", [](const auto& e) { return 0.5 * (e.squaredNorm() - 1.0); }));
  const auto moving = motion(body);
  struct End {
    double t, y1, y2, y3;
  };
  std::vector<Row> rows;
  for (const End& end : {End{20, -0.9396570798729203961884362, -0.3421177754000749065348221, 0.7414126596199953007825587},
                         End{100, 0.5371024110853426245109476, -0.8435170419181296068077654, 0.9235127015927928894619861}}) {
    const Problem problem{.name = "free rigid body, t = " + std::to_string(static_cast<int>(end.t)),
                          .t_end = end.t,
                          .start = numbers({1, 0, 0, 0, 0, 0, std::sqrt(1.36) / 2, std::sqrt(10.0 / 3) / 2}),
                          // and the angular momentum in space, as at the start
                          .exact = numbers({end.y1, end.y2, end.y3, 0.0, I2 * std::sqrt(1.36), I3 * std::sqrt(10.0 / 3)}),
                          .reference_digits = 22,
                          .gain = end.t,
                          .seen = [](const State_& y) {
                            const Eigen::Vector4d e = y.head(4), v = y.tail(4);
                            const Eigen::Vector3d w = body_rates(e, v);
                            const Eigen::Vector3d L = Eigen::Quaterniond(e[0], e[1], e[2], e[3]).toRotationMatrix() *
                                                      Eigen::Vector3d(I1 * w[0], I2 * w[1], I3 * w[2]);
                            return numbers({w[0] / std::sqrt(2.55), w[1] / std::sqrt(1.36), w[2] / std::sqrt(10.0 / 3), L[0], L[1], L[2]});
                          }};
    rows.push_back(solved(problem, moving, By::dop853, {.rtol = 2.5e-15, .atol = 2.5e-15}));
    rows.push_back(solved(problem, moving, By::dopri5, {.rtol = 2.5e-15, .atol = 2.5e-15}));
  }
  return rows;
}

}  // namespace

Case rigid_body() {
  return {"rigid_body", "Free rigid body",
          "Euler's top in four quaternion coordinates: M is singular, of rank 3, and regular only together with the constraint "
          "of unit length. Compared are the body rates, which are elliptic functions, and the angular momentum in space.",
          rows};
}

}  // namespace qdot::hard
