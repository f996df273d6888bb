// SPDX-License-Identifier: MIT
//
// Derivatives of motions whose T, V or forces take a branch on the way.

#include "qdot/analysis/variations/branches.hpp"

#include <cmath>
#include <string>
#include <type_traits>

#include "catch2_bridge.hpp"
#include "qdot/analysis/adjoint.hpp"
#include "qdot/analysis/sensitivity.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene.hpp"

using namespace qdot;

namespace {

using V1 = Vector<double, 1>;
using V2 = Vector<double, 2>;
using V3 = Vector<double, 3>;
const Options fine{.rtol = 1e-11, .atol = 1e-13};
constexpr double near = 1e-8;  // what steps of 1e-11 leave of a motion of size 1, and its derivatives

// x″ = p₀ up to the place p₁ and up to the time p₂; beyond one of them x″ = 0.
template <class P>
struct Push {
  P p;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  template <class Q, class S>
  auto V(const Q& q, const S& t) const {
    using R = std::decay_t<decltype(q[0] * p[0] * t)>;
    return q[0] < p[1] && t < p[2] ? R(-p[0] * (q[0] - p[1])) : R(0.0 * q[0]);
  }
};
const auto push = [](const auto& p) { return Push<std::decay_t<decltype(p)>>{p}; };

// Two coordinates, each in a V of its own with a kink at 0.
struct TwoVees {
  auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  auto V(const auto& q) const {
    using std::abs;
    return abs(q[0]) + 2.0 * abs(q[1]);
  }
};

std::string refusal(const auto& system, const State<1>& start, double t_end, Outcome outcome = Outcome::not_differentiable) {
  const auto s = sensitivities(system, start, t_end, Dop853{}, fine);
  CHECK(s.outcome == outcome);
  return s.message;
}
auto system_of(auto T, auto V) { return mechanical_system<1>(T, V); }
const auto unit_mass = [](const auto& v) { return 0.5 * v[0] * v[0]; };

}  // namespace

// q = b + v (t − v/F) behind the place b, v = √(2F(b − q₀)): ∂q/∂q₀ = 1 − F (t − v/F)/v + …, by hand.
TEST_CASE("a force that ends at a place shortens what comes behind it") {
  const double F = 0.1, b = 0.25, t = 4.0, v = std::sqrt(2 * F * b);
  const V3 p(F, b, 100.0);
  const State<1> start{0.0, V1(0.0), V1(0.0)};
  const auto s = sensitivities(push, p, start, t, Dop853{}, fine);
  REQUIRE(s.completed());
  CHECK(s.events.empty());
  CHECK(std::abs(s.Phi(0, 0) - (1 - F / v * (t - v / F))) < near);
  CHECK(std::abs(s.Phi(1, 0) + F / v) < near);
  CHECK(std::abs(s.Phi(0, 3) - (F * t / v - 1)) < near);  // by b
  const auto back = adjoint_sensitivities(push, p, start, t, end_value([](const auto& q) { return q[0]; }), Dop853{}, fine);
  REQUIRE(back.completed());
  CHECK(std::abs(back.by_start[0] - (1 - F / v * (t - v / F))) < near);
  CHECK(std::abs(back.by_parameters[1] - (F * t / v - 1)) < near);
  CHECK(back.by_parameters[2] == 0.0);
}

// q(4) = F p²/2 + F p (4 − p).
TEST_CASE("a force that ends at a time moves what comes behind it by that time") {
  const V3 p(1.0, 100.0, 1.3);
  const State<1> start{0.0, V1(0.0), V1(0.0)};
  const auto s = sensitivities(push, p, start, 4.0, Dop853{}, fine);
  REQUIRE(s.completed());
  CHECK(std::abs(s.Phi(0, 4) - 2.7) < near);
  CHECK(std::abs(s.Phi(1, 4) - 1.0) < near);
  CHECK(std::abs(s.Phi(0, 1) - 4.0) < near);  // a switch of time alone leaves Φ as it is
  const auto back = adjoint_sensitivities(push, p, start, 4.0, end_value([](const auto& q) { return q[0]; }), Dop853{}, fine);
  CHECK(std::abs(back.by_parameters[2] - 2.7) < near);
}

// V = F|q| from rest at q₀: period T = 4 √(2 q₀/F), and at t = T: ∂q̇/∂q₀ = F dT/dq₀ = √(8F/q₀), by hand. Both swing through 0 at the same moments.
TEST_CASE("guards of different coordinates that switch in one moment do not see each other") {
  const auto s = sensitivities(mechanical_system<2>(TwoVees{}), State<2>{0.0, V2(1.0, 2.0), V2(0.0, 0.0)}, 4 * std::sqrt(2.0), Dop853{}, fine);
  REQUIRE(s.completed());
  Eigen::Matrix4d right = Eigen::Matrix4d::Identity();
  right(2, 0) = right(3, 1) = std::sqrt(8.0);
  CHECK((s.Phi - right).cwiseAbs().maxCoeff() < 1e-7);
}

// The clock of published escapement models, q″ = −q − 2ζq′ + (|q| < b and q′ > 0 ? P : 0), three swings; by Taylor recurrences with saltation and by
// differences of the closed form, to 25 digits.
TEST_CASE("a family's members compare with their own parameters") {
  const auto family = [](const V3& p) {
    return problem(scene(mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.5 * q[0] * q[0]; }),
                         generalized_force([p](const auto& q, const auto& v) {
                           using std::abs;
                           auto Q = (-2.0 * p[0] * v).eval();
                           if (abs(q[0]) < p[1] && v[0] > 0.0) Q[0] += p[2];
                           return Q;
                         })),
                   State<1>{0.0, V1(-1.25), V1(0.0)});
  };
  const auto s = sensitivities(family, V3(0.05, 0.2, 1.0), 20.0, Dop853{}, fine, {.start = true});
  REQUIRE(s.completed());
  CHECK(std::abs(s.y[0] + 0.46737592919911470) < 10 * near);
  CHECK(std::abs(s.Phi(0, 1) - 0.7368159099987) < 10 * near);
  CHECK(std::abs(s.Phi(0, 2) - 4.0441855570301956) < 10 * near);
  CHECK(std::abs(s.Phi(0, 3) + 0.80325275173949) < 10 * near);
  CHECK(std::abs(s.Phi(1, 4) - 0.36998209526981) < 10 * near);
}

TEST_CASE("equal branches and kinks of the force leave Φ as it is") {
  // k/2 max(|q| − d, 0)², k = 4, d = 1/2, from 3/2: T = π + 4d/ω(A − d) = π + 1, and Φ = [1 0; s 1] with s = −4ωd/(A − d) = −4.
  const auto gap = system_of(unit_mass, [](const auto& q) {
    using std::abs, std::max;
    using S = std::decay_t<decltype(abs(q[0]))>;
    const S over = max(S(abs(q[0]) - 0.5), S(0.0));
    return 2.0 * over * over;
  });
  const auto s = sensitivities(gap, State<1>{0.0, V1(1.5), V1(0.0)}, 4.141592653589793, Dop853{}, fine);
  REQUIRE(s.completed());
  CHECK(std::abs(s.Phi(0, 0) - 1) + std::abs(s.Phi(0, 1)) + std::abs(s.Phi(1, 0) + 4) + std::abs(s.Phi(1, 1) - 1) < near);
}

TEST_CASE("what is a blow in a branch has no derivative") {
  const State<1> start{0.0, V1(-1.0), V1(2.0)};
  const auto step = [](const auto& q, const auto& t) {
    using S = std::decay_t<decltype(q[0] * t)>;
    return q[0] > 0.0 ? S(0.5 + 0.0 * t) : S(0.0 * t);
  };
  const auto heavier = [](const auto&, const auto& v, const auto& t) { return (t > 0.5 ? 2.0 : 0.5) * v[0] * v[0]; };
  const auto none = [](const auto& q) { return 0.0 * q[0]; };
  CHECK(refusal(system_of(unit_mass, step), start, 2.0).find("the potential energy") != std::string::npos);
  CHECK(refusal(system_of(heavier, none), start, 2.0, Outcome::refused_by_model).find("a momentum") != std::string::npos);  // as the motion itself
}

// q″ = −sign(q + q′) slides along q + q′ = 0 from t = 0.686 on, where both branches lead back to it.
TEST_CASE("a motion that slides along a comparison is named") {
  const auto relay = scene(mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.0 * q[0]; }),
                           generalized_force([](const auto& q, const auto& v) {
                             auto Q = (0.0 * v).eval();
                             Q[0] += q[0] + v[0] > 0.0 ? -1.0 : 1.0;
                             return Q;
                           }));
  const auto s = sensitivities(relay, State<1>{0.0, V1(0.5), V1(0.25)}, 2.0, Dop853{}, fine);
  CHECK(s.outcome == Outcome::not_differentiable);
  CHECK(std::abs(s.t - 0.6861406617) < 1e-7);
  CHECK(s.message.find("slides") != std::string::npos);
}

TEST_CASE("a motion that begins on a kink has no derivative by what leaves it") {
  const auto vee = system_of(unit_mass, [](const auto& q) {
    using std::abs;
    return abs(q[0]);
  });
  CHECK(refusal(vee, State<1>{0.0, V1(0.0), V1(1.0)}, 3.0).find("at t = 0 'the function abs in T or V'") != std::string::npos);
  // Beside it there is one: V = |q| over a period.
  const auto s = sensitivities(vee, State<1>{0.0, V1(1.0), V1(0.0)}, 4 * std::sqrt(2.0), Dop853{}, fine);
  CHECK(std::abs(s.Phi(1, 0) - std::sqrt(8.0)) + std::abs(s.Phi(0, 1)) < 10 * near);
}

// 1 N from t = 1 to 2 leads from rest at 0 to 8.5 and the velocity 1 at t = 10.
TEST_CASE("a run backwards goes through its switches, too") {
  const auto pulse = system_of(unit_mass, [](const auto& q, const auto& t) {
    using S = std::decay_t<decltype(q[0] * t)>;
    return t > 1.0 && t < 2.0 ? S(-1.0 * q[0]) : S(0.0 * q[0]);
  });
  const auto s = sensitivities(pulse, State<1>{10.0, V1(8.5), V1(1.0)}, 0.0, Dop853{}, fine);
  REQUIRE(s.completed());
  CHECK(std::abs(s.y[0]) + std::abs(s.y[1]) < near);
  CHECK(std::abs(s.Phi(0, 1) + 10.0) < near);
}

// A ball on a one-sided spring of 1e8, 50 bounces; by closed form, 25 digits. The slope of f jumps by 1e8, and no step gets over that by itself.
TEST_CASE("no step has to get over a jump that is too large for it") {
  const auto ball = system_of(unit_mass, [](const auto& q) {
    using std::min;
    using S = std::decay_t<decltype(q[0])>;
    const S in = min(S(q[0]), S(0.0));
    return 9.81 * q[0] + 0.5e8 * in * in;
  });
  const auto s = sensitivities(ball, State<1>{0.0, V1(0.25), V1(0.0)}, 22.75, Dop853{}, fine);
  REQUIRE(s.completed());
  CHECK(std::abs(s.Phi(0, 0) / 71.032003920507931 - 1) < near);
  CHECK(std::abs(s.Phi(1, 0) / 442.94460490127055 - 1) < near);
}

// x″ = −x, and beyond the place 1 a half more: with q₀ = 0 it comes to v₀, by sin t.
struct Shelf {
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const {
    using S = std::decay_t<decltype(q[0] * q[0])>;
    return 0.5 * q[0] * q[0] + (q[0] > 1.0 ? S(0.5 * (q[0] - 1.0)) : S(0.0 * q[0]));
  }
};

TEST_CASE("a motion that only touches a place beyond which the force is another has no derivative, and says so") {
  const auto system = mechanical_system<1>(Shelf{});
  for (const double rtol : {1e-8, 1e-10, 1e-12}) {
    const Options options{.rtol = rtol, .atol = rtol};
    const auto touching = sensitivities(system, State<1>{0.0, {0.0}, {1.0}}, 3.0, Dop853{}, options);
    INFO(touching.message);
    CHECK(touching.outcome == Outcome::not_differentiable);
    CHECK(touching.message.find("is only touched") != std::string::npos);
    const auto back = sensitivities(system, State<1>{3.0, {std::sin(3.0)}, {std::cos(3.0)}}, 0.0, Dop853{}, options);
    CHECK(back.outcome == Outcome::not_differentiable);
    // Beside it the derivatives are those of sin t, until the place is reached.
    const auto below = sensitivities(system, State<1>{0.0, {0.0}, {0.999}}, 3.0, Dop853{}, options);
    REQUIRE(below.outcome == Outcome::completed);
    CHECK(std::abs(below.Phi(0, 1) - std::sin(3.0)) < 100 * rtol);
    CHECK(std::abs(below.Phi(1, 1) - std::cos(3.0)) < 100 * rtol);
    CHECK(sensitivities(system, State<1>{0.0, {0.0}, {1.001}}, 3.0, Dop853{}, options).outcome == Outcome::completed);
  }
  const auto of_end = adjoint_sensitivities(system, State<1>{0.0, {0.0}, {1.0}}, 3.0, end_value([](const auto& q) { return q[0]; }), Dop853{}, fine);
  CHECK(of_end.outcome == Outcome::not_differentiable);
}
