// SPDX-License-Identifier: MIT
//
// Derivatives through events, of scenes that nobody chose: masses, couplings, potentials, dampers, walls, friction, constraints and starts by lot. What
// is expected are differences of order six of the runs' ends.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>

#include "catch2_bridge.hpp"
#include "qdot/analysis/sensitivity.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/dry_friction.hpp"
#include "qdot/integrate/simulate.hpp"

using qdot::Dop853;
using qdot::problem;
using qdot::State;

namespace {

const qdot::Options fine{.rtol = 1e-13, .atol = 1e-14};
constexpr double good = 1e-7;  // relative; the differences have noise of 1e-12 over the step, grown by the motion

class Lot {
 public:
  explicit Lot(std::uint64_t seed) : bits_(seed) {}
  double operator()(double from, double to) { return from + (to - from) * static_cast<double>(bits_() >> 11) * 0x1p-53; }

 private:
  std::mt19937_64 bits_;
};

// Twelve numbers that a scene is made of, and how fast each changes with s.
using Numbers = Eigen::Matrix<double, 12, 1>;
struct Draw {
  Numbers p, along;
  qdot::Vector<double, 2> q, qdot, q_along, qdot_along;
  double t_end;
  Numbers at(double s) const { return p + s * along; }
};

Draw draw(Lot& lot) {
  Draw x;
  x.p << lot(0.5, 2.0), lot(0.5, 2.0), lot(-0.4, 0.4), lot(0.5, 4.0), lot(0.5, 4.0), lot(0.0, 1.0),  // masses, coupling, stiffness, quartic
      lot(-1.0, 1.0), lot(0.0, 0.3), lot(0.5, 1.0), lot(0.1, 0.4), lot(0.3, 0.9), lot(0.5, 2.0);     // force, damping, what is left to each kind
  for (double& a : x.along) a = lot(-1.0, 1.0);
  for (int i = 0; i < 2; ++i) {
    x.q[i] = lot(-0.3, 0.3);
    x.qdot[i] = lot(-1.5, 1.5);
    x.q_along[i] = lot(-1.0, 1.0);
    x.qdot_along[i] = lot(-1.0, 1.0);
  }
  x.t_end = lot(3.0, 6.0);
  return x;
}

struct Body {
  double m1, m2, b, k1, k2, quartic, force, drive;
  auto T(const auto& q, const auto& v) const {
    using std::cos;
    return 0.5 * m1 * v[0] * v[0] + 0.5 * m2 * v[1] * v[1] + b * cos(q[0] - q[1]) * v[0] * v[1];
  }
  auto V(const auto& q, const auto& t) const {
    using std::cos;
    const auto r2 = q[0] * q[0] + q[1] * q[1];
    return 0.5 * k1 * q[0] * q[0] + 0.5 * k2 * q[1] * q[1] + 0.25 * quartic * r2 * r2 + (force - drive * cos(1.7 * t)) * q[0];
  }
};
auto body(const Numbers& p, double drive) { return qdot::mechanical_system<2>(Body{p[0], p[1], p[2], p[3], p[4], p[5], p[6], drive}); }
auto damping(const Numbers& p) { return qdot::viscous_damping(qdot::Vector<double, 2>(p[7], 0.5 * p[7])); }

// Oblique walls on both sides, one of them moving.
struct Wall {
  double side, slope, distance, speed;
  auto operator()(const auto& q, const auto& t) const { return distance - side * (q[0] + slope * q[1]) + speed * t; }
};
auto between_walls(const Numbers& p, const State<2>& start) {
  return problem(scene(body(p, 0.0), damping(p), qdot::contact("left", Wall{-1.0, p[9], 0.6 * p[8], 0.05 * p[11]}, qdot::restitution(p[10])),
                       qdot::contact("right", Wall{1.0, -p[9], 0.6 * p[8], 0.0}, qdot::restitution(p[10]))),
                 start);
}

auto on_rough_floor(const Numbers& p, const State<2>& start) {
  return problem(scene(body(p, 2.0 * p[11]), damping(p), qdot::dry_friction("floor", 0, p[9] + 0.2, 1.3 * (p[9] + 0.2))), start);
}

// On an ellipse; a kick turns it back and slows it down where q₁ passes a height.
auto on_an_ellipse(const Numbers& p, const State<2>&) {
  using Action = std::function<void(State<2>&)>;
  using V2 = qdot::Vector<double, 2>;
  const double a = p[8], c = p[11], u = p[6], w = 2.0 + p[9], e = p[10];
  const State<2> start{0.0, {a * std::cos(u), c * std::sin(u)}, {-a * w * std::sin(u), c * w * std::cos(u)}};
  return problem(
      scene(body(p, 0.0), damping(p),
            qdot::holonomic("ellipse", [a, c](const auto& q) { return q[0] * q[0] / (a * a) + q[1] * q[1] / (c * c) - 1.0; })),
      start,
      qdot::events(qdot::event("height", [c](const V2& q, const V2&) { return q[1] - 0.3 * c; }).rising().action(Action([e](State<2>& s) {
        s.qdot *= -e;
      }))));
}

// So many scenes whose members on both sides pass as many events.
void compare(std::uint64_t seed, int scenes, const auto& member, std::size_t least_events) {
  Lot lot(seed);
  int drawn = 0;
  std::size_t events = 0;
  for (int i = 0; i < scenes;) {
    const Draw x = draw(lot);
    REQUIRE(++drawn <= scenes + scenes / 5 + 1);  // others are redrawn
    const auto family = [&](const qdot::Vector<double, 1>& s) {
      return member(x.at(s[0]), State<2>{0.0, x.q + s[0] * x.q_along, x.qdot + s[0] * x.qdot_along});
    };
    const auto found = sensitivities(family, qdot::Vector<double, 1>(0.0), x.t_end, Dop853{}, fine);
    CAPTURE(seed, i, drawn, found.message);
    bool same = found.completed();
    const auto end = [&](double s) {
      const auto other = family(qdot::Vector<double, 1>(s));
      const auto run = simulate(other.system, other.start, x.t_end, Dop853{}, fine, qdot::NoObserver{}, other.events);
      same = same && run.outcome == qdot::Outcome::completed && run.events.size() == found.events.size();
      return Eigen::Vector4d(run.y.head(4));
    };
    const auto difference = [&](double h) {
      return Eigen::Vector4d((45.0 * (end(h) - end(-h)) - 9.0 * (end(2 * h) - end(-2 * h)) + (end(3 * h) - end(-3 * h))) / (60.0 * h));
    };
    // The step is halved until that changes nothing more: near a graze the end is almost a square root.
    double h = 4e-4;
    Eigen::Vector4d slope = difference(h);
    for (bool settled = false; same && !settled && h > 1e-5;) {
      h *= 0.5;
      const Eigen::Vector4d finer = difference(h);
      settled = (finer - slope).norm() <= 0.2 * good * std::max(1.0, slope.norm());
      slope = finer;
    }
    if (!same) continue;  // an event comes or goes within the differences: they are none
    ++i;
    events += found.events.size();
    CHECK((found.Phi.topRightCorner(4, 1) - slope).norm() <= good * std::max(1.0, slope.norm()));
  }
  CHECK(events >= least_events);
}

const auto walls = [](const Numbers& p, const State<2>& s) { return between_walls(p, s); };
const auto rough = [](const Numbers& p, const State<2>& s) { return on_rough_floor(p, s); };
const auto ellipse = [](const Numbers& p, const State<2>& s) { return on_an_ellipse(p, s); };

}  // namespace

TEST_CASE("through impacts, friction and kicks on a constraint, derivatives of two hundred random scenes are those of differences") {
  compare(4, 80, walls, 100);
  compare(5, 60, rough, 120);
  compare(6, 60, ellipse, 60);
}
