#pragma once
// SPDX-License-Identifier: MIT
//
// Motions that are known to more digits than double has: closed forms, and for the others extrapolation in long double
// (whose ends agree with published digits, see simulate_to_accuracy.test.cpp). One type for all, so that a method is
// compiled once.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "qdot/integrate/run.hpp"

namespace accurate_scenes {

using Real = long double;
using Reals = std::vector<Real>;

/// ẏ = f(t, y), as the steppers want it.
struct Equations {
  static constexpr int size_at_compile_time = qdot::Dynamic;
  std::function<void(double, const double*, double*)> f;
  Eigen::Index n = 0;

  Eigen::Index size() const { return n; }
  void derivative(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot) const {
    f(t, y.data(), ydot.data());
  }
  void jacobian(double, const Eigen::Ref<const Eigen::VectorXd>&, Eigen::Ref<Eigen::MatrixXd> J) const { J.setZero(); }
  std::string component_name(Eigen::Index i) const { return "y" + std::to_string(i); }
};

struct Scene {
  std::string name;
  Equations equations;
  std::vector<double> start;
  double t_end;
  std::function<std::vector<Reals>(const std::vector<double>& times)> exact;  // y at times that increase
};

inline Eigen::MatrixXd columns(const std::vector<Reals>& states) {
  Eigen::MatrixXd y(static_cast<Eigen::Index>(states.front().size()), static_cast<Eigen::Index>(states.size()));
  for (std::size_t k = 0; k < states.size(); ++k)
    for (std::size_t i = 0; i < states[k].size(); ++i)
      y(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = static_cast<double>(states[k][i]);
  return y;
}

inline std::vector<double> equal_times(double t_end, int parts) {
  std::vector<double> times;
  for (int k = 0; k <= parts; ++k) times.push_back(k == parts ? t_end : t_end * k / parts);
  return times;
}

/// sn, cn, dn of parameter m, by the arithmetic-geometric mean (Abramowitz and Stegun, 16.4).
inline Reals elliptic(Real u, Real m) {
  std::vector<Real> a{1}, c{std::sqrt(m)};
  Real b = std::sqrt(1 - m), power = 1;
  while (c.back() > 1e-20L && a.size() < 20) {
    const Real next = (a.back() + b) / 2, half = (a.back() - b) / 2;
    b = std::sqrt(a.back() * b);
    a.push_back(next);
    c.push_back(half);
    power *= 2;
  }
  Real phi = power * a.back() * u;
  for (std::size_t k = a.size(); k-- > 1;) phi = (phi + std::asin(c[k] / a[k] * std::sin(phi))) / 2;
  const Real sn = std::sin(phi);
  return {sn, std::cos(phi), std::sqrt(1 - m * sn * sn)};
}

/// y at times that increase, by extrapolation of the midpoint rule to order 16 (Gragg, Bulirsch, Stoer).
template <class F>
std::vector<Reals> extrapolated(const F& f, const std::vector<double>& start, const std::vector<double>& times) {
  constexpr std::size_t rows = 8;
  const std::size_t n = start.size();
  constexpr Real tolerance = 1e-17L, smallest = 1e-5L;
  Reals y(start.begin(), start.end()), rate(n), left(n), middle(n), right(n);
  std::vector<Reals> table(rows, Reals(n)), result;
  Real t = 0, h = 0.02L;
  for (const double target : times) {
    while (t < target) {
      const bool lands = t + h >= target;
      const Real step = lands ? target - t : h;
      Real error = 0;
      f(t, y.data(), rate.data());
      for (std::size_t k = 0; k < rows; ++k) {
        const std::size_t parts = 2 * (k + 1);
        const Real part = step / static_cast<Real>(parts);
        left = y;
        for (std::size_t i = 0; i < n; ++i) middle[i] = y[i] + part * rate[i];
        for (std::size_t s = 1; s < parts; ++s) {
          f(t + static_cast<Real>(s) * part, middle.data(), right.data());
          for (std::size_t i = 0; i < n; ++i) left[i] += 2 * part * right[i];
          std::swap(left, middle);
        }
        f(t + step, middle.data(), right.data());
        for (std::size_t i = 0; i < n; ++i) {
          Real value = (left[i] + middle[i] + part * right[i]) / 2;
          for (std::size_t j = 0; j < k; ++j) {
            const Real ratio = static_cast<Real>(k + 1) / static_cast<Real>(k - j);
            const Real better = value + (value - table[j][i]) / (ratio * ratio - 1);
            table[j][i] = std::exchange(value, better);
          }
          if (k + 1 == rows) error = std::max(error, std::abs(value - table[k - 1][i]) / (std::abs(value) + std::abs(y[i]) + 1e-3L));
          table[k][i] = value;
        }
      }
      const Real factor = 0.8L * std::pow(tolerance / std::max(error, 1e-30L), 1.0L / 15);
      if (error > tolerance && step > smallest) {
        h = step * std::max(factor, 0.2L);
        continue;
      }
      y = table[rows - 1];
      t = lands ? static_cast<Real>(target) : t + step;
      if (!lands || factor < 1) h = std::max(step * std::min(factor, 2.0L), smallest);
    }
    result.push_back(y);
  }
  return result;
}

/// All motions; the equations are written once for double and long double.
inline std::vector<Scene> all() {
  std::vector<Scene> scenes;
  const auto add = [&](std::string name, std::vector<double> start, double t_end, auto f, auto exact) {
    const auto count = static_cast<Eigen::Index>(start.size());
    scenes.push_back({std::move(name), {[f](double t, const double* y, double* d) { f(t, y, d); }, count}, std::move(start), t_end,
                      [exact](const std::vector<double>& times) {
                        std::vector<Reals> states;
                        for (const double t : times) states.push_back(exact(static_cast<Real>(t)));
                        return states;
                      }});
  };
  const auto add_extrapolated = [&](std::string name, std::vector<double> start, double t_end, auto f) {
    const auto count = static_cast<Eigen::Index>(start.size());
    scenes.push_back({std::move(name), {[f](double t, const double* y, double* d) { f(t, y, d); }, count}, start, t_end,
                      [f, start](const std::vector<double>& times) {
                        return extrapolated([&f](Real t, const Real* y, Real* d) { f(t, y, d); }, start, times);
                      }});
  };
  constexpr Real g = 9.81;  // the double

  const auto pendulum = [](auto, auto y, auto d) {
    d[0] = y[1];
    d[1] = -9.81 * std::sin(y[0]);
  };
  const auto swing = [](Real theta0) {  // released at rest
    return [theta0](Real t) -> Reals {
      const Real k = std::sin(theta0 / 2), w = std::sqrt(g);
      const Reals e = elliptic(w * t, k * k);
      const Real s = k * e[1] / e[2];
      return {2 * std::asin(s), -2 * k * (1 - k * k) * w * e[0] / (e[2] * e[2]) / std::sqrt(1 - s * s)};
    };
  };
  add("pendulum, 2.5 rad, t = 10", {2.5, 0}, 10, pendulum, swing(2.5));
  add("pendulum, 1 rad, t = 100", {1, 0}, 100, pendulum, swing(1));

  const auto kepler = [](auto, auto y, auto d) {
    const auto r2 = y[0] * y[0] + y[1] * y[1];
    const auto r3 = r2 * std::sqrt(r2);
    d[0] = y[2], d[1] = y[3], d[2] = -y[0] / r3, d[3] = -y[1] / r3;
  };
  const auto ellipse = [](Real x0, Real vy) {  // from the perihelion
    return [x0, vy](Real t) -> Reals {
      const Real e = x0 * vy * vy - 1, a = x0 / (1 - e), rate = 1 / std::sqrt(a * a * a);
      const Real M = rate * t;
      Real E = M + e * std::sin(M);
      for (int k = 0; k < 30; ++k) E -= (E - e * std::sin(E) - M) / (1 - e * std::cos(E));
      const Real b = a * std::sqrt(1 - e * e), Edot = rate / (1 - e * std::cos(E));
      return {a * (std::cos(E) - e), b * std::sin(E), -a * std::sin(E) * Edot, b * std::cos(E) * Edot};
    };
  };
  add("Kepler, e = 0.6, 10 turns", {0.4, 0, 0, 2}, 20 * std::numbers::pi, kepler, ellipse(0.4, 2));
  add("Kepler, e = 0.9, t = 20", {0.1, 0, 0, std::sqrt(19.0)}, 20, kepler, ellipse(0.1, std::sqrt(19.0)));

  add("harmonic oscillator, t = 50", {1, 0}, 50, [](auto, auto y, auto d) { d[0] = y[1], d[1] = -y[0]; },
      [](Real t) -> Reals { return {std::cos(t), -std::sin(t)}; });
  add("projectile, t = 3", {0, 0, 0, 10, 4, 14}, 3,
      [](auto, auto y, auto d) {
        for (int i = 0; i < 3; ++i) d[i] = y[3 + i], d[3 + i] = 0;
        d[5] = -9.81;
      },
      [](Real t) -> Reals { return {10 * t, 4 * t, 14 * t - g * t * t / 2, 10, 4, 14 - g * t}; });
  add("charge in crossed fields, t = 20", {0, 0, 0.125, 0}, 20,
      [](auto, auto y, auto d) { d[0] = y[2], d[1] = y[3], d[2] = 2 * y[3] + 0.25, d[3] = -2 * y[2]; },
      [](Real t) -> Reals {  // w = x + i y:  ẅ = −2i ẇ + ¼
        using C = std::complex<Real>;
        const C i(0, 1), drift = Real(0.125) / i, rest = Real(0.125) - drift;
        const C turn = std::exp(C(0, -2 * t)), w = drift * t + rest * (turn - Real(1)) / (Real(-2) * i), v = drift + rest * turn;
        return {w.real(), w.imag(), v.real(), v.imag()};
      });
  add("cycloid, 2.2 rad, t = 10", {2.2, 0}, 10,
      [](auto, auto y, auto d) {
        d[0] = y[1];
        d[1] = std::sin(y[0]) * (y[1] * y[1] - 9.81) / (2 * (1 + std::cos(y[0])));
      },
      [](Real t) -> Reals {  // the arc length 4 sin ½θ is harmonic
        const Real w = std::sqrt(g) / 2, s0 = std::sin(Real(2.2) / 2), s = s0 * std::cos(w * t);
        return {2 * std::asin(s), -2 * w * s0 * std::sin(w * t) / std::sqrt(1 - s * s)};
      });
  add("Morse, E = 0.72, t = 40", {0, 1.2}, 40,
      [](auto, auto y, auto d) {
        const auto e = std::exp(-y[0]);
        d[0] = y[1], d[1] = -2 * e * (1 - e);
      },
      [](Real t) -> Reals {
        const Real v0 = 1.2, E = v0 * v0 / 2, root = std::sqrt(E), w = std::sqrt(2 * (1 - E)), phase = w * t + std::acos(root);
        const Real up = 1 - root * std::cos(phase);
        return {std::log(up / (1 - E)), root * w * std::sin(phase) / up};
      });
  add("coupled oscillators, t = 50", {1, 0, 0, 0}, 50,
      [](auto, auto y, auto d) { d[0] = y[2], d[1] = y[3], d[2] = -2 * y[0] + y[1], d[3] = -2 * y[1] + y[0]; },
      [](Real t) -> Reals {
        const Real w = std::sqrt(Real(3)), a = std::cos(t), b = std::cos(w * t), c = -std::sin(t), e = -w * std::sin(w * t);
        return {(a + b) / 2, (a - b) / 2, (c + e) / 2, (c - e) / 2};
      });
  add("Mathews-Lakshmanan, t = 30", {2, 0}, 30,
      [](auto, auto y, auto d) { d[0] = y[1], d[1] = y[0] * (y[1] * y[1] / 2 - 1) / (1 + y[0] * y[0] / 2); },
      [](Real t) -> Reals {
        const Real w = 1 / std::sqrt(Real(3));
        return {2 * std::cos(w * t), -2 * w * std::sin(w * t)};
      });
  add("Duffing, t = 30", {1, 0}, 30, [](auto, auto y, auto d) { d[0] = y[1], d[1] = -y[0] - y[0] * y[0] * y[0]; },
      [](Real t) -> Reals {
        const Real w = std::sqrt(Real(2));
        const Reals e = elliptic(w * t, Real(1) / 4);
        return {e[1], -w * e[0] * e[2]};
      });
  add("free rigid body, t = 100", {0, 1, 1}, 100,
      [](auto, auto y, auto d) { d[0] = y[1] * y[2], d[1] = -y[0] * y[2], d[2] = -51 * y[0] * y[1] / 100; },
      [](Real t) -> Reals { return elliptic(t, Real(51) / 100); });
  add("damped oscillator, t = 20", {1, 0}, 20, [](auto, auto y, auto d) { d[0] = y[1], d[1] = -4 * y[0] - y[1] / 2; },
      [](Real t) -> Reals {
        const Real c = Real(1) / 4, w = std::sqrt(4 - c * c), e = std::exp(-c * t);
        return {e * (std::cos(w * t) + c / w * std::sin(w * t)), -e * 4 / w * std::sin(w * t)};
      });
  add("pendulum beside a size of 1e8, t = 10", {1, 1e8, 0, 0}, 10,
      [](auto, auto y, auto d) { d[0] = y[2], d[1] = y[3], d[2] = -9.81 * std::sin(y[0]), d[3] = -y[1]; },
      [swing](Real t) -> Reals {
        const Reals p = swing(1)(t);
        return {p[0], 1e8L * std::cos(t), p[1], -1e8L * std::sin(t)};
      });

  const auto double_pendulum = [](auto, auto y, auto d) {
    const auto c = std::cos(y[0] - y[1]), s = std::sin(y[0] - y[1]);
    const auto f1 = -s * y[3] * y[3] - 2 * 9.81 * std::sin(y[0]), f2 = s * y[2] * y[2] - 9.81 * std::sin(y[1]), det = 2 - c * c;
    d[0] = y[2], d[1] = y[3], d[2] = (f1 - c * f2) / det, d[3] = (2 * f2 - c * f1) / det;
  };
  add_extrapolated("double pendulum, t = 3", {1.7, 1.7, 0, 0}, 3, double_pendulum);
  add_extrapolated("double pendulum, t = 10", {1.7, 1.7, 0, 0}, 10, double_pendulum);
  add_extrapolated("Hénon-Heiles, t = 100", {0.1, 0, 0, 0.5}, 100, [](auto, auto y, auto d) {
    d[0] = y[2], d[1] = y[3], d[2] = -y[0] - 2 * y[0] * y[1], d[3] = -y[1] - y[0] * y[0] + y[1] * y[1];
  });
  add_extrapolated("spherical pendulum, t = 10", {1.2, 0, 0, 1}, 10, [](auto, auto y, auto d) {
    const auto s = std::sin(y[0]), c = std::cos(y[0]);
    d[0] = y[2], d[1] = y[3], d[2] = s * (c * y[3] * y[3] - 9.81), d[3] = -2 * c / s * y[2] * y[3];
  });
  add_extrapolated("elastic pendulum, t = 20", {1.7, 0.08, 0, 0}, 20, [](auto, auto y, auto d) {
    d[0] = y[2], d[1] = y[3], d[2] = y[0] * y[3] * y[3] + 9.81 * std::cos(y[1]) - 29.43 * (y[0] - 1);
    d[3] = (-2 * y[2] * y[3] - 9.81 * std::sin(y[1])) / y[0];
  });
  return scenes;
}

}  // namespace accurate_scenes
