#pragma once
// SPDX-License-Identifier: MIT
//
// Scenes with their effects as an expert derives and writes them, the baselines of `qdot bench scenes`. Forces are added to r. With
// constraints J q̈ = γ, J and γ are derived by hand and
//
//     M q̈ = r + Jᵀλ ,    (J M⁻¹ Jᵀ) λ = γ − J M⁻¹ r
//
// is written out, its zeros left out; q̈ is followed by λ. What depends on parameters alone is computed once, as a member, and divided by
// beforehand. The members are read when a function is called, like the parameters of the scene. Baselines of so few operations would lose much
// of them if the compiler knew that a mass is 1.

#include <cmath>

#include "bench/hand_derived.hpp"

namespace qdot::bench {

/// The chain of unit masses with viscous damping of all joints or none, and with its tip on the line x = 0 or free:
/// J_i = cos θ_i, γ = Σ sin θ_i θ̇_i².
template <int n, bool damped, bool guided>
struct ChainSceneByHand {
  void operator()(const double* q, const double* v, double* a) const {
    constexpr double damping = 0.1;
    ShortChain<n> chain(q, v);
    if constexpr (damped) unroll<n>([&](auto i) __attribute__((always_inline)) { chain.r[i] -= damping * v[i]; });
    if constexpr (guided) {
      double J[n], inverse[n], gamma = 0.0, schur = 0.0;
      unroll<n>([&](auto i) __attribute__((always_inline)) {
        J[i] = chain.c[i];
        gamma += chain.s[i] * chain.w[i];
      });
      factor<n>(chain.M, inverse);
      go_forward<n>(chain.M, chain.r);
      go_forward<n>(chain.M, J);
      unroll<n>([&](auto i) __attribute__((always_inline)) {
        const double scaled = J[i] * inverse[i];
        schur += scaled * J[i];
        gamma -= scaled * chain.r[i];
      });
      const double lambda = gamma / schur;
      unroll<n>([&](auto i) __attribute__((always_inline)) { chain.r[i] = (chain.r[i] + lambda * J[i]) * inverse[i]; });
      go_back<n>(chain.M, chain.r);
      a[n] = lambda;
    } else {
      detail::solved_in_place<n>(chain.M, chain.r, 0.0);
    }
    unroll<n>([&](auto i) __attribute__((always_inline)) { a[i] = chain.r[i]; });
  }
};

/// Cart and pole: (M+m) ẍ + m l cos θ θ̈ = m l sin θ θ̇² + F,  m l cos θ ẍ + m l² θ̈ = −m g l sin θ + τ, by Cramer's rule. F is a motor's
/// k i and a friction that fades below v₀, τ a damping.
template <bool motor, bool friction>
struct CartpoleByHand {
  double M = 2.0, m = 1.0, l = 1.0, g = 9.81, k = 2.0, current = 1.5, F = 1.0, v0 = 1e-3, c = 0.1;
  double ml = m * l, per_l = 1.0 / l, per_v0 = 1.0 / v0, c_per_ml = c / (m * l);
  void operator()(const double* q, const double* v, double* a) const {
    const double s = shared_sine(q[1]), co = shared_cosine(q[1]);
    double u = ml * s * v[1] * v[1];
    double w = -g * s;  // over m l
    if constexpr (motor) u += k * current;
    if constexpr (friction) {
      u -= F * std::tanh(v[0] * per_v0);
      w -= c_per_ml * v[1];
    }
    a[0] = (u - m * co * w) / (M + m * s * s);
    a[1] = (w - co * a[0]) * per_l;
  }
};

/// A bob on a rod, x and y: J = (x, y), γ = −v². With drag −b |v| v.
template <bool drag>
struct CartesianPendulumByHand {
  double m = 1.0, g = 9.81, b = 0.1, per_m = 1.0 / m;
  void operator()(const double* q, const double* v, double* a) const {
    const double v2 = v[0] * v[0] + v[1] * v[1];
    double rx = 0.0, ry = -m * g;
    if constexpr (drag) {
      const double k = b * std::sqrt(v2);
      rx -= k * v[0];
      ry -= k * v[1];
    }
    const double lambda = -(m * v2 + q[0] * rx + q[1] * ry) / (q[0] * q[0] + q[1] * q[1]);
    a[0] = (rx + lambda * q[0]) * per_m;
    a[1] = (ry + lambda * q[1]) * per_m;
    a[2] = lambda;
  }
};

/// A bob on a taut rope: J = −(x, y)/ρ, γ = (v² − ρ̇²)/ρ.
struct TautRopeByHand {
  double m = 1.0, g = 9.81, per_m = 1.0 / m;
  void operator()(const double* q, const double* v, double* a) const {
    const double i = 1.0 / std::sqrt(q[0] * q[0] + q[1] * q[1]);
    const double x = q[0] * i, y = q[1] * i, rate = x * v[0] + y * v[1];
    const double lambda = m * ((v[0] * v[0] + v[1] * v[1] - rate * rate) * i - g * y);
    const double pull = lambda * per_m;
    a[0] = -pull * x;
    a[1] = -g - pull * y;
    a[2] = lambda;
  }
};

/// Two constraints on two angles that inertia couples and a coordinate on its own,
///
///     ┌ A  B  0 ┐       ┌ r₀ ┐       ┌ J₀₀ J₀₁ J₀₂ ┐
///     │ B  C  0 │ q̈ =   │ r₁ │ + Jᵀλ,  │             │ q̈ = γ .
///     └ 0  0 1/d┘       └ r₂ ┘       └ J₁₀ J₁₁ J₁₂ ┘
[[gnu::always_inline]] inline void solve_loop(double A, double B, double C, double d, const double* r, const double (&J)[2][3], const double* gamma,
                                              double* a) {
  const double determinant = 1.0 / (A * C - B * B);
  const double u = A * determinant, v = -B * determinant, w = C * determinant;
  const auto x = [&](const double* f) __attribute__((always_inline)) { return w * f[0] + v * f[1]; };
  const auto y = [&](const double* f) __attribute__((always_inline)) { return v * f[0] + u * f[1]; };
  const double X[2] = {x(J[0]), x(J[1])}, Y[2] = {y(J[0]), y(J[1])}, Z[2] = {d * J[0][2], d * J[1][2]};
  const double S00 = J[0][0] * X[0] + J[0][1] * Y[0] + J[0][2] * Z[0];
  const double S10 = J[1][0] * X[0] + J[1][1] * Y[0] + J[1][2] * Z[0];
  const double S11 = J[1][0] * X[1] + J[1][1] * Y[1] + J[1][2] * Z[1];
  const double g0 = gamma[0] - X[0] * r[0] - Y[0] * r[1] - Z[0] * r[2];
  const double g1 = gamma[1] - X[1] * r[0] - Y[1] * r[1] - Z[1] * r[2];
  const double s = 1.0 / (S00 * S11 - S10 * S10);
  const double l0 = (S11 * g0 - S10 * g1) * s, l1 = (S00 * g1 - S10 * g0) * s;
  a[0] = x(r) + X[0] * l0 + X[1] * l1;
  a[1] = y(r) + Y[0] * l0 + Y[1] * l1;
  a[2] = d * r[2] + Z[0] * l0 + Z[1] * l1;
  a[3] = l0;
  a[4] = l1;
}

/// Four-bar linkage, J and γ of its loop a e^{iθ₁} + b e^{iθ₂} = d + c e^{iθ₃}; with a torque on the crank.
template <bool driven>
struct FourBarByHand {
  double a = 0.3, b = 0.9, c = 0.7, mu = 1.0, g = 9.81, torque = 1.0;
  double A = mu * (a * a * a / 3.0 + b * a * a), C = mu * b * b * b / 3.0, d = 3.0 / (mu * c * c * c), coupling = 0.5 * mu * a * b * b;
  double G0 = mu * g * a * (0.5 * a + b), G1 = 0.5 * mu * g * b * b, G2 = 0.5 * mu * g * c * c;
  void operator()(const double* q, const double* v, double* out) const {
    const double s0 = shared_sine(q[0]), c0 = shared_cosine(q[0]);
    const double s1 = shared_sine(q[1]), c1 = shared_cosine(q[1]);
    const double s2 = shared_sine(q[2]), c2 = shared_cosine(q[2]);
    const double w0 = v[0] * v[0], w1 = v[1] * v[1], w2 = v[2] * v[2];
    const double sine = coupling * (s0 * c1 - c0 * s1);
    const double r[3] = {-sine * w1 - G0 * c0 + (driven ? torque : 0.0), sine * w0 - G1 * c1, -G2 * c2};
    const double ac = a * c0, as = a * s0, bc = b * c1, bs = b * s1, cc = c * c2, cs = c * s2;
    const double J[2][3] = {{-as, -bs, cs}, {ac, bc, -cc}};
    const double gamma[2] = {ac * w0 + bc * w1 - cc * w2, as * w0 + bs * w1 - cs * w2};
    solve_loop(A, coupling * (c0 * c1 + s0 * s1), C, d, r, J, gamma, out);
  }
};

/// Slider and crank, J and γ of r cos θ + l cos β = x, r sin θ = l sin β.
struct SliderCrankByHand {
  double r = 0.3, l = 0.8, m1 = 1.0, m2 = 1.0, m3 = 2.0;
  double A = (m1 / 3.0 + m2) * r * r, C = m2 * l * l / 3.0, d = 1.0 / m3, coupling = 0.5 * m2 * r * l;
  void operator()(const double* q, const double* v, double* out) const {
    const double s0 = shared_sine(q[0]), c0 = shared_cosine(q[0]);
    const double s1 = shared_sine(q[1]), c1 = shared_cosine(q[1]);
    const double w0 = v[0] * v[0], w1 = v[1] * v[1];
    const double sine = coupling * (s0 * c1 + c0 * s1);
    const double f[3] = {-sine * w1, -sine * w0, 0.0};
    const double J[2][3] = {{-r * s0, -l * s1, -1.0}, {r * c0, -l * c1, 0.0}};
    const double gamma[2] = {r * c0 * w0 + l * c1 * w1, r * s0 * w0 - l * s1 * w1};
    solve_loop(A, coupling * (s0 * s1 - c0 * c1), C, d, f, J, gamma, out);
  }
};

/// A hoop that rolls down an incline, J = (1, −R), γ = 0.
struct RollingHoopByHand {
  double m = 1.0, R = 0.2, kappa = 1.0, alpha = 0.3, g = 9.81;
  double fall = g * std::sin(alpha), per_m = 1.0 / m, R_per_I = 1.0 / (kappa * m * R), schur = 1.0 / (per_m + R * R_per_I);
  void operator()(const double*, const double*, double* a) const {
    const double lambda = -fall * schur;
    a[0] = fall + lambda * per_m;
    a[1] = -R_per_I * lambda;
    a[2] = lambda;
  }
};

/// Chaplygin's sleigh: along the blade a ω², across it γ = ω (ẋ cos θ + ẏ sin θ), and (I + m a²) ω̇ = −m a γ.
struct ChaplyginSleighByHand {
  double m = 1.0, I = 0.3, d = 0.5, d_per_I = d / I, schur = 1.0 / (1.0 / m + d * d_per_I);
  void operator()(const double* q, const double* v, double* a) const {
    const double s = shared_sine(q[2]), c = shared_cosine(q[2]);
    const double gamma = v[2] * (v[0] * c + v[1] * s), along = d * v[2] * v[2];
    const double lambda = gamma * schur;
    a[0] = along * c - gamma * s;
    a[1] = along * s + gamma * c;
    a[2] = -d_per_I * lambda;
    a[3] = lambda;
  }
};

/// A block on a spring that slides forward with dry friction.
struct SlidingBlockByHand {
  double m = 1.0, k = 4.0, F = 0.3, per_m = 1.0 / m;
  void operator()(const double* q, const double*, double* a) const { a[0] = (-k * q[0] - F) * per_m; }
};

/// Two unit masses on unit rods, and a spring-damper from the middle of the upper rod to the lower mass: ℓ² = 5/4 + cos(θ₁ − θ₂).
struct SprungDoublePendulumByHand {
  double g = 9.81, k = 20.0, rest = 1.2, c = 0.5;
  void operator()(const double* q, const double* v, double* a) const {
    const double s0 = shared_sine(q[0]), c0 = shared_cosine(q[0]);
    const double s1 = shared_sine(q[1]), c1 = shared_cosine(q[1]);
    const double co = c0 * c1 + s0 * s1, s = s0 * c1 - c0 * s1;
    const double length = std::sqrt(1.25 + co), slope = -0.5 * s / length;  // ∂ℓ/∂θ₁ = −∂ℓ/∂θ₂
    const double pull = (k * (length - rest) + c * slope * (v[0] - v[1])) * slope;
    const double u = -v[1] * v[1] * s - 2.0 * g * s0 - pull;
    const double w = v[0] * v[0] * s - g * s1 + pull;
    const double i = 1.0 / (2.0 - co * co);
    a[0] = (u - co * w) * i;
    a[1] = (2.0 * w - co * u) * i;
  }
};

/// Moments of inertia, and a torque constant in space, of the body in space below.
struct TurningBody {
  double A = 1.0, B = 2.0, C = 2.5;
  double torque[3] = {0.3, -0.2, 0.5};
  double per_A = 1.0 / A, per_B = 1.0 / B, per_C = 1.0 / C;

  /// Ω̇ of Euler's equations with the torque t along the body's axes.
  [[gnu::always_inline]] void euler(const double* w, const double* t, double* rate) const {
    rate[0] = (t[0] - (C - B) * w[1] * w[2]) * per_A;
    rate[1] = (t[1] - (A - C) * w[2] * w[0]) * per_B;
    rate[2] = (t[2] - (B - A) * w[0] * w[1]) * per_C;
  }
};

/// A free body by a quaternion p of any length: Ω = 2 G(p) ṗ/|p|², p·p̈ = −|ṗ|².
template <bool driven>
struct QuaternionBodyByHand : TurningBody {
  void operator()(const double* p, const double* v, double* a) const {
    const double N = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3], i = 1.0 / N;
    const double speed = v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3];
    const double growth = 2.0 * i * (p[0] * v[0] + p[1] * v[1] + p[2] * v[2] + p[3] * v[3]);
    const double w[3] = {2.0 * i * (p[0] * v[1] - p[1] * v[0] + p[3] * v[2] - p[2] * v[3]),
                         2.0 * i * (p[0] * v[2] - p[2] * v[0] + p[1] * v[3] - p[3] * v[1]),
                         2.0 * i * (p[0] * v[3] - p[3] * v[0] + p[2] * v[1] - p[1] * v[2])};
    double t[3] = {0.0, 0.0, 0.0}, y[3];
    if constexpr (driven) {  // Rᵀτ = τ + 2 (u × (u × τ) − w u × τ)/|p|², p = (w, u)
      const double *f = torque, *u = p + 1;
      const double x[3] = {u[1] * f[2] - u[2] * f[1], u[2] * f[0] - u[0] * f[2], u[0] * f[1] - u[1] * f[0]};
      const double k = 2.0 * i;
      t[0] = f[0] + k * (u[1] * x[2] - u[2] * x[1] - p[0] * x[0]);
      t[1] = f[1] + k * (u[2] * x[0] - u[0] * x[2] - p[0] * x[1]);
      t[2] = f[2] + k * (u[0] * x[1] - u[1] * x[0] - p[0] * x[2]);
    }
    euler(w, t, y);
    for (int k = 0; k < 3; ++k) y[k] = 0.5 * (y[k] + growth * w[k]);
    const double along = -speed * i;
    a[0] = along * p[0] - p[1] * y[0] - p[2] * y[1] - p[3] * y[2];
    a[1] = along * p[1] + p[0] * y[0] - p[3] * y[1] + p[2] * y[2];
    a[2] = along * p[2] + p[3] * y[0] + p[0] * y[1] - p[1] * y[2];
    a[3] = along * p[3] - p[2] * y[0] + p[1] * y[1] + p[0] * y[2];
  }
};

/// The body by a quaternion with the constraint ½ (|p|² − 1) = 0, whose multiplier is zero.
template <bool driven>
struct UnitQuaternionBodyByHand {
  QuaternionBodyByHand<driven> body;
  void operator()(const double* p, const double* v, double* a) const {
    body(p, v, a);
    a[4] = 0.0;
  }
};

/// A free body by its rotation vector u, θ = |u|, away from u = 0: with a = sin θ/θ, b = (1 − cos θ)/θ², c = (1 − a)/θ²
/// Ω = a u̇ − b u × u̇ + c (u·u̇) u, solved for ü by its inverse E + ½ [u×] + d [u×]², d = (1 − a/2b)/θ².
template <bool driven>
struct RotationVectorBodyByHand : TurningBody {
  void operator()(const double* u, const double* v, double* out) const {
    const double x = u[0] * u[0] + u[1] * u[1] + u[2] * u[2], theta = std::sqrt(x);
    const double sine = shared_sine(theta), cosine = shared_cosine(theta);
    const double of_theta = 1.0 / theta, i = of_theta * of_theta;
    const double a = sine * of_theta, b = (1.0 - cosine) * i, c = (1.0 - a) * i;
    const double s = u[0] * v[0] + u[1] * v[1] + u[2] * v[2], speed = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    const double cross[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    double w[3], t[3] = {0.0, 0.0, 0.0}, y[3];
    for (int k = 0; k < 3; ++k) w[k] = a * v[k] - b * cross[k] + c * s * u[k];
    if constexpr (driven) {  // Rᵀτ = τ − a u × τ + b u × (u × τ)
      const double* f = torque;
      const double uf = u[0] * f[0] + u[1] * f[1] + u[2] * f[2];
      const double r[3] = {u[1] * f[2] - u[2] * f[1], u[2] * f[0] - u[0] * f[2], u[0] * f[1] - u[1] * f[0]};
      for (int k = 0; k < 3; ++k) t[k] = cosine * f[k] - a * r[k] + b * uf * u[k];
    }
    euler(w, t, y);
    const double da = s * (c - b), db = s * (a - 2.0 * b) * i, dc = s * (b - 3.0 * c) * i, along = dc * s + c * speed, too = da + c * s;
    for (int k = 0; k < 3; ++k) y[k] -= too * v[k] - db * cross[k] + along * u[k];
    const double d = (1.0 - 0.5 * a / b) * i, uy = u[0] * y[0] + u[1] * y[1] + u[2] * y[2], rest = 1.0 - d * x;
    out[0] = rest * y[0] + 0.5 * (u[1] * y[2] - u[2] * y[1]) + d * uy * u[0];
    out[1] = rest * y[1] + 0.5 * (u[2] * y[0] - u[0] * y[2]) + d * uy * u[1];
    out[2] = rest * y[2] + 0.5 * (u[0] * y[1] - u[1] * y[0]) + d * uy * u[2];
  }
};

/// A free body by Euler's angles 3-1-3, (φ, ϑ, ψ).
template <bool driven>
struct EulerAnglesBodyByHand : TurningBody {
  void operator()(const double* q, const double* v, double* a) const {
    const double s = shared_sine(q[1]), c = shared_cosine(q[1]);
    const double sp = shared_sine(q[2]), cp = shared_cosine(q[2]);
    const double w[3] = {v[0] * s * sp + v[1] * cp, v[0] * s * cp - v[1] * sp, v[0] * c + v[2]};
    double t[3] = {0.0, 0.0, 0.0}, y[3];
    if constexpr (driven) {
      const double sf = shared_sine(q[0]), cf = shared_cosine(q[0]);
      const double node = cf * torque[0] + sf * torque[1], across = cf * torque[1] - sf * torque[0];
      const double up = c * across + s * torque[2];
      t[0] = cp * node + sp * up;
      t[1] = cp * up - sp * node;
      t[2] = c * torque[2] - s * across;
    }
    euler(w, t, y);
    accelerations(s, c, sp, cp, v, y, a);
  }

  /// The second derivatives of the angles from Ω̇ = y.
  [[gnu::always_inline]] static void accelerations(double s, double c, double sp, double cp, const double* v, const double* y, double* a) {
    a[0] = (sp * y[0] + cp * y[1] - v[1] * (v[0] * c - v[2])) / s;
    a[1] = cp * y[0] - sp * y[1] - v[0] * v[2] * s;
    a[2] = y[2] - a[0] * c + v[0] * v[1] * s;
  }
};

/// Two such bodies on a ball joint on the axes e of both, seen from their common centre of mass. d = α e₁ + β e₂ leads from one centre to the
/// other, and m is the reduced mass. With u = Ω̇ × e + Ω × (Ω × e), each in its own body's axes, and Q = R₁ᵀR₂
///
///     I Ω̇₁ + Ω₁ × I Ω₁ + m α e × (α u₁ + β Q u₂) = 0 ,      I Ω̇₂ + Ω₂ × I Ω₂ + m β e × (α Qᵀu₁ + β u₂) = 0 .
struct JoinedBodiesByHand : TurningBody {
  double m = 0.8, alpha = 0.6, beta = 0.9;
  void operator()(const double* q, const double* v, double* a) const {
    const double s1 = shared_sine(q[1]), c1 = shared_cosine(q[1]), p1 = shared_sine(q[2]), o1 = shared_cosine(q[2]);
    const double s2 = shared_sine(q[4]), c2 = shared_cosine(q[4]), p2 = shared_sine(q[5]), o2 = shared_cosine(q[5]);
    const double s = shared_sine(q[3] - q[0]), c = shared_cosine(q[3] - q[0]);
    const double w[3] = {v[0] * s1 * p1 + v[1] * o1, v[0] * s1 * o1 - v[1] * p1, v[0] * c1 + v[2]};
    const double x[3] = {v[3] * s2 * p2 + v[4] * o2, v[3] * s2 * o2 - v[4] * p2, v[3] * c2 + v[5]};
    // W = R_x(ϑ₁)ᵀ R_z(φ₂ − φ₁) R_x(ϑ₂), then turned by ψ on both sides; of Q the corner is not needed.
    const double W00 = c, W01 = -s * c2, W02 = s * s2, W10 = c1 * s, W11 = c1 * c * c2 + s1 * s2, W12 = s1 * c2 - c1 * c * s2;
    const double W20 = -s1 * s, W21 = c1 * s2 - s1 * c * c2;
    const double U00 = o1 * W00 + p1 * W10, U01 = o1 * W01 + p1 * W11, U10 = o1 * W10 - p1 * W00, U11 = o1 * W11 - p1 * W01;
    const double Q00 = U00 * o2 + U01 * p2, Q01 = U01 * o2 - U00 * p2, Q10 = U10 * o2 + U11 * p2, Q11 = U11 * o2 - U10 * p2;
    const double Q02 = o1 * W02 + p1 * W12, Q12 = o1 * W12 - p1 * W02, Q20 = W20 * o2 + W21 * p2, Q21 = W21 * o2 - W20 * p2;
    // What u is without Ω̇.
    const double f0 = w[0] * w[2], f1 = w[1] * w[2], f2 = -w[0] * w[0] - w[1] * w[1];
    const double g0 = x[0] * x[2], g1 = x[1] * x[2], g2 = -x[0] * x[0] - x[1] * x[1];
    const double ma = m * alpha, mb = m * beta, k = ma * beta;
    const double b0 = (B - C) * f1 + ma * (alpha * f1 + beta * (Q10 * g0 + Q11 * g1 + Q12 * g2));
    const double b1 = (C - A) * f0 - ma * (alpha * f0 + beta * (Q00 * g0 + Q01 * g1 + Q02 * g2));
    const double b2 = (B - C) * g1 + mb * (beta * g1 + alpha * (Q01 * f0 + Q11 * f1 + Q21 * f2));
    const double b3 = (C - A) * g0 - mb * (beta * g0 + alpha * (Q00 * f0 + Q10 * f1 + Q20 * f2));
    // Rows and columns Ω̇₁x, Ω̇₁y, Ω̇₂x, Ω̇₂y: two diagonal blocks, and k (Q₁₁, −Q₁₀; −Q₀₁, Q₀₀) beside them.
    const double i0 = 1.0 / (A + ma * alpha), i1 = 1.0 / (B + ma * alpha);
    const double l02 = k * Q11 * i0, l03 = -k * Q10 * i0, l12 = -k * Q01 * i1, l13 = k * Q00 * i1;
    const double S22 = A + mb * beta - k * (Q11 * l02 - Q01 * l12), S23 = -k * (Q11 * l03 - Q01 * l13), S33 = B + mb * beta - k * (Q00 * l13 - Q10 * l03);
    const double r2 = b2 - l02 * b0 - l12 * b1, r3 = b3 - l03 * b0 - l13 * b1, i = 1.0 / (S22 * S33 - S23 * S23);
    const double z[3] = {(S33 * r2 - S23 * r3) * i, (S22 * r3 - S23 * r2) * i, (A - B) * x[0] * x[1] * per_C};
    const double y[3] = {b0 * i0 - l02 * z[0] - l03 * z[1], b1 * i1 - l12 * z[0] - l13 * z[1], (A - B) * w[0] * w[1] * per_C};
    EulerAnglesBodyByHand<false>::accelerations(s1, c1, p1, o1, v, y, a);
    EulerAnglesBodyByHand<false>::accelerations(s2, c2, p2, o2, v + 3, z, a + 3);
  }
};

}  // namespace qdot::bench
