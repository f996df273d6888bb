// SPDX-License-Identifier: MIT
//
// A push at t = 8, of width w and of area 1, on an oscillator of 1 rad/s that is at rest: q(t) = e^{−w²/2} sin(t − 8) behind it, since
// the convolution of a sine with a bell is a sine. All of it is missed by who does not look.
#include "qdot/integrate/watch/time_watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "../catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/dry_friction.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/simulate_to_accuracy.hpp"
#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/cvode_automatic.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/taylor.hpp"

using namespace qdot;

namespace {

constexpr double pushed_at = 8.0, t_end = 20.0, after = t_end - pushed_at;
constexpr double widths[] = {0.001, 0.003, 0.01, 0.03, 0.1, 0.2, 0.5, 1.0};
// rtol = 1e-9 over some tens of steps, most of them through the push; multistep methods add up more.
constexpr double one_step_tolerance = 1e-8, multistep_tolerance = 1e-6;

// The bell of width w about t = 8, of area 1.
template <class S>
S bell(const S& t, double w) {
  using std::exp;
  const S x = (t - pushed_at) / w;
  return exp(-0.5 * x * x) / (w * std::sqrt(2 * std::numbers::pi));
}

// What is left of a sine behind the bell.
double kept(double w) { return std::exp(-0.5 * w * w); }

constexpr auto unit_mass = [](const auto& qdot) { return 0.5 * qdot[0] * qdot[0]; };
constexpr auto unit_spring = [](const auto& q) { return 0.5 * q[0] * q[0]; };

// Where a push enters an oscillator, and how strongly.
struct Push {
  double spring = 1.0, T = 0.0, V = 0.0, wave = 0.0, force = 0.0, brake = 0.0, filter = 0.0;
};

// All of them in one type, for the compiler's sake; what is multiplied by zero leaves no trace in the formulas.
auto pushed(double w, const Push& by) {
  constexpr double wave_speed = 100.0;
  const auto system = mechanical_system<1>(
      [=](const auto&, const auto& qdot, const auto& t) {
        const auto v = qdot[0] + by.T * bell(t, w);
        return 0.5 * v * v;
      },
      [=](const auto& q, const auto& t) {
        using std::erf;
        const auto passed = erf((q[0] - wave_speed * (t - pushed_at)) / (wave_speed * w * std::numbers::sqrt2));
        return 0.5 * by.spring * q[0] * q[0] - by.V * q[0] * bell(t, w) - by.wave * 0.5 * wave_speed * passed;
      });
  return scene(system, generalized_force([=](const auto& q, const auto&, const auto& t) {
                 return Vector<std::remove_cvref_t<decltype(q[0])>, 1>(by.force * bell(t, w));
               }),
               rayleigh([=](const auto&, const auto& qdot, const auto& t) { return 0.5 * by.brake * bell(t, w) * qdot[0] * qdot[0]; }),
               controller([=](const auto&, const auto&, const auto& z,
                              const auto&) { return Vector<std::remove_cvref_t<decltype(z[0])>, 1>(by.filter * z[0]); },
                          [=](const auto&, const auto&, const auto& z, const auto& t) {
                            return Vector<std::remove_cvref_t<decltype(z[0])>, 1>(by.filter * bell(t, w) - z[0]);
                          },
                          Vector<double, 1>(0.0)));
}

using Pushed = decltype(pushed(1.0, Push{}));

State<1> start(double t, double q, double qdot) { return {t, Vector<double, 1>(q), Vector<double, 1>(qdot)}; }

struct Named {
  std::string name;
  AnyMethod<Pushed> method;
  double tolerance;
};
const std::vector<Named> one_step = {{"dop853", Dop853{}, one_step_tolerance}, {"taylor", Taylor{}, one_step_tolerance}};
const std::vector<Named> all_methods = {one_step[0],
                                        one_step[1],
                                        {"dopri5", Dopri5{}, one_step_tolerance},
                                        {"automatic", Automatic{}, one_step_tolerance},
                                        {"bdf", CvodeBdf{}, multistep_tolerance},
                                        {"adams", CvodeAdams{}, multistep_tolerance}};

}  // namespace

TEST_CASE("a push is felt however short it is, by every method, from rest and from a moving start") {
  for (const double w : widths) {
    const auto scene = pushed(w, {.V = 1.0});
    for (const auto& [name, method, tolerance] : all_methods)
      for (const double qdot : {0.0, 1.0}) {
        CAPTURE(w, name, qdot);
        const auto run = simulate(scene, start(0.0, 0.0, qdot), t_end, method);
        CHECK(run.completed());
        CHECK(std::abs(run.y[0] - (qdot * std::sin(t_end) + kept(w) * std::sin(after))) < tolerance);
        CHECK(run.statistics.time_resolution == 0.0);
        CHECK(run.statistics.steps < 3000);
      }
  }
}

TEST_CASE("a push is felt backward in time") {
  for (const double w : {0.001, 0.1})
    for (const auto& [name, method, tolerance] : all_methods) {
      CAPTURE(w, name);
      const auto run = simulate(pushed(w, {.V = 1.0}), start(t_end, 0.0, 0.0), 0.0, method);
      CHECK(run.completed());
      CHECK(std::abs(run.y[0] - kept(w) * std::sin(pushed_at)) < tolerance);  // q = −∫ sin(t − s) F(s) ds from t to t_end
    }
}

TEST_CASE("an accuracy is not promised for a motion that has missed a push") {
  for (const double w : {0.001, 0.01, 0.1, 0.5})
    for (const auto& [name, method, tolerance] : one_step) {
      CAPTURE(w, name);
      const double accuracy = 1e-6;  // of the largest q, which is at most 1
      const auto result = simulate_to_accuracy(pushed(w, {.V = 1.0}), start(0.0, 0.0, 0.0), t_end, method, accuracy);
      CHECK(result.reached());
      CHECK(std::abs(result.run.y[0] - kept(w) * std::sin(after)) < accuracy);
    }
}

TEST_CASE("a push is felt in whatever takes the time") {
  for (const double w : {0.001, 0.05, 0.5})
    for (const auto& [name, method, tolerance] : one_step) {
      CAPTURE(w, name);
      const auto end = [&](const Push& by, double qdot) {
        const auto run = simulate(pushed(w, by), start(0.0, 0.0, qdot), t_end, method);
        CHECK(run.completed());
        CHECK(run.statistics.time_resolution == 0.0);
        return run.y;
      };
      CHECK(std::abs(end({.force = 1.0}, 0.0)[0] - kept(w) * std::sin(after)) < tolerance);
      // A support that moves by ∫ bell: q̈ = −q − d(bell)/dt, and the convolution of −d(bell)/dt with a sine is that of −bell with a
      // cosine. Forces are of the size 1/w².
      CHECK(std::abs(end({.T = 1.0}, 0.0)[0] + kept(w) * std::cos(after)) < 10 * tolerance / w);
      // q̈ = −bell q̇ takes a factor e from a free velocity.
      CHECK(std::abs(end({.spring = 0.0, .brake = 1.0}, 1.0)[1] - std::exp(-1.0)) < tolerance);
      // ż = bell − z, q̈ = z − q: the answer of z to a blow, e^{−τ}, and that of q, (e^{−τ} + sin τ − cos τ)/2, convolved with the bell.
      CHECK(std::abs(end({.filter = 1.0}, 0.0)[0] - 0.5 * (std::exp(0.5 * w * w - after) + kept(w) * (std::sin(after) - std::cos(after)))) < tolerance);
    }
}

TEST_CASE("a wave that runs over a body is felt") {
  // A force in the shape of a bell, of area 1 in time, runs by at speed 100; the body runs at up to 1 while it does.
  constexpr double of_body = 0.02;
  for (const auto& [name, method, tolerance] : one_step)
    for (const double qdot : {0.0, 0.1}) {
      CAPTURE(name, qdot);
      const auto run = simulate(pushed(0.001, {.wave = 1.0}), start(0.0, 0.0, qdot), t_end, method);
      CHECK(run.completed());
      CHECK(std::abs(run.y[0] - std::sin(after) - qdot * std::sin(t_end)) < of_body);
    }
}

TEST_CASE("a push is felt in a drive") {
  // q₀ goes from 0 to 1 about t = 8 and holds one end of a spring, q₁ the other: q̈₁ = q₀ − q₁.
  const auto pair = mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); },
                                         [](const auto& q) { return 0.5 * (q[1] - q[0]) * (q[1] - q[0]); });
  for (const double w : {0.001, 0.05, 0.5}) {
    CAPTURE(w);
    const auto drive = prescribed("drive", 0, [w](const auto& t) {
      using std::erf;
      return 0.5 + 0.5 * erf((t - pushed_at) / (w * std::numbers::sqrt2));
    });
    const auto run = simulate(scene(pair, drive), State<2>{0.0, Vector<double, 2>::Zero(), Vector<double, 2>::Zero()}, t_end, Dop853{});
    CHECK(run.completed());
    CHECK(std::abs(run.y[1] - (1.0 - kept(w) * std::cos(after))) < 10 * one_step_tolerance);  // accelerations of the size 1/w²
  }
}

namespace {
// Where a force of area 1 begins and how long it lasts, written in several ways.
enum class Written { inside, outside, distance, table, stairs, parabola, with_state };
struct Branch {
  Written how = Written::inside;
  double begins = 1.0, lasts = 1e-3, spring = 0.0;

  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  template <class S>
  S V(const Vector<S, 1>& q, const S& t) const { return 0.5 * spring * q[0] * q[0] - q[0] * (is_on(q, t) ? S(1.0 / lasts) : S(0.0)); }
  template <class S>
  bool is_on(const Vector<S, 1>& q, const S& t) const {
    using std::abs, std::floor;
    const double ends = begins + lasts, period = 4.0;
    const double edges[] = {begins, ends};
    switch (how) {
      case Written::inside: return t > begins && t < ends;
      case Written::outside: return !(t <= begins) && !(t >= ends);
      case Written::distance: return abs(t - (begins + 0.5 * lasts)) < 0.5 * lasts;
      case Written::table: return std::upper_bound(edges, edges + 2, t, [](const auto& x, const auto& y) { return x < y; }) - edges == 1;
      case Written::stairs: return t < begins + period && t - period * floor((t - begins) / period) - begins < lasts && t > begins;
      case Written::parabola: return (t - begins) * (ends - t) > 0.0;
      case Written::with_state: return q[0] < 1e6 && t > begins && t < ends;
    }
    return false;
  }
};
constexpr Written all_ways[] = {Written::inside, Written::outside,  Written::distance,  Written::table,
                                Written::stairs, Written::parabola, Written::with_state};
constexpr double last_digits = 1e-14;  // of times: what rounding makes of the ends of a push, beside its length
}  // namespace

TEST_CASE("a push that is written with a branch is felt however short it is, by every method, at rest and in motion, in both directions") {
  std::vector<std::pair<std::string, AnyMethod<decltype(mechanical_system<1>(Branch{}))>>> methods = {
      {"dop853", Dop853{}}, {"dopri5", Dopri5{}}, {"automatic", Automatic{}}, {"bdf", CvodeBdf{}}, {"adams", CvodeAdams{}}, {"gauss", Gauss{.step = 0.1}}};
  for (const Written how : all_ways)
    for (const double lasts : {1e-3, 1e-6, 1e-8})
      for (const auto& [name, method] : methods) {
        CAPTURE(static_cast<int>(how), lasts, name);
        // ∫ sin(t − s) over the push divided by its length is sin(t − centre), but for a part lasts²/24.
        const double centre = 1.3 + 0.5 * lasts, error = multistep_tolerance + last_digits / lasts;
        const auto swinging = simulate(mechanical_system<1>(Branch{how, 1.3, lasts, 1.0}), start(0.0, 0.0, 1.0), 10.0, method);
        CHECK(std::abs(swinging.y[0] - (std::sin(10.0) + std::sin(10.0 - centre))) < error);
        const auto at_rest = simulate(mechanical_system<1>(Branch{how, 1.3, lasts, 0.0}), start(10.0, 0.0, 0.0), 0.0, method);
        CHECK(std::abs(at_rest.y[0] - centre) < error);
        CHECK((swinging.completed() && at_rest.completed() && at_rest.statistics.time_resolution == 0.0));
      }
}

TEST_CASE("a push that is written with a branch begins and ends within two units of time, also where time counts seconds since 1970") {
  for (const Written how : {Written::inside, Written::outside, Written::with_state})
    for (const double t0 : {0.0, 1.7e3, 1.7e6, 1.7e9}) {
      CAPTURE(static_cast<int>(how), t0);
      // An acceleration of 2 for half a second: a velocity of 1, and a way of 0.25 + 4.5. Beside it one unit of t for each of the two ends, times the velocity.
      const double unit = std::numeric_limits<double>::epsilon() * (t0 + 10.0);
      const auto run = simulate(mechanical_system<1>(Branch{how, t0 + 5.0, 0.5, 0.0}), start(t0, 0.0, 0.0), t0 + 10.0, Dop853{}, {.rtol = 1e-12});
      CHECK(run.completed());
      CHECK(std::abs(run.y[0] - 4.75) < 1e-11 + 2.0 * unit);
      CHECK(std::abs(run.y[1] - 1.0) < 1e-11 + 4.0 * unit);
    }
}

TEST_CASE("a functor that switches too often to be followed is looked at in samples, and the run says how closely") {
  // A force of 1 from t = 8 for 0.25, counted in stairs of 2⁻¹⁷: q = ∫ sin(t − s) ds.
  const auto system = mechanical_system<1>(unit_mass, [](const auto& q, const auto& t) {
    using std::floor;
    using S = std::remove_cvref_t<decltype(q[0])>;
    const auto stair = floor(t * 131072.0);
    return 0.5 * q[0] * q[0] - (stair >= 131072.0 * pushed_at && stair < 131072.0 * (pushed_at + 0.25) ? q[0] : S(0.0));
  });
  const double expected = std::cos(after - 0.25) - std::cos(after);
  for (const double qdot : {0.0, 1.0}) {
    const auto run = simulate(system, start(0.0, 0.0, qdot), t_end, Dop853{});
    CHECK(run.completed());
    CHECK(std::abs(run.y[0] - expected - qdot * std::sin(t_end)) < 1e-6);  // two jumps, each found by rejected steps
    CHECK(run.statistics.time_resolution == Approx(t_end / 256));
  }
  CHECK(simulate(system, start(0.0, 0.0, 0.0), t_end, Gauss{.step = 0.125}).statistics.time_resolution == Approx(0.125));
}

TEST_CASE("contacts and frictions find their phases behind a switch by time") {
  // A floor that drops by 100 at t = 1, under a ball at rest: it falls for a second. Backward in time, into such a floor, there is no answer.
  const auto free = mechanical_system<1>(unit_mass, [](const auto& q) { return 9.81 * q[0]; });
  const auto over = [&](double up, double down) {
    return scene(free, contact("floor", [=](const auto& q, const auto& t) { return q[0] - (abs(t) < 1.0 ? up : down); }));
  };
  for (const AnyMethod<decltype(over(0.0, 0.0))>& method : {AnyMethod<decltype(over(0.0, 0.0))>(Dop853{}), AnyMethod<decltype(over(0.0, 0.0))>(CvodeBdf{})}) {
    const auto falls = simulate(over(0.0, -100.0), start(0.0, 0.0, 0.0), 2.0, method);
    CHECK(falls.completed());
    CHECK(std::abs(falls.y[0] + 0.5 * 9.81) < multistep_tolerance);
    REQUIRE(falls.events.size() == 1);
    CHECK((falls.events[0].name == "floor opens" && std::abs(falls.events[0].t - 1.0) < last_digits));
    CHECK(simulate(over(0.0, -100.0), start(0.0, 0.0, 0.0), -2.0, method).outcome == Outcome::constraint_failure);
  }
  // A block that holds 1 is pushed by 3 for half a second: it gets to 1 m/s and to 1/4 m, and comes to rest after one more second, at 3/4 m.
  const auto block = scene(mechanical_system<1>(unit_mass), dry_friction("block", 0, 1.0), generalized_force([](const auto&, const auto&, const auto& t) {
                             using S = std::remove_cvref_t<decltype(t)>;
                             return Vector<S, 1>(t > 1.0 && t < 1.5 ? S(3.0) : S(0.0));
                           }));
  const auto moved = simulate(block, start(0.0, 0.0, 0.0), 5.0, Dop853{});
  CHECK((moved.completed() && moved.events.size() == 2));
  CHECK(std::abs(moved.y[0] - 0.75) < one_step_tolerance);
}

namespace {
// The same oscillator as a system of first order, in whose time nobody looks.
template <class Force>
struct Unwatched {
  static constexpr int size_at_compile_time = 2;
  Force F;
  Eigen::Index size() const { return 2; }
  void derivative(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot) const {
    ydot[0] = y[1];
    ydot[1] = F(t) - y[0];
  }
  void jacobian(double, const Eigen::Ref<const Eigen::VectorXd>&, Eigen::Ref<Eigen::MatrixXd> J) const { J << 0.0, 1.0, -1.0, 0.0; }
  std::string component_name(Eigen::Index i) const { return "y" + std::to_string(i); }
};
}  // namespace

TEST_CASE("time that is resolved anyway costs no steps") {
  const auto force = [](const auto& t) {
    using std::cos, std::sin;
    return sin(3.0 * t) + 0.1 * cos(t) * cos(t);
  };
  const auto system = mechanical_system<1>(unit_mass, [force](const auto& q, const auto& t) { return 0.5 * q[0] * q[0] - q[0] * force(t); });
  const Unwatched<decltype(force)> same{force};
  for (const double rtol : {1e-3, 1e-6, 1e-9, 1e-12}) {
    CAPTURE(rtol);
    const Options options{.rtol = rtol};
    const State<1> at = start(0.0, 1.0, 0.0);
    const long watched = simulate(system, at, 200.0, Dop853{}, options).statistics.steps;
    const long unwatched = simulate(same, at, 200.0, Dop853{}, options).statistics.steps;
    CHECK(static_cast<double>(watched) <= 1.02 * static_cast<double>(unwatched) + 2);
  }
}

TEST_CASE("where no signature takes the time nobody looks at it") {
  const auto oscillator = mechanical_system<1>(unit_mass, unit_spring);
  const auto damped =
      scene(oscillator, rayleigh([](const auto&, const auto& v) { return 0.5 * v[0] * v[0]; }), dry_friction("block", 0, 0.1),
            quadratic_drag([](const auto& q) { return q; }, 0.1), generalized_force([](const auto& q, const auto&) { return q; }),
            holonomic("pin", [](const auto& q) { return q[0]; }));
  STATIC_REQUIRE_FALSE(detail::TimeOf<decltype(first_order_form(oscillator))>::enters);
  STATIC_REQUIRE_FALSE(detail::TimeOf<decltype(first_order_form(damped))>::enters);
  STATIC_REQUIRE(detail::TimeOf<decltype(first_order_form(pushed(1.0, Push{})))>::enters);
}
