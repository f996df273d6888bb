#pragma once
// SPDX-License-Identifier: MIT
//
// Angular velocities of the library's own rotations in closed form.
//
// Of a rotation R(p) by known coordinates p, angles or a quaternion or a vector (mechanics/rotation.hpp), the angular velocity along the body's axes is
// linear in ṗ, and needs neither R nor Ṙ:
//
//     Euler's angles i, j, k      Ω = ȧ R_kᵀ (D e_h + C e_k) + ḃ R_kᵀ e_j + ċ e_k :  e_h, e_j and e_k are the three axes, (D, C) the sine and the cosine
//                                 of the middle angle b where i = k, and the other way round where not
//     quaternion p, N = |p|²      Ω = (2/N) E(p) ṗ
//     vector u, x = |u|²          Ω = c₁ u̇ − c₂ u × u̇ + c₃ (u·u̇) u ,   c_m(x) = Σ (−x)^k/(2k + m)! ,   2 c_m′ = m c_{m+2} − c_{m+1}
//
// So for scalars that derive equations the functions of rotation.hpp return a matrix that remembers what it was made from: numbers that are recorded
// (ad/formula/recording.hpp), and what moves along with them. All others find Ω by [Ω×] = RᵀṘ.

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "qdot/ad/dual_math.hpp"
#include "qdot/ad/unroll.hpp"
#include "qdot/ad/vector.hpp"

namespace qdot::detail {

/// c_m, Stumpff's function of x ≥ 0, as a series; the first term left out is below 1e-21 for x < 1/4.
template <int m, class S>
S stumpff_series(const S& x) {
  S sum(1.0);
  for (int k = 8; k > 0; --k) sum = 1.0 - x * sum / double((2 * k + m - 1) * (2 * k + m));
  double factorial = 1.0;
  for (int k = 2; k <= m; ++k) factorial *= k;
  return sum / factorial;
}

/// The first c_m of x = θ², two to four: sin θ/θ, (1 − cos θ)/θ², (θ − sin θ)/θ³ and (½ − c₂)/θ².
template <class S>
struct Stumpff {
  S c1, c2, c3, c4;
};
template <int count, class S>
Stumpff<S> stumpff(const S& x) {
  using std::cos, std::sin, std::sqrt;
  if (x < 0.25) {
    return {stumpff_series<1>(x), stumpff_series<2>(x), count < 3 ? S(0.0) : stumpff_series<3>(x), count < 4 ? S(0.0) : stumpff_series<4>(x)};
  }
  const S theta = sqrt(x), c1 = sin(theta) / theta, c2 = (1.0 - cos(theta)) / x;
  return {c1, c2, count < 3 ? S(0.0) : S((1.0 - c1) / x), count < 4 ? S(0.0) : S((0.5 - c2) / x)};
}

// 1/x; numbers that are recorded have their own (ad/formula/recording.hpp).
template <class S>
S reciprocal(const S& x) {
  return 1.0 / x;
}

/// V with W V = 1, row by row, where it is asked for. `regular` is zero where there is none.
template <class S, bool is_asked>
struct InverseTurn {
  static constexpr bool is_wanted = is_asked;
  S entries[12], regular;
};
template <class S>
struct InverseTurn<S, false> {
  static constexpr bool is_wanted = false;
};

template <int i, int j, int k>
struct EulerTurn {
  static constexpr int coordinates = 3, remembered = 3;

  template <class S, class Inverse>
  [[gnu::always_inline]] static void angular_velocity(const S* p, const S* v, S* omega, Inverse& inverse) {
    using std::cos, std::sin;
    constexpr int K = k - 1, J = j - 1, H = 3 - J - K, P = (K + 1) % 3, Q = (K + 2) % 3;
    const S sine = sin(p[1]), c = cos(p[1]), S_k = sin(p[2]), C_k = cos(p[2]);
    const S s = i - 1 == (J + 1) % 3 ? S(-sine) : sine;  // the sine in R_jᵀ(b) e_i
    const S along = v[0] * (i == k ? s : c);
    omega[K] = v[0] * (i == k ? c : s) + v[2];
    if constexpr (H == P) {
      omega[P] = along * C_k + v[1] * S_k;
      omega[Q] = v[1] * C_k - along * S_k;
    } else {
      omega[P] = along * S_k + v[1] * C_k;
      omega[Q] = along * C_k - v[1] * S_k;
    }
    if constexpr (Inverse::is_wanted) {
      const S D = i == k ? s : c, C = i == k ? c : s, one_over_D = reciprocal(D);
      for (S& entry : inverse.entries) entry = S(0.0);
      const auto set = [&](int axis, const S& h, const S& e) {  // entries of R_kᵀ e_h and R_kᵀ e_j
        inverse.entries[axis] = one_over_D * h;
        inverse.entries[3 + axis] = e;
        inverse.entries[6 + axis] = -C * (one_over_D * h);
      };
      set(P, H == P ? C_k : S_k, H == P ? S_k : C_k);
      set(Q, H == P ? S(-S_k) : C_k, H == P ? C_k : S(-S_k));
      inverse.entries[6 + K] = S(1.0);
      inverse.regular = D * D;
    }
  }
};

struct QuaternionTurn {
  static constexpr int coordinates = 4, remembered = 4;

  template <class S, class Inverse>
  [[gnu::always_inline]] static void angular_velocity(const S* p, const S* v, S* omega, Inverse& inverse) {
    const S i = 2.0 / (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]);
    omega[0] = i * (p[0] * v[1] - p[1] * v[0] + p[3] * v[2] - p[2] * v[3]);
    omega[1] = i * (p[0] * v[2] - p[2] * v[0] + p[1] * v[3] - p[3] * v[1]);
    omega[2] = i * (p[0] * v[3] - p[3] * v[0] + p[2] * v[1] - p[1] * v[2]);
    if constexpr (Inverse::is_wanted) {  // ½ Eᵀ
      const S E[3][4] = {{-p[1], p[0], p[3], -p[2]}, {-p[2], -p[3], p[0], p[1]}, {-p[3], p[2], -p[1], p[0]}};
      for (int c = 0; c < 4; ++c)
        for (int a = 0; a < 3; ++a) inverse.entries[3 * c + a] = 0.5 * E[a][c];
      inverse.regular = S(1.0);
    }
  }
};

struct VectorTurn {
  static constexpr int coordinates = 3, remembered = 7;  // c₁ to c₄ as well: they ask where x is, and are not to ask twice

  template <class S, class Inverse>
  [[gnu::always_inline]] static void angular_velocity(const S* u, const S* v, S* omega, Inverse& inverse) {
    const S x = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
    const Stumpff<S> of{u[3], u[4], u[5], u[6]};
    const S along = of.c3 * (u[0] * v[0] + u[1] * v[1] + u[2] * v[2]);
    unroll<3>([&](auto a) __attribute__((always_inline)) {
      constexpr int b = (a + 1) % 3, c = (a + 2) % 3;
      omega[a] = of.c1 * v[a] - of.c2 * (u[b] * v[c] - u[c] * v[b]) + along * u[a];
    });
    if constexpr (Inverse::is_wanted) {  // 1 + ½ [u×] + d [u×]²
      const S d = (of.c3 - 2.0 * of.c4) * reciprocal(S(2.0 * of.c2)), rest = 1.0 - d * x;
      for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        const S along_a = d * u[a];
        inverse.entries[3 * a + a] = rest + along_a * u[a];
        inverse.entries[3 * a + b] = along_a * u[b] - 0.5 * u[c];
        inverse.entries[3 * a + c] = along_a * u[c] + 0.5 * u[b];
      }
      inverse.regular = 2.0 * of.c2;
    }
  }
};

// Whether two numbers are one, as far as the compiler sees; whether two duals are, in all parts.
[[gnu::always_inline]] inline bool seen_to_be_one(double x, double y) {
  const bool equal = __builtin_bit_cast(long long, x) == __builtin_bit_cast(long long, y);
  return __builtin_constant_p(equal) && equal;
}
template <class S, int N, class Tag>
bool seen_to_be_one(const Dual<S, N, Tag>& x, const Dual<S, N, Tag>& y) {
  bool same = seen_to_be_one(x.value, y.value);
  for (std::size_t i = 0; i < x.tangent.size(); ++i) same = same && seen_to_be_one(x.tangent[i], y.tangent[i]);
  return same;
}

/// A rotation matrix that remembers its coordinates, and the entries that it was made with.
template <class Turn, class S>
struct KnownRotation : Matrix<S, 3> {
  using Matrix<S, 3>::operator=;
  S from[Turn::remembered];
  S made[9];

  /// Whether its entries are seen to be those that it was made with.
  bool is_as_made() const {
    bool same = true;
    for (int k = 0; k < 9; ++k) same = same && seen_to_be_one(this->data()[k], made[k]);
    return same;
  }
};

/// Which scalars remember rotations. A function seen_to_be_one(x, y) says whether two of them are one number.
template <class S>
inline constexpr bool remembers_rotations = requires { requires S::remembers_rotations; };

/// What the functions of rotation.hpp return.
template <class Turn, class S>
using RotationBy = std::conditional_t<remembers_rotations<S>, KnownRotation<Turn, S>, Matrix<S, 3>>;

// Keeps the coordinates and the entries of R, if R is a matrix that remembers.
template <class S, class... From>
[[gnu::always_inline]] inline void remember(Matrix<S, 3>&, const From&...) {}
template <class Turn, class S, class... From>
[[gnu::always_inline]] inline void remember(KnownRotation<Turn, S>& R, const From&... from) {
  int k = 0;
  ((R.from[k++] = from), ...);
  std::copy_n(R.data(), 9, R.made);
}

template <class R>
inline constexpr bool is_known_rotation = false;
template <class Turn, class S>
inline constexpr bool is_known_rotation<KnownRotation<Turn, S>> = true;

/// Ω of a known rotation, where follow(x) is the value and the rate of a number that it was made from.
template <class S, class Turn, class Number, class Follow>
[[gnu::always_inline]] inline Vector<S, 3> known_angular_velocity(const KnownRotation<Turn, Number>& R, const Follow& follow) {
  S p[Turn::remembered], v[Turn::coordinates];
  unroll<Turn::remembered>([&](auto c) __attribute__((always_inline)) {
    const auto both = follow(R.from[c]);
    p[c] = both.value;
    if constexpr (c < Turn::coordinates) v[c] = both.rate;
  });
  Vector<S, 3> omega;
  constexpr bool is_noted = requires { note_turning(p, p, v, Turn::coordinates, p, *p); };
  InverseTurn<S, is_noted> inverse;
  Turn::angular_velocity(p, v, omega.data(), inverse);
  if constexpr (is_noted) note_turning(omega.data(), p, v, Turn::coordinates, inverse.entries, inverse.regular);
  return omega;
}

}  // namespace qdot::detail
