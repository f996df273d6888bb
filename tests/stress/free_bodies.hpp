#pragma once
// SPDX-License-Identifier: MIT
//
// Free rigid bodies whose motion is known: a symmetric one by two rotations about fixed axes, an asymmetric one by
// Jacobi's elliptic functions.

#include <Eigen/Geometry>
#include <cmath>

#include "qdot/mechanics/rotation.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot::stress {

/// A symmetric body, moments 1, 1, I3: its axis goes round a cone about L that contains the space axis z.
///
/// The axis of the body stands on z at t = pole, and there Euler's angles 3-1-3 have θ = 0.
struct ConeThroughPole {
  double I3 = 0.6, spin = 2.0, half_angle = 0.7, pole = 1.0;

  double L() const { return I3 * spin / std::cos(half_angle); }
  Eigen::Vector3d direction() const { return {std::sin(half_angle), 0.0, std::cos(half_angle)}; }
  /// R(t) = exp([l×] L (t − pole)) exp([e₃×] (1 − I₃) ω₃ t)
  Eigen::Matrix3d rotation(double t) const {
    return (Eigen::AngleAxisd(L() * (t - pole), direction()) *
            Eigen::AngleAxisd((1.0 - I3) * spin * t, Eigen::Vector3d::UnitZ()))
        .toRotationMatrix();
  }
  /// Along the space axes: L + (1 − I₃) ω₃ e₃.
  Eigen::Vector3d omega(double t) const { return L() * direction() + (1.0 - I3) * spin * rotation(t).col(2); }
};

/// sn, cn, dn of Jacobi by descending Landen steps (arithmetic-geometric mean), m = k².
struct Jacobi {
  long double sn, cn, dn;
};
inline Jacobi jacobi(long double u, long double m) {
  long double a[16], c[16];
  a[0] = 1.0L;
  c[0] = std::sqrt(m);
  long double b = std::sqrt(1.0L - m);
  int n = 0;
  while (std::abs(c[n]) > 1e-19L && n < 15) {
    a[n + 1] = (a[n] + b) / 2;
    c[n + 1] = (a[n] - b) / 2;
    b = std::sqrt(a[n] * b);
    ++n;
  }
  long double phi = std::ldexp(a[n] * u, n), before = phi;
  for (; n > 0; --n) {
    before = phi;
    phi = (phi + std::asin(c[n] * std::sin(phi) / a[n])) / 2;
  }
  (void)before;
  return {std::sin(phi), std::cos(phi), std::sqrt(1.0L - m * std::sin(phi) * std::sin(phi))};
}

/// Body components of ω of a free body with moments A < B < C, when L² > 2TB (the axis of C is circled):
/// ω₁ = a cn, ω₂ = −b sn, ω₃ = c dn (Landau and Lifshitz, Mechanics, § 37; there with −t).
struct AsymmetricBody {
  double A, B, C, T2, L2;  // T2 = 2T, L2 = L²

  Eigen::Vector3d body_omega(double t) const {
    const double a = std::sqrt((T2 * C - L2) / (A * (C - A))), b = std::sqrt((T2 * C - L2) / (B * (C - B))),
                 c = std::sqrt((L2 - T2 * A) / (C * (C - A)));
    const long double rate = std::sqrt((C - B) * (static_cast<long double>(L2) - T2 * A) / (static_cast<long double>(A) * B * C));
    const long double m = (B - A) * (static_cast<long double>(T2) * C - L2) / ((C - B) * (static_cast<long double>(L2) - T2 * A));
    const Jacobi e = jacobi(rate * t, m);
    return {a * static_cast<double>(e.cn), b * static_cast<double>(e.sn), c * static_cast<double>(e.dn)};
  }
};

/// T of a body that turns about a fixed point, its rotation written in any coordinates.
template <int n, class Rotation>
auto turning_body(const Eigen::Vector3d& moments, const Rotation& rotation) {
  return mechanical_system<n>([=](const auto& q, const auto& qdot) {
    const auto w = body_angular_velocity_of(rotation, q, qdot);
    return 0.5 * (moments[0] * w[0] * w[0] + moments[1] * w[1] * w[1] + moments[2] * w[2] * w[2]);
  });
}

/// q̇ with R(q) turning at ω (space axes); the shortest where q̇ is not unique.
template <int n, class Rotation>
Vector<double, n> rates(const Rotation& rotation, const Vector<double, n>& q, const Eigen::Vector3d& omega) {
  Matrix<double, 3, n> J;
  for (int i = 0; i < n; ++i) J.col(i) = angular_velocity_of(rotation, q, Vector<double, n>(Vector<double, n>::Unit(i)));
  return J.transpose() * (J * J.transpose()).ldlt().solve(omega);
}

}  // namespace qdot::stress
