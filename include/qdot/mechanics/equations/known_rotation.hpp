#pragma once
// SPDX-License-Identifier: MIT
//
// Angular velocities of the library's own rotations in closed form.
//
// Of a rotation R(p) by known coordinates p, angles or a quaternion or a vector (mechanics/rotation.hpp), the angular velocity along the body's axes is
// linear in ṗ, and nobody needs the nine entries of R and Ṙ for it:
//
//     Ω = W(p) ṗ ,     Ω̇ = W p̈ + Ẇ ṗ ,     ∂Ω/∂p − Ẇ = Ω × W    (column by column).
//
// The last is what [Ω×] = RᵀṘ says of a variation, δΩ = (W δp)˙ + Ω × W δp. W is inverted as easily, p̈ = W⁻¹ (Ω̇ − Ẇṗ), but at the poles of
// angles and vectors:
//
//     Euler's angles i, j, k      W = R_kᵀ (D e_h + C e_k , e_j , e_k) :  e_h, e_j and e_k are the three axes, (D, C) the sine and the cosine of the middle
//                                 angle b where i = k, and the other way round where not. D = 0 is the pole.
//     quaternion p, N = |p|²      Ω = (2/N) E(p) ṗ ,  E Eᵀ = N ,  E p = 0 ,  E(ṗ) ṗ = 0
//     vector u, x = |u|²          Ω = a u̇ − b u × u̇ + c (u·u̇) u ,   W⁻¹ = 1 + ½ [u×] + d [u×]² ,  d = (c − 2 c₄)/2b
//
// where a, b, c, c₄ and c₅ are Σ (−x)^k/(2k + m)! of m = 1 to 5, and 2 c_m′ = m c_{m+2} − c_{m+1}.
//
// So the words of rotation.hpp return, where it is asked of them by the scalar, a matrix that remembers what it was made from. All functions here are of
// plain numbers: what has derivatives is put together from W by those who ask.

#include <cmath>

#include "qdot/ad/lagrange/euler_lagrange_math.hpp"
#include "qdot/ad/unroll.hpp"
#include "qdot/ad/vector.hpp"

namespace qdot::detail {

// The angular velocity of a rotation by `count` coordinates, along the body's axes.
template <int count>
struct Turning {
  double W[3][count], omega[3], bend[3];  // bend: Ω̇ without accelerations
  double inverse[count][3];               // W · inverse · scale = 1
  double regular;                         // the square of the smallest singular value of W beside the others, about
};

// Σ (−x)^k/(2k + m)!; the first term left out is below 1e-21 for x < 1/4.
template <int m>
inline double cosine_like_series(double x) {
  double sum = 1.0;
  for (int k = 8; k > 0; --k) sum = 1.0 - x * sum / double((2 * k + m - 1) * (2 * k + m));
  for (int k = 2; k <= m; ++k) sum /= k;
  return sum;
}

// c₁ = sin θ/θ and c₂ = (1 − cos θ)/θ² of x = θ². A function of its own that the compiler need not call twice for the same x.
[[gnu::const, gnu::noinline]] inline Pair sine_and_cosine_quotients(double x) {
  if (x < 0.25) return Pair{cosine_like_series<1>(x), cosine_like_series<2>(x)};
  const double theta = std::sqrt(x);
  double sine, cosine;
  sine_and_cosine(theta, &sine, &cosine);
  return Pair{sine / theta, (1.0 - cosine) / x};
}

// c₁ to c₆.
struct CosineLike {
  double c[7];
  [[gnu::always_inline]] explicit CosineLike(double x) {
    const Pair low = sine_and_cosine_quotients(x);
    c[0] = 0.0, c[1] = low[0], c[2] = low[1];
    if (x < 0.25) {
      const Pair high = high_ones(x);
      c[5] = high[0], c[6] = high[1];
      c[3] = 1.0 / 6.0 - x * c[5], c[4] = 1.0 / 24.0 - x * c[6];
    } else {
      const double i = 1.0 / x;
      c[3] = (1.0 - c[1]) * i, c[4] = (0.5 - c[2]) * i;
      c[5] = (1.0 / 6.0 - c[3]) * i, c[6] = (1.0 / 24.0 - c[4]) * i;
    }
  }
  // c_m and its derivatives with x.
  template <int m>
  [[gnu::always_inline]] double slope() const { return 0.5 * (m * c[m + 2] - c[m + 1]); }
  template <int m>
  [[gnu::always_inline]] double curvature() const { return 0.5 * (m * slope<m + 2>() - slope<m + 1>()); }

 private:
  [[gnu::const, gnu::noinline]] static Pair high_ones(double x) { return Pair{cosine_like_series<5>(x), cosine_like_series<6>(x)}; }
};

// f ← R_axisᵀ f of a turn by the angle with this sine and cosine.
template <int axis>
[[gnu::always_inline]] inline void turn_back(double sine, double cosine, double (&f)[3]) {
  constexpr int i = (axis + 1) % 3, j = (axis + 2) % 3;
  const double x = f[i], y = f[j];
  f[i] = cosine * x + sine * y;
  f[j] = cosine * y - sine * x;
}

template <int i, int j, int k>
struct EulerTurn {
  static constexpr int coordinates = 3;
  static constexpr double scale = 1.0;
  static constexpr int L = i - 1, J = j - 1, K = k - 1, H = 3 - J - K;
  // Whether entry (axis, c) of W may be other than zero.
  static constexpr bool moves(int axis, int c) { return c == 0 || (c == 1 ? axis != K : axis == K); }

  [[gnu::always_inline]] static Turning<3> at(const double* p, const double* v) {
    constexpr double sign = L == (J + 1) % 3 ? -1.0 : 1.0;  // of the sine in R_jᵀ(b) e_i
    const double s = sign * shared_sine(p[1]), c = shared_cosine(p[1]), S = shared_sine(p[2]), Co = shared_cosine(p[2]);
    const double D = L == K ? s : c, C = L == K ? c : s;            // and their derivatives with b:
    const double D1 = L == K ? sign * c : -sign * s, C1 = L == K ? -sign * s : sign * c;
    // R_kᵀ e_h and R_kᵀ e_j, in the plane of axes P and Q.
    constexpr int P = (K + 1) % 3, Q = (K + 2) % 3;
    double h[3], g[3];
    h[K] = g[K] = 0.0;
    h[P] = H == P ? Co : S, h[Q] = H == P ? -S : Co;
    g[P] = J == P ? Co : S, g[Q] = J == P ? -S : Co;
    Turning<3> t;
    const double along = v[0] * D, both = v[0] * v[1];
    unroll<3>([&](auto a) __attribute__((always_inline)) {
      t.W[a][0] = a == K ? C : D * h[a];
      t.W[a][1] = g[a];
      t.W[a][2] = a == K ? 1.0 : 0.0;
      t.omega[a] = a == K ? v[0] * C + v[2] : along * h[a] + v[1] * g[a];
    });
    t.bend[K] = both * C1;
    t.bend[P] = both * D1 * h[P] + v[2] * t.omega[Q];  // −ċ e_k × Ω in the plane
    t.bend[Q] = both * D1 * h[Q] - v[2] * t.omega[P];
    const double i_D = 1.0 / D;
    unroll<3>([&](auto a) __attribute__((always_inline)) {
      t.inverse[0][a] = a == K ? 0.0 : i_D * h[a];
      t.inverse[1][a] = g[a];
      t.inverse[2][a] = a == K ? 1.0 : -C * (i_D * h[a]);
    });
    t.regular = D * D;
    return t;
  }
  // f ← Rᵀ f
  [[gnu::always_inline]] static void turn_into_body(const double* p, double (&f)[3]) {
    turn_back<L>(shared_sine(p[0]), shared_cosine(p[0]), f);
    turn_back<J>(shared_sine(p[1]), shared_cosine(p[1]), f);
    turn_back<K>(shared_sine(p[2]), shared_cosine(p[2]), f);
  }
};

struct QuaternionTurn {
  static constexpr int coordinates = 4;
  static constexpr double scale = 0.5;
  static constexpr bool moves(int, int) { return true; }

  [[gnu::always_inline]] static Turning<4> at(const double* p, const double* v) {
    const double N = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3], i = 2.0 / N;
    const double E[3][4] = {{-p[1], p[0], p[3], -p[2]}, {-p[2], -p[3], p[0], p[1]}, {-p[3], p[2], -p[1], p[0]}};
    const double shrinks = -i * (p[0] * v[0] + p[1] * v[1] + p[2] * v[2] + p[3] * v[3]);
    Turning<4> t;
    unroll<3>([&](auto a) __attribute__((always_inline)) {
      t.omega[a] = i * (E[a][0] * v[0] + E[a][1] * v[1] + E[a][2] * v[2] + E[a][3] * v[3]);
      t.bend[a] = shrinks * t.omega[a];
      unroll<4>([&](auto c) __attribute__((always_inline)) {
        t.W[a][c] = i * E[a][c];
        t.inverse[c][a] = E[a][c];
      });
    });
    t.regular = 1.0;
    return t;
  }
  // Rᵀ f = f + (2/N) (u × (u × f) − w u × f) ,  p = (w, u)
  [[gnu::always_inline]] static void turn_into_body(const double* p, double (&f)[3]) {
    const double N = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3], i = 2.0 / N;
    const double* const u = p + 1;
    const double x[3] = {u[1] * f[2] - u[2] * f[1], u[2] * f[0] - u[0] * f[2], u[0] * f[1] - u[1] * f[0]};
    unroll<3>([&](auto a) __attribute__((always_inline)) {
      constexpr int b = (a + 1) % 3, c = (a + 2) % 3;
      f[a] += i * (u[b] * x[c] - u[c] * x[b] - p[0] * x[a]);
    });
  }
};

struct VectorTurn {
  static constexpr int coordinates = 3;
  static constexpr double scale = 1.0;
  static constexpr bool moves(int, int) { return true; }

  [[gnu::always_inline]] static Turning<3> at(const double* u, const double* v) {
    const double x = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
    const CosineLike of(x);
    const double a = of.c[1], b = of.c[2], c = of.c[3];
    const double s = u[0] * v[0] + u[1] * v[1] + u[2] * v[2], speed = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    const double da = 2.0 * s * of.slope<1>(), db = 2.0 * s * of.slope<2>(), dc = 2.0 * s * of.slope<3>();
    const double d = (c - 2.0 * of.c[4]) / (2.0 * b), rest = 1.0 - d * x, along = dc * s + c * speed, too = da + c * s, cs = c * s;
    Turning<3> t;
    unroll<3>([&](auto k) __attribute__((always_inline)) {
      constexpr int l = (k + 1) % 3, m = (k + 2) % 3;
      const double cross = u[l] * v[m] - u[m] * v[l], cu = c * u[k], du = d * u[k];
      t.omega[k] = a * v[k] - b * cross + cs * u[k];
      t.bend[k] = too * v[k] - db * cross + along * u[k];
      t.W[k][k] = a + cu * u[k];
      t.W[k][l] = cu * u[l] + b * u[m];
      t.W[k][m] = cu * u[m] - b * u[l];
      t.inverse[k][k] = rest + du * u[k];
      t.inverse[k][l] = du * u[l] - 0.5 * u[m];
      t.inverse[k][m] = du * u[m] + 0.5 * u[l];
    });
    t.regular = 2.0 * b;
    return t;
  }
  // Rᵀ f = f − a u × f + b u × (u × f)
  [[gnu::always_inline]] static void turn_into_body(const double* u, double (&f)[3]) {
    const double x[3] = {u[1] * f[2] - u[2] * f[1], u[2] * f[0] - u[0] * f[2], u[0] * f[1] - u[1] * f[0]};
    const Pair ab = sine_and_cosine_quotients(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    unroll<3>([&](auto k) __attribute__((always_inline)) {
      constexpr int l = (k + 1) % 3, m = (k + 2) % 3;
      f[k] += ab[1] * (u[l] * x[m] - u[m] * x[l]) - ab[0] * x[k];
    });
  }
};

// A rotation matrix that remembers its coordinates. Who asks for these sees first whether its entries still are those that it was made with
// (body_rates.hpp).
template <class Turn, class S>
struct KnownRotation : Matrix<S, 3> {
  using Matrix<S, 3>::operator=;
  S from[Turn::coordinates];

  // Entry by entry: Clang copies what GCC makes where it is wanted, and sees through no loop of copies.
  KnownRotation() = default;
  [[gnu::always_inline]] KnownRotation(const KnownRotation& o) : Matrix<S, 3>() {
    unroll<9>([&](auto k) __attribute__((always_inline)) { this->data()[k] = o.data()[k]; });
    unroll<Turn::coordinates>([&](auto c) __attribute__((always_inline)) { from[c] = o.from[c]; });
  }
  KnownRotation& operator=(const KnownRotation&) = default;
};

// What the words of rotation.hpp return.
template <class Turn, class S>
struct RotationOf {
  using type = Matrix<S, 3>;
};
template <class Turn, class S>
  requires S::remembers_rotations
struct RotationOf<Turn, S> {
  using type = KnownRotation<Turn, S>;
};

template <class Turn, class S>
using RotationBy = typename RotationOf<Turn, S>::type;

// R with the coordinates beside it where they are asked for.
template <class S, class... From>
[[gnu::always_inline]] inline void remember(Matrix<S, 3>&, const From&...) {}
template <class Turn, class S, class... From>
[[gnu::always_inline]] inline void remember(KnownRotation<Turn, S>& R, const From&... from) {
  int k = 0;
  ((R.from[k++] = from), ...);
}

template <class R>
inline constexpr bool is_known_rotation = false;
template <class Turn, class S>
inline constexpr bool is_known_rotation<KnownRotation<Turn, S>> = true;

}  // namespace qdot::detail
