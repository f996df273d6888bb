// SPDX-License-Identifier: MIT
//
// Starts at which an adaptive method may be fooled, because the first terms of the motion's series vanish there, and
// coordinates of very different sizes: right to the tolerance with every adaptive method.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "../catch2_bridge.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/taylor.hpp"

namespace {

using namespace qdot;

// One type for all motions, so that each method is compiled once.
enum class Kind { chain, quartic, beside };
struct Motion {
  Kind kind = Kind::chain;

  template <class S>
  S T(const Vector<S, Dynamic>& q, const Vector<S, Dynamic>& qdot) const {
    using std::cos, std::sin;
    S vx(0.0), vy(0.0), sum(0.0);
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      if (kind == Kind::chain) {
        vx += cos(q[k]) * qdot[k];
        vy += sin(q[k]) * qdot[k];
        sum += 0.5 * (vx * vx + vy * vy);
      } else {
        sum += 0.5 * qdot[k] * qdot[k];
      }
    }
    return sum;
  }
  template <class S>
  S V(const Vector<S, Dynamic>& q) const {
    using std::cos;
    if (kind == Kind::quartic) return 0.25 * q[0] * q[0] * q[0] * q[0];
    if (kind == Kind::beside) return -9.81 * cos(q[0]) + 0.005 * q[1] * q[1];
    S y(0.0), sum(0.0);
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      y -= cos(q[k]);
      sum += 9.81 * y;
    }
    return sum;
  }
};

// Jacobi's sn, cn, dn of modulus k² = ½, by the arithmetic-geometric mean (Abramowitz and Stegun 16.4).
struct Elliptic {
  double sn, cn, dn;
  explicit Elliptic(double u) {
    std::array<double, 8> a{1.0}, c{std::sqrt(0.5)};
    double b = std::sqrt(0.5);
    std::size_t last = 0;
    for (; last + 1 < a.size() && c[last] > 1e-17; ++last) {
      c[last + 1] = 0.5 * (a[last] - b);
      a[last + 1] = 0.5 * (a[last] + b);
      b = std::sqrt(a[last] * b);
    }
    double phi = std::ldexp(a[last] * u, static_cast<int>(last));
    for (std::size_t i = last; i > 0; --i) phi = 0.5 * (phi + std::asin(c[i] / a[i] * std::sin(phi)));
    sn = std::sin(phi);
    cn = std::cos(phi);
    dn = std::sqrt(1.0 - 0.5 * sn * sn);
  }
};

// A pendulum of length 1 released from the horizontal: sin ½θ = k cd(ωt), θ̇ = −ω sd(ωt), k² = ½, ω² = 9.81.
Eigen::Vector2d pendulum_from_horizontal(double t) {
  const double omega = std::sqrt(9.81);
  const Elliptic e(omega * t);
  return {2.0 * std::asin(std::sqrt(0.5) * e.cn / e.dn), -omega * e.sn / e.dn};
}

struct Case {
  Kind kind;
  std::vector<double> start;  // [q; q̇]
  double t_end;
  std::vector<double> end;
  double factor = 1.0;  // how many more of its tolerances it may lose than others: its sensitivity to the start
};

std::vector<Case> cases() {
  const double horizontal = 1.57079632679489661923;
  const Eigen::Vector2d pendulum = pendulum_from_horizontal(3.0);
  const Elliptic e(std::pow(2.0, 0.25) * 10.0);  // ẍ = −x³ from x = 0 with ẋ = 1: x = 2^(−1/4) sd(2^(1/4) t), ẋ = cn/dn²
  std::vector<Case> all = {
      {Kind::chain, {horizontal, 0.0}, 3.0, {pendulum[0], pendulum[1]}},
      // Gragg's extrapolated midpoint rule (src/bench/motion_problems.hpp) on the equations derived by hand, with 64 bits of
      // mantissa; 1152 and 1536 steps agree in all digits given.
      {Kind::chain,
       {horizontal, horizontal, 0.0, 0.0},
       3.0,
       {1.7857955220774167, 1.1181074612051553, 0.3279806195144556, -0.5044551039453125}},
      {Kind::chain,
       {horizontal, horizontal, horizontal, 0.0, 0.0, 0.0},
       3.0,
       {0.4942069788086046, 1.1327211804235414, 1.4028266150334652, 2.4794967509217878, 3.791054891478832, -0.5763981034218155},
       10.0},
      {Kind::quartic, {0.0, 1.0}, 10.0, {std::pow(2.0, -0.25) * e.sn / e.dn, e.cn / (e.dn * e.dn)}},
  };
  for (const double A : {1.0, 1e8})
    all.push_back({Kind::beside,
                   {horizontal, A, 0.0, 0.0},
                   3.0,
                   {pendulum[0], A * std::cos(0.3), pendulum[1], -0.1 * A * std::sin(0.3)}});
  return all;
}

TEST_CASE("Jacobi's functions are those of the tables") {
  CHECK_THAT(Elliptic(1.8540746773013719).cn, WithinAbs(0.0, 1e-15));  // K(½), Abramowitz and Stegun 17.3
  CHECK_THAT(Elliptic(1.0).sn, WithinAbs(0.8030018248956439, 1e-15));
}

template <class Method>
void check_all(const Method& method, double tightest, double allowed) {
  for (const Case& c : cases()) {
    const Eigen::Index n = static_cast<Eigen::Index>(c.start.size() / 2);
    const auto at = [&](const std::vector<double>& y, Eigen::Index i) { return y[static_cast<std::size_t>(i)]; };
    State<Dynamic> start{0.0, Eigen::VectorXd(n), Eigen::VectorXd(n)};
    for (Eigen::Index i = 0; i < n; ++i) {
      start.q[i] = at(c.start, i);
      start.qdot[i] = at(c.start, n + i);
    }
    std::vector<Options> all = {Options{}};
    for (const double tol : {1e-13, 1e-12, 1e-9, 1e-6})
      if (tol >= tightest) all.push_back({.rtol = tol, .atol = tol});
    for (Options& options : all) {
      options.keep_trajectory = false;
      const auto run = simulate(mechanical_system(n, Motion{c.kind}), start, c.t_end, method, options);
      CHECK(run.completed());
      for (Eigen::Index i = 0; i < 2 * n; ++i) {
        const double size = std::max(1.0, std::abs(at(c.end, i)));
        const double error = std::abs(run.y[i] - at(c.end, i)) / size;
        INFO(method.name << ", kind " << static_cast<int>(c.kind) << ", n = " << n << ", rtol " << options.rtol << ", component " << i
                         << ": " << run.y[i] << " instead of " << at(c.end, i) << ", " << error / options.rtol << " tolerances");
        // Below 1e-13 a double's own rounding over the run counts.
        CHECK(error < c.factor * std::max(allowed * options.rtol, 1e-12));
      }
    }
  }
}

// How many tolerances are lost on the way: each step may spend one, a multistep method takes a thousand.
TEST_CASE("Taylor is right where series are short of terms, and beside coordinates of another size") { check_all(Taylor{}, 1e-13, 30); }
TEST_CASE("Dop853 is right where series are short of terms, and beside coordinates of another size") { check_all(Dop853{}, 1e-13, 100); }
TEST_CASE("Dopri5 is right where series are short of terms, and beside coordinates of another size") { check_all(Dopri5{}, 1e-13, 100); }
TEST_CASE("CvodeAdams is right where series are short of terms, and beside coordinates of another size") {
  check_all(CvodeAdams{}, 1e-13, 1000);
}
TEST_CASE("CvodeBdf is right where series are short of terms, and beside coordinates of another size") { check_all(CvodeBdf{}, 1e-13, 5000); }

}  // namespace
