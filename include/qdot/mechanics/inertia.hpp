#pragma once
// SPDX-License-Identifier: MIT
//
// Inertia: how a mass distribution resists turning
// ================================================
//
//     Σ ½ m |ω × AP|² = ½ ω · I_A ω,      I_A = Σ m [AP×]ᵀ[AP×] = Σ m (|AP|² E − AP APᵀ),      [a×] b = a × b
//
// is the kinetic energy of a rigid body that turns about its point A with ω, P its points with masses m. The inertia
// tensor I_A has the moments Σ m (distance from the axis)² on its diagonal. Off it are the products with a MINUS sign,
// I_xy = −Σ m x y.
//     I_A = I_G + M (|AG|² E − AG AGᵀ)        parallel axes (Huygens, Steiner), from or to the centre of mass G only
//     R I Rᵀ                                  in new axes, where R takes components in the old ones to those in the new ones
//
// I_xx + I_yy − I_zz = 2 Σ m z² ≥ 0 in every frame, thus the principal moments are not negative and each is at most the
// sum of the other two. A symmetric positive definite matrix that breaks this rule, say diag(1, 1, 3), belongs to no
// body of positive masses: `valid_inertia` refuses it.

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "qdot/error.hpp"

namespace qdot {

namespace detail {

// A number as a message shows it: six digits, 1e-12 not as 0.000000.
inline std::string number_text(double x) { return sentence({Phrase(x, 6)}); }

}  // namespace detail

/// A point with a mass: the atom of mechanics.
struct PointMass {
  double mass;               ///< m
  Eigen::Vector3d position;  ///< r
};

/// Σ m.
inline double total_mass(std::span<const PointMass> points) {
  double sum = 0.0;
  for (const PointMass& point : points) sum += point.mass;
  return sum;
}

/// The centre of mass Σ m r / Σ m.
///
/// @throws InvalidValue when the total mass is not positive, for then there is no such point
inline Eigen::Vector3d centre_of_mass(std::span<const PointMass> points) {
  const double M = total_mass(points);
  if (!(M > 0.0)) {
    detail::throw_invalid_value({"centre_of_mass: the total mass must be positive, but it is ", {M, 6}, " over ", points.size(),
                                 " points; add points with mass"});
  }
  double sum[3] = {};
  for (const PointMass& point : points)
    for (int i = 0; i < 3; ++i) sum[i] += point.mass * point.position[i];
  return {sum[0] / M, sum[1] / M, sum[2] / M};
}

namespace detail {

// I + m (|a|² E − a aᵀ).
inline Eigen::Matrix3d with_point(Eigen::Matrix3d inertia, double m, const Eigen::Vector3d& a) {
  const double square = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) inertia(i, j) += m * ((i == j ? square : 0.0) - a[i] * a[j]);
  return inertia;
}

inline Eigen::Matrix3d diagonal(double x, double y, double z) {
  Eigen::Matrix3d inertia;
  for (int k = 0; k < 9; ++k) inertia.data()[k] = 0.0;
  inertia(0, 0) = x, inertia(1, 1) = y, inertia(2, 2) = z;
  return inertia;
}

}  // namespace detail

/// The tensor |a|² E − a aᵀ = [a×]ᵀ[a×]: inertia about the origin of a unit mass at a.
inline Eigen::Matrix3d unit_point_inertia(const Eigen::Vector3d& a) {
  return detail::with_point(detail::diagonal(0.0, 0.0, 0.0), 1.0, a);
}

/// Inertia tensor I_A of a point cloud about the point A.
inline Eigen::Matrix3d inertia_of_points(std::span<const PointMass> points, const Eigen::Vector3d& A) {
  Eigen::Matrix3d inertia = detail::diagonal(0.0, 0.0, 0.0);
  for (const PointMass& point : points)
    inertia = detail::with_point(inertia, point.mass, {point.position[0] - A[0], point.position[1] - A[1], point.position[2] - A[2]});
  return inertia;
}

/// Parallel axes, away from the centre of mass: I_A = I_G + M (|AG|² E − AG AGᵀ).
///
/// Only the square of AG enters, so GA does as well as AG.
inline Eigen::Matrix3d inertia_away_from_centre(const Eigen::Matrix3d& I_G, double M, const Eigen::Vector3d& AG) {
  return detail::with_point(I_G, M, AG);
}

/// Parallel axes, back to the centre of mass: I_G = I_A − M (|AG|² E − AG AGᵀ).
inline Eigen::Matrix3d inertia_at_centre(const Eigen::Matrix3d& I_A, double M, const Eigen::Vector3d& AG) {
  return detail::with_point(I_A, -M, AG);
}

/// The same tensor in turned axes, R I Rᵀ, where R takes old components to new ones; symmetric to the bit.
///
/// R may hold any scalar (dual numbers inside T, for instance); I may be of numbers.
template <class Rotation, class Tensor>
Eigen::Matrix<typename Rotation::Scalar, 3, 3> turned_inertia(const Eigen::MatrixBase<Rotation>& R,
                                                              const Eigen::MatrixBase<Tensor>& inertia) {
  using S = typename Rotation::Scalar;
  Eigen::Matrix<S, 3, 3> RI;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) RI(i, j) = R(i, 0) * inertia(0, j) + R(i, 1) * inertia(1, j) + R(i, 2) * inertia(2, j);
  }
  Eigen::Matrix<S, 3, 3> turned;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j <= i; ++j) {
      turned(i, j) = RI(i, 0) * R(j, 0) + RI(i, 1) * R(j, 1) + RI(i, 2) * R(j, 2);
      turned(j, i) = turned(i, j);
    }
  }
  return turned;
}

/// Principal moments I₁ ≤ I₂ ≤ I₃ and a right-handed set of principal axes (columns): I = axes·diag(moments)·axesᵀ.
struct PrincipalInertia {
  Eigen::Vector3d moments;  ///< I₁ ≤ I₂ ≤ I₃
  Eigen::Matrix3d axes;     ///< their directions, a column each
};

namespace detail {

// Whether all eigenvalues of a symmetric A are at least `least`: L D Lᵀ of A − least E has no pivot below zero. The limits are a little below
// zero, so that what is zero by right has positive pivots.
inline bool has_no_moment_below(double least, const Eigen::Matrix3d& A) {
  double L[3][3] = {}, d[3];
  for (int k = 0; k < 3; ++k) {
    d[k] = A(k, k) - least;
    for (int j = 0; j < k; ++j) d[k] -= L[k][j] * L[k][j] * d[j];
    if (d[k] < 0.0) return false;
    for (int i = k + 1; i < 3; ++i) {
      double sum = A(i, k);
      for (int j = 0; j < k; ++j) sum -= L[i][j] * L[k][j] * d[j];
      if (d[k] == 0.0 && sum != 0.0) return false;
      L[i][k] = d[k] == 0.0 ? 0.0 : sum / d[k];
    }
  }
  return true;
}

}  // namespace detail

/// The tensor unchanged, if a body of positive masses can have it.
///
/// Asks for finite entries, symmetry, moments that are not negative, and I₃ ≤ I₁ + I₂; each up to
/// 1e-9 of the largest entry, so that measured and rounded values pass.
///
/// @throws InvalidValue with the rule that is broken and the values that break it
inline Eigen::Matrix3d valid_inertia(const Eigen::Matrix3d& inertia) {
  constexpr double slack = 1e-9;
  const auto refuse = [&](const char* rule, const char* remedy) {
    const auto at = [&](int i, int j) { return detail::Phrase(inertia(i, j), 17); };
    detail::throw_invalid_value({"inertia tensor: ", rule, ", but I = [", at(0, 0), ", ", at(0, 1), ", ", at(0, 2), "; ", at(1, 0), ", ", at(1, 1), ", ",
                                 at(1, 2), "; ", at(2, 0), ", ", at(2, 1), ", ", at(2, 2), "]; ", remedy});
  };
  double size = 0.0, skew = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      if (!std::isfinite(inertia(i, j))) refuse("every entry must be finite", "look for a division by zero in what made it");
      size = std::max(size, std::abs(inertia(i, j)));
      skew = std::max(skew, std::abs(inertia(i, j) - inertia(j, i)));
    }
  if (skew > slack * size) {
    refuse("it must be symmetric", "give both off-diagonal entries, with the minus sign: I_xy = I_yx = -sum m x y");
  }
  if (!detail::has_no_moment_below(-slack * size, inertia)) {
    refuse("principal moments must not be negative", "check the sign of the products of inertia and the parallel-axes shift");
  }
  // I₃ ≤ I₁ + I₂ where no moment of ½ tr(I) E − I = ∫ r rᵀ dm is negative.
  const double half = 0.5 * (inertia(0, 0) + inertia(1, 1) + inertia(2, 2));
  Eigen::Matrix3d second;
  for (int k = 0; k < 9; ++k) second.data()[k] = (k % 4 == 0 ? half : 0.0) - inertia.data()[k];
  if (!detail::has_no_moment_below(-0.5 * slack * size, second)) {
    refuse("the largest principal moment must not exceed the sum of the other two",
           "no positive masses give this tensor: check units, axes and the point it is about");
  }
  return inertia;
}

/// Principal moments and axes of an inertia tensor (eigenvalues and eigenvectors of a symmetric matrix).
///
/// @throws InvalidValue as `valid_inertia` does
template <class Matrix3d = Eigen::Matrix3d>  // compiled only where it is called
PrincipalInertia principal_inertia(const std::type_identity_t<Matrix3d>& inertia) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(valid_inertia(inertia));
  PrincipalInertia principal{solver.eigenvalues(), solver.eigenvectors()};
  if (principal.axes.determinant() < 0.0) principal.axes.col(2) *= -1.0;
  return principal;
}

namespace detail {

/// Refuses a mass or length that is negative or no number.
inline void require_sizes(std::string_view body, std::initializer_list<std::pair<std::string_view, double>> sizes) {
  for (const auto& [name, value] : sizes)
    if (!(std::isfinite(value) && value >= 0.0))
      throw InvalidValue("inertia::" + std::string(body) + ": " + std::string(name) + " must be finite and not negative, but it is " + number_text(value) +
                         "; masses and lengths are given as plain sizes");
}
inline void require_order(std::string_view body, double inner, double outer) {
  require_sizes(body, {{"inner radius", inner}, {"outer radius", outer}});
  if (inner <= outer) return;
  throw InvalidValue("inertia::" + std::string(body) + ": the inner radius must not exceed the outer one, but inner = " +
                     number_text(inner) + " and outer = " + number_text(outer) + "; the inner radius comes first");
}

}  // namespace detail

/// Homogeneous bodies: inertia tensors about the centre of mass in the body's own axes .
///
/// The axis of every body of revolution is z; rods lie along x, so that I_zz is the moment of planar problems.
/// All throw InvalidValue for a negative or non-finite mass or length.
namespace inertia {

/// Thin rod of length L along x, about its middle: (0, ML²/12, ML²/12).
inline Eigen::Matrix3d thin_rod(double M, double L) {
  detail::require_sizes("thin_rod", {{"mass", M}, {"length", L}});
  return detail::diagonal(0.0, M * L * L / 12.0, M * L * L / 12.0);
}

/// Thin rod of length L along x, about one end: ML²/3.
inline Eigen::Matrix3d thin_rod_about_end(double M, double L) {
  return inertia_away_from_centre(thin_rod(M, L), M, Eigen::Vector3d(0.5 * L, 0.0, 0.0));
}

/// Hollow cylinder with radii inner ≤ outer and height h along z; inner = 0 is the solid one, inner = outer a tube:
/// (M(3(a² + R²) + h²)/12, same, M(a² + R²)/2) with radii a and R.
inline Eigen::Matrix3d hollow_cylinder(double M, double inner, double outer, double h) {
  detail::require_sizes("hollow_cylinder", {{"mass", M}, {"height", h}});
  detail::require_order("hollow_cylinder", inner, outer);
  const double r2 = inner * inner + outer * outer;
  return detail::diagonal(M * (3.0 * r2 + h * h) / 12.0, M * (3.0 * r2 + h * h) / 12.0, 0.5 * M * r2);
}

/// Solid cylinder of radius R and height h along z: (M(3R² + h²)/12, same, MR²/2).
inline Eigen::Matrix3d cylinder(double M, double R, double h) { return hollow_cylinder(M, 0.0, R, h); }

/// Thin disk of radius R in the xy plane: (MR²/4, MR²/4, MR²/2).
inline Eigen::Matrix3d disk(double M, double R) { return cylinder(M, R, 0.0); }

/// Thin ring (hoop) of radius R in the xy plane: (MR²/2, MR²/2, MR²).
inline Eigen::Matrix3d ring(double M, double R) { return hollow_cylinder(M, R, R, 0.0); }

/// Solid cone with base radius R and height h along z; its centre of mass is ¾h from the apex: (3M(4R² + h²)/80, same, 3MR²/10).
inline Eigen::Matrix3d cone(double M, double R, double h) {
  detail::require_sizes("cone", {{"mass", M}, {"radius", R}, {"height", h}});
  const double side = 3.0 * M * (4.0 * R * R + h * h) / 80.0;
  return detail::diagonal(side, side, 0.3 * M * R * R);
}

/// Solid cone about its apex: (3M(R² + 4h²)/20, same, 3MR²/10), as a spinning top needs it.
inline Eigen::Matrix3d cone_about_apex(double M, double R, double h) {
  return inertia_away_from_centre(cone(M, R, h), M, Eigen::Vector3d(0.0, 0.0, 0.75 * h));
}

/// Solid ellipsoid with semi-axes a, b, c along x, y, z: M/5 (b² + c², c² + a², a² + b²).
inline Eigen::Matrix3d ellipsoid(double M, double a, double b, double c) {
  detail::require_sizes("ellipsoid", {{"mass", M}, {"semi-axis a", a}, {"semi-axis b", b}, {"semi-axis c", c}});
  return detail::diagonal(0.2 * M * (b * b + c * c), 0.2 * M * (c * c + a * a), 0.2 * M * (a * a + b * b));
}

/// Solid sphere of radius R: ⅖MR².
inline Eigen::Matrix3d sphere(double M, double R) { return ellipsoid(M, R, R, R); }

/// Thick spherical shell with radii inner ≤ outer, ⅖M(R⁵ − a⁵)/(R³ − a³) with radii a and R; written so that inner = outer, the thin shell, is no special case.
inline Eigen::Matrix3d hollow_sphere(double M, double inner, double outer) {
  detail::require_sizes("hollow_sphere", {{"mass", M}});
  detail::require_order("hollow_sphere", inner, outer);
  if (outer == 0.0) return detail::diagonal(0.0, 0.0, 0.0);
  const double x = inner / outer;
  // (1 − x⁵)/(1 − x³) with the factor 1 − x divided out
  const double ratio = (1.0 + x * (1.0 + x * (1.0 + x * (1.0 + x)))) / (1.0 + x * (1.0 + x));
  const double moment = 0.4 * M * outer * outer * ratio;
  return detail::diagonal(moment, moment, moment);
}

/// Thin spherical shell of radius R: ⅔MR².
inline Eigen::Matrix3d spherical_shell(double M, double R) { return hollow_sphere(M, R, R); }

/// Solid half ball of radius R with its flat face normal to z; its centre of mass is ⅜R from the face: (83MR²/320, same, ⅖MR²).
inline Eigen::Matrix3d hemisphere(double M, double R) {
  detail::require_sizes("hemisphere", {{"mass", M}, {"radius", R}});
  return detail::diagonal(83.0 / 320.0 * M * R * R, 83.0 / 320.0 * M * R * R, 0.4 * M * R * R);
}

/// Solid torus about z: R from the centre to the middle of the tube, a the radius of the tube: (M(4R² + 5a²)/8, same,
/// M(4R² + 3a²)/4).
inline Eigen::Matrix3d torus(double M, double R, double a) {
  detail::require_sizes("torus", {{"mass", M}, {"radius", R}, {"tube radius", a}});
  const double side = M * (4.0 * R * R + 5.0 * a * a) / 8.0;
  return detail::diagonal(side, side, M * (4.0 * R * R + 3.0 * a * a) / 4.0);
}

/// Box with full edges a, b, c along x, y, z: M/12 (b² + c², c² + a², a² + b²); c = 0 is a rectangular plate.
inline Eigen::Matrix3d box(double M, double a, double b, double c) {
  detail::require_sizes("box", {{"mass", M}, {"edge a", a}, {"edge b", b}, {"edge c", c}});
  return detail::diagonal(M * (b * b + c * c) / 12.0, M * (c * c + a * a) / 12.0, M * (a * a + b * b) / 12.0);
}

}  // namespace inertia
}  // namespace qdot
