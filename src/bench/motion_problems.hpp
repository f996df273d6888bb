#pragma once
// SPDX-License-Identifier: MIT
//
// Motions whose end is known to more digits than a double has: what `qdot bench steppers` and the peers of src/bench/peers
// are measured on.
//
//     pendulum, double pendulum, chains     g = 9.81, unit masses on unit rods, angles from the downward vertical, released at rest
//     kepler                                μ = 1, a = 1, from the perihelion, ten periods
//
// The ends of chains come from an integrator that shares nothing with the library: the equations derived by hand, in 64 bits of
// mantissa, by Gragg's extrapolated midpoint rule. Halving its steps changes nothing above 1e-15. Those of Kepler's orbits are
// the closed form.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace qdot::bench {

/// A start, an end, and the errors that are asked for there.
struct MotionProblem {
  std::string name;
  int n = 0;                         // coordinates
  double t_end = 0;
  std::vector<double> start;         // [q; q̇]
  std::vector<double> errors;        // asked for
  bool relative = true;              // beside the largest entry of the end; otherwise as they are
  std::vector<double> end{};         // [q; q̇]

  /// The error of a result.
  template <class Y>
  double error(const Y& y) const {
    double difference = 0.0, size = 0.0;
    for (std::size_t i = 0; i < end.size(); ++i) {
      const double d = std::abs(y[static_cast<std::ptrdiff_t>(i)] - end[i]);
      if (!(d <= std::numeric_limits<double>::max())) return std::numeric_limits<double>::infinity();
      difference = std::max(difference, d);
      size = std::max(size, std::abs(end[i]));
    }
    return relative ? difference / size : difference;
  }
};

/// ẏ of the chain in any scalar: M_ij = (n − max(i,j)) cos(θ_i − θ_j), M θ̈ = r, by elimination.
template <class S>
void exact_chain_rates(int n, const S* y, S* rates) {
  using std::cos, std::sin;
  std::vector<S> M(static_cast<std::size_t>(n * n)), r(static_cast<std::size_t>(n));
  const auto m = [&](int i, int j) -> S& { return M[static_cast<std::size_t>(i * n + j)]; };
  const auto at = [&](int i) -> S& { return r[static_cast<std::size_t>(i)]; };
  std::vector<S> s(y, y + n), c(s);
  for (S& angle : s) angle = sin(angle);
  for (S& angle : c) angle = cos(angle);
  const S g = static_cast<S>(9.81);  // the double nearest to 9.81
  for (int i = 0; i < n; ++i) {
    const std::size_t I = static_cast<std::size_t>(i);
    at(i) = -static_cast<S>(n - i) * g * s[I];
    for (int j = 0; j < n; ++j) {
      const std::size_t J = static_cast<std::size_t>(j);
      const S links = static_cast<S>(n - std::max(i, j));
      m(i, j) = links * (c[I] * c[J] + s[I] * s[J]);
      at(i) -= links * (s[I] * c[J] - c[I] * s[J]) * y[n + j] * y[n + j];
    }
  }
  for (int k = 0; k < n; ++k)
    for (int i = k + 1; i < n; ++i) {
      const S l = m(i, k) / m(k, k);
      for (int j = k; j < n; ++j) m(i, j) -= l * m(k, j);
      at(i) -= l * at(k);
    }
  for (int i = n - 1; i >= 0; --i) {
    for (int j = i + 1; j < n; ++j) at(i) -= m(i, j) * at(j);
    at(i) /= m(i, i);
  }
  for (int i = 0; i < n; ++i) {
    rates[i] = y[n + i];
    rates[n + i] = at(i);
  }
}

/// y(t) by the midpoint rule in 2, 4, … 16 parts of each step, extrapolated to order 16 (Gragg; Hairer, Nørsett, Wanner, II.9).
template <class F>
std::vector<long double> extrapolated_end(const F& rates, const std::vector<double>& start, double t, int steps) {
  constexpr std::size_t rows = 8;
  const std::size_t size = start.size();
  using Y = std::vector<long double>;
  Y y(start.begin(), start.end()), k(size);
  const long double H = static_cast<long double>(t) / steps;
  std::vector<Y> table(rows);
  for (int step = 0; step < steps; ++step) {
    for (std::size_t row = 0; row < rows; ++row) {
      const std::size_t parts = 2 * (row + 1);
      const long double h = H / static_cast<long double>(parts);
      Y before = y, now = y;
      rates(y.data(), k.data());
      for (std::size_t i = 0; i < size; ++i) now[i] += h * k[i];
      for (std::size_t part = 1; part < parts; ++part) {
        rates(now.data(), k.data());
        for (std::size_t i = 0; i < size; ++i) before[i] += 2 * h * k[i];
        std::swap(before, now);
      }
      // Neville's scheme in h²: from the column before, upwards, so that one row of the table is enough.
      Y entry = now;
      for (std::size_t column = 0; column < row; ++column) {
        const long double ratio = static_cast<long double>(row + 1) / static_cast<long double>(row - column);
        Y next(size);
        for (std::size_t i = 0; i < size; ++i) next[i] = entry[i] + (entry[i] - table[column][i]) / (ratio * ratio - 1);
        std::swap(table[column], entry);
        entry = next;
      }
      table[row] = entry;
    }
    y = table[rows - 1];
  }
  return y;
}

/// Position and velocity of a planet with μ = 1 at time t, from the perihelion (x, 0) with velocity (0, v): Kepler's equation.
inline std::vector<double> kepler_end(long double x, long double v, long double t) {
  const long double a = 1 / (2 / x - v * v), e = 1 - x / a, rate = 1 / (a * std::sqrt(a));
  const long double two_pi = 6.283185307179586476925286766559L;
  const long double mean = rate * t - two_pi * std::round(rate * t / two_pi);
  long double E = mean;
  for (int i = 0; i < 100; ++i) {
    const long double change = (E - e * std::sin(E) - mean) / (1 - e * std::cos(E));
    E -= change;
    if (std::abs(change) < 1e-22L) break;
  }
  const long double root = std::sqrt(1 - e * e), Edot = rate / (1 - e * std::cos(E));
  return {static_cast<double>(a * (std::cos(E) - e)), static_cast<double>(a * root * std::sin(E)),
          static_cast<double>(-a * std::sin(E) * Edot), static_cast<double>(a * root * std::cos(E) * Edot)};
}

/// All problems, or those whose name begins with `wanted`; the ends are computed here, in some milliseconds each.
inline std::vector<MotionProblem> motion_problems(const std::string& wanted = "") {
  const std::vector<double> errors = {1e-6, 1e-9, 1e-12};
  std::vector<MotionProblem> problems;
  const auto add = [&](MotionProblem problem) {
    if (!problem.name.starts_with(wanted)) return;
    const auto digit = [](char c) { return c >= '0' && c <= '9'; };  // "chain 1" is not the beginning of "chain 16"
    if (!wanted.empty() && digit(wanted.back()) && problem.name.size() > wanted.size() && digit(problem.name[wanted.size()])) return;
    const int n = problem.n;
    if (problem.end.empty()) {
      const auto y = extrapolated_end([n](const long double* at, long double* rates) { exact_chain_rates(n, at, rates); }, problem.start,
                                      problem.t_end, static_cast<int>((problem.t_end > 50 ? 32 : 128) * problem.t_end));
      problem.end.assign(y.begin(), y.end());
    }
    problems.push_back(problem);
  };
  const auto hanging = [](int n, double angle) {
    std::vector<double> y(static_cast<std::size_t>(2 * n), 0.0);
    std::fill(y.begin(), y.begin() + n, angle);
    return y;
  };
  add({"double pendulum, t=3", 2, 3.0, hanging(2, 1.7), errors});
  add({"double pendulum, t=10", 2, 10.0, hanging(2, 1.7), errors});
  add({"double pendulum, small, t=100", 2, 100.0, {0.5, 0.8, 0.0, 0.0}, {1e-5}, false});
  for (const int n : {1, 2, 3, 4, 6, 8, 12, 16})
    add({"chain " + std::to_string(n), n, n == 1 ? 10.0 : n <= 8 ? 3.0 : 2.0, hanging(n, 1.7), errors});
  for (const double e : {0.6, 0.99}) {
    const double t = 62.83185307179586;
    // The start is rounded, so the orbit's own elements are those of the numbers that are given.
    const double x = 1 - e, v = std::sqrt((1 + e) / (1 - e));
    add({e == 0.6 ? "kepler e=0.6" : "kepler e=0.99", 2, t, {x, 0.0, 0.0, v}, errors, true, kepler_end(x, v, t)});
  }
  return problems;
}

/// The least time of many rounds, in microseconds: what is CPU-bound and short is slowed by the machine's other work and never sped up.
template <class Round>
double least_microseconds(const Round& round, double seconds = 0.05) {
  using Clock = std::chrono::steady_clock;
  double least = std::numeric_limits<double>::infinity();
  const auto began = Clock::now();
  for (int i = 0; i < 100'000; ++i) {
    const auto before = Clock::now();
    round();
    const auto after = Clock::now();
    least = std::min(least, std::chrono::duration<double, std::micro>(after - before).count());
    if (i >= 2 && std::chrono::duration<double>(after - began).count() > seconds) break;
  }
  return least;
}

/// Tolerances (or steps) from loose to tight.
inline std::vector<double> decades(double from, double to, int per_decade) {
  std::vector<double> result;
  for (int i = 0;; ++i) {
    const double x = from * std::pow(10.0, -static_cast<double>(i) / per_decade);
    if (x < to * (1 - 1e-9)) return result;
    result.push_back(x);
  }
}

}  // namespace qdot::bench
