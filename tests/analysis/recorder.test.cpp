// SPDX-License-Identifier: MIT
//
// Sensitivities of families and on constraints by methods that take the motion's graph, Taylor and Gauss.
#include "qdot/analysis/variations/recorder.hpp"

#include <cmath>

#include "catch2_bridge.hpp"
#include "qdot/analysis/gauss_sensitivity.hpp"
#include "qdot/analysis/taylor_sensitivity.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/dissipation.hpp"

using qdot::Dop853;
using qdot::Gauss;
using qdot::mechanical_system;
using qdot::problem;
using qdot::sensitivities;
using qdot::State;
using qdot::Taylor;
using qdot::Vector;

namespace {

const qdot::Options fine{.rtol = 1e-14, .atol = 1e-15}, reference{.rtol = 1e-13, .atol = 1e-14};

struct Spring {
  double m, k;
  auto T(const auto& v) const { return 0.5 * m * v[0] * v[0]; }
  auto V(const auto& q) const { return 0.5 * k * q[0] * q[0]; }
};

struct Falling {
  double g;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const { return g * q[0]; }
};

// A spring that pulls towards what somebody else sets.
struct Reaching {
  double k;
  const double* at;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const { return 0.5 * k * q[0] * q[0] - k * *at * q[0]; }
};

// A pendulum of length l and rate g, by its angle.
template <class S>
struct Pendulum {
  S l, g;
  auto T(const auto& v) const { return 0.5 * l * l * v[0] * v[0]; }
  auto V(const auto& q) const {
    using std::cos;
    return -g * l * cos(q[0]);
  }
};
constexpr auto pendulum = [](const auto& p) { return Pendulum<std::remove_cvref_t<decltype(p[0])>>{p[0], p[1]}; };

// (x, y, ẋ, ẏ) of (θ, θ̇, l).
constexpr auto plane_of = [](const auto& a) {
  using std::cos, std::sin;
  Vector<std::remove_cvref_t<decltype(a[0])>, 4> y;
  y << a[2] * sin(a[0]), -a[2] * cos(a[0]), a[2] * a[1] * cos(a[0]), a[2] * a[1] * sin(a[0]);
  return y;
};

constexpr double angle = 0.9, rate = 1.1;

// The same as a point in the plane, on a rod, or on two that say the same.
template <bool twice>
constexpr auto rod_of = [](const Eigen::Vector2d& p) {
  const auto point = mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }, [g = p[1]](const auto& q) { return g * q[1]; });
  const auto length = [l = p[0]](const auto& q) { return q[0] * q[0] + q[1] * q[1] - l * l; };
  const auto again = [l = p[0]](const auto& q) {
    using std::sqrt;
    return sqrt(q[0] * q[0] + q[1] * q[1]) - l;
  };
  const Eigen::Vector4d at = plane_of(Eigen::Vector3d(angle, rate, p[0]));
  const State<2> start{0.0, at.head<2>(), at.tail<2>()};
  if constexpr (twice) return problem(scene(point, qdot::holonomic("rod", length), qdot::holonomic("bar", again)), start);
  else return problem(scene(point, qdot::holonomic("rod", length)), start);
};

// Φ of the rod from that of the angle, by (θ, θ̇, l, g).
template <class Found>
double distance_from_angle(const Found& s, double T) {
  const Eigen::Vector2d p(0.8, 9.81);
  const auto expected = sensitivities(pendulum, p, State<1>{0.0, {angle}, {rate}}, T, Taylor{}, fine);
  REQUIRE(s.completed());
  REQUIRE(expected.completed());
  const auto at_start = qdot::jacobian(plane_of, Eigen::Vector3d(angle, rate, p[0])),
             at_end = qdot::jacobian(plane_of, Eigen::Vector3d(expected.y[0], expected.y[1], p[0]));
  Eigen::Matrix4d found, wanted;
  found << s.d_start() * at_start.leftCols<2>(), s.d_parameters();
  wanted = at_end.leftCols<2>() * expected.Phi;
  wanted.col(2) += at_end.col(2);
  return (found - wanted).cwiseAbs().maxCoeff();
}

// A blade that slides along its own direction on a slope, and turns.
constexpr auto skate_of = [](const Eigen::Vector3d& p) {  // mass, moment of inertia, slope
  const auto blade = mechanical_system<3>([m = p[0], I = p[1]](const auto& v) { return 0.5 * m * (v[0] * v[0] + v[1] * v[1]) + 0.5 * I * v[2] * v[2]; },
                                          [m = p[0], a = p[2]](const auto& q) { return m * a * q[0]; });
  const auto across = [](const auto& q, const auto& v) {
    using std::cos, std::sin;
    return v[0] * sin(q[2]) - v[1] * cos(q[2]);
  };
  return problem(scene(blade, qdot::nonholonomic("blade", across)), State<3>{0.0, {0.0, 0.0, 0.3}, {0.5 * std::cos(0.3), 0.5 * std::sin(0.3), 1.2}});
};

// A point on a rod whose length swings, with drag; by length, swing, drag and gravity.
constexpr auto swinging_rod_of = [](const Eigen::Vector4d& p) {
  const auto point = mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }, [g = p[3]](const auto& q) { return g * q[1]; });
  const auto length = [l = p[0], by = p[1]](const auto& q, const auto& t) {
    using std::sin;
    const auto now = l + by * sin(3.0 * t);
    return q[0] * q[0] + q[1] * q[1] - now * now;
  };
  const double speed = 3.0 * p[1];  // of the length at the start
  return problem(scene(point, qdot::holonomic("rod", length), qdot::viscous_damping(Eigen::Vector2d(p[2], p[2]))),
                 State<2>{0.0, {p[0] * std::sin(angle), -p[0] * std::cos(angle)}, {speed * std::sin(angle), -speed * std::cos(angle)}});
};

}  // namespace

TEST_CASE("a family of damped springs depends on mass, stiffness, damping and a start that moves with them as the closed form says") {
  constexpr double error = 1e-12;  // twelve digits of differences
  using D = qdot::Dual<double, 4>;
  const Eigen::Vector4d p(2.0, 3.0, 1.0, 0.4);
  const double T = 2.0;
  const auto family = [](const Eigen::Vector4d& of) {
    return problem(scene(mechanical_system<1>(Spring{of[0], of[1]}), qdot::viscous_damping(Vector<double, 1>(of[2]))), State<1>{0.0, {of[3]}, {of[3] * of[1]}});
  };
  const auto x = [&](int j) { return D::variable(p[j], j); };
  const D m = x(0), k = x(1), c = x(2), a = x(3), decay = c / (2.0 * m), w = sqrt(k / m - decay * decay);
  const D end = exp(-decay * T) * (a * cos(w * T) + (a * k + decay * a) / w * sin(w * T));
  const auto check = [&](const auto& s) {
    INFO(s.message);
    REQUIRE(s.completed());
    REQUIRE(s.Phi.cols() == 4);
    CHECK_THAT(s.y[0], WithinAbs(end.value, error));
    for (std::size_t j = 0; j < 4; ++j) CHECK_THAT(s.Phi(0, static_cast<Eigen::Index>(j)), WithinAbs(end.tangent[j], error));
  };
  check(sensitivities(family, p, T, Taylor{}, fine));
  check(sensitivities(family, p, T, Gauss{.step = 0.02, .stages = 5}));
}

TEST_CASE("a ball that bounces depends on gravity, restitution and the floor's height as the closed form says") {
  constexpr double error = 1e-10;  // of saltation, differenced to some twelve digits, of numbers up to ten
  using D = qdot::Dual<double, 4>;
  const Eigen::Vector4d p(9.81, 0.8, 0.2, 1.5);
  const double T = 1.1;
  const auto family = [](const Eigen::Vector4d& of) {
    const auto bounce = [e = of[1]](State<1>& s) { s.qdot[0] *= -e; };
    return problem(mechanical_system<1>(Falling{of[0]}), State<1>{0.0, {of[3]}, {0.0}},
                   qdot::events(qdot::event("floor", [low = of[2]](const auto& q) { return q[0] - low; }).falling().action(bounce)));
  };
  const auto x = [&](int j) { return D::variable(p[j], j); };
  const D g = x(0), e = x(1), low = x(2), high = x(3), fall = sqrt(2.0 * (high - low) / g), late = T - fall;
  const D end = low + e * g * fall * late - 0.5 * g * late * late;
  const auto check = [&](const auto& s) {
    INFO(s.message);
    REQUIRE(s.completed());
    REQUIRE(s.events.size() == 1);
    for (std::size_t j = 0; j < 4; ++j) {
      CHECK_THAT(s.Phi(0, static_cast<Eigen::Index>(j)), WithinAbs(end.tangent[j], error));
      CHECK_THAT(s.events[0].time[static_cast<Eigen::Index>(j)], WithinAbs(fall.tangent[j], error));
    }
  };
  check(sensitivities(family, p, T, Taylor{}, fine));
  check(sensitivities(family, p, T, Gauss{.step = 0.02, .stages = 2}));
}

TEST_CASE("equations of a family that an action changes on the way are recorded again with all its members") {
  double at = 0.0;
  const auto family = [&at](const Vector<double, 1>& of) {
    const auto change = [&at](State<1>&) { at = 2.0; };
    return problem(mechanical_system<1>(Reaching{of[0], &at}), State<1>{0.0, {0.2}, {0.9}},
                   qdot::events(qdot::event("far", [](const auto& q) { return q[0] - 0.6; }).rising().action(change)));
  };
  const auto found = [&](const auto& method, const qdot::Options& options) {
    at = 0.0;
    const auto s = sensitivities(family, Vector<double, 1>(1.3), 2.0, method, options, {.start = true});
    REQUIRE(s.completed());
    REQUIRE(s.events.size() == 1);
    return s.Phi;
  };
  const Eigen::MatrixXd expected = found(Dop853{}, reference);
  CHECK((found(Taylor{}, fine) - expected).cwiseAbs().maxCoeff() < 1e-12);
  CHECK((found(Gauss{.step = 0.01, .stages = 4}, {}) - expected).cwiseAbs().maxCoeff() < 1e-12);
}

TEST_CASE("by power series the motion on a rod depends on its start, its length and gravity as the motion in an angle does") {
  const Eigen::Vector2d p(0.8, 9.81);
  const double T = 2.0;
  CHECK(distance_from_angle(sensitivities(rod_of<false>, p, T, Taylor{}, fine, {.start = true}), T) < 5e-12);
  CHECK(distance_from_angle(sensitivities(rod_of<true>, p, T, Taylor{}, fine, {.start = true}), T) < 5e-12);
}

TEST_CASE("by Gauss steps the motion on a rod has the derivatives of the motion in an angle, to the order of the method") {
  const Eigen::Vector2d p(0.8, 9.81);
  const double T = 2.0;
  const auto off = [&](double step) {
    return distance_from_angle(sensitivities(rod_of<false>, p, T, Gauss{.step = step, .stages = 2}, {}, {.start = true}), T);
  };
  const double coarse = off(0.04), medium = off(0.02);
  CHECK_THAT(std::log2(coarse / medium), WithinAbs(4.0, 0.3));
  CHECK(distance_from_angle(sensitivities(rod_of<false>, p, T, Gauss{.step = 0.02, .stages = 5}, {}, {.start = true}), T) < 1e-11);
  CHECK(distance_from_angle(sensitivities(rod_of<true>, p, T, Gauss{.step = 0.02, .stages = 5}, {}, {.start = true}), T) < 1e-11);
}

TEST_CASE("on a rod, too, the tangent of Gauss steps is the derivative of the numbers that they give, projections among them") {
  constexpr double error = 2e-11;  // what differences of order six leave
  const Eigen::Vector2d p(0.8, 9.81);
  const Gauss method{.step = 0.05, .stages = 1};  // far from converged: Φ of the motion itself is 5e-2 away
  const auto s = sensitivities(rod_of<false>, p, 2.0, method);
  REQUIRE(s.completed());
  for (int j = 0; j < 2; ++j) {
    const double h = 2e-3 * p[j];
    const auto sum = [&](int k) {
      const auto end = [&](double by) {
        Eigen::Vector2d near = p;
        near[j] += by;
        const auto of = rod_of<false>(near);
        return Eigen::Vector4d(simulate(of.system, of.start, 2.0, method).y);
      };
      return Eigen::Vector4d(end(k * h) - end(-k * h));
    };
    CHECK((s.Phi.col(j) - (45 * sum(1) - 9 * sum(2) + sum(3)) / (60 * h)).norm() < error);
  }
}

TEST_CASE("a blade on a slope, and a rod whose length swings, have the same derivatives by power series, by Gauss steps and by Dop853") {
  const auto check = [](const auto& family, const auto& p) {
    constexpr double T = 2.0;
    const qdot::WithRespectTo all{.start = true, .start_time = true};
    const auto expected = sensitivities(family, p, T, Dop853{}, reference, all);
    REQUIRE(expected.completed());
    const auto agrees = [&](const auto& s) {
      INFO(s.message);
      REQUIRE(s.completed());
      CHECK((s.Phi - expected.Phi).cwiseAbs().maxCoeff() < 1e-10);  // of Dop853, mostly
      CHECK((s.Phi_at(1.234) - expected.Phi_at(1.234)).cwiseAbs().maxCoeff() < 1e-8);  // between steps, within the polynomials of degree five
    };
    agrees(sensitivities(family, p, T, Taylor{}, fine, all));
    agrees(sensitivities(family, p, T, Gauss{.step = 0.01, .stages = 5}, {}, all));
  };
  check(skate_of, Eigen::Vector3d(1.3, 0.4, 2.5));
  check(swinging_rod_of, Eigen::Vector4d(0.8, 0.1, 0.3, 9.81));
}
