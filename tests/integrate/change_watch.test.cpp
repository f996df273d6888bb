// SPDX-License-Identifier: MIT
#include "qdot/integrate/watch/change_watch.hpp"

#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <string>

#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/cvode_automatic.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/rattle.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/symplectic.hpp"

using namespace qdot;
using Eigen::Vector2d;

namespace {

using V1 = Vector<double, 1>;

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

constexpr double of_method = 1e-7;  // BDF's global error at rtol = 1e-9 over a period is 1e-8, the others' is less

const auto unit_mass = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; });
const State<1> released{0.0, V1(1.0), V1(0.0)};

// An oscillator of frequency 1 until t = 1 and w from then on, released from 1.
double after_change(double w, double t) { return std::cos(1.0) * std::cos(w * (t - 1)) - std::sin(1.0) / w * std::sin(w * (t - 1)); }

const auto at_one = [](const auto&, const auto&, const auto& t) { return t - 1.0; };

template <class System>
std::map<std::string, AnyMethod<System>> all_methods(const System&) {
  return {{"dop853", Dop853{}},   {"dopri5", Dopri5{}},      {"taylor", Taylor{}},         {"automatic", Automatic{}},
          {"bdf", CvodeBdf{}},    {"adams", CvodeAdams{}},   {"gauss", Gauss{.step = 0.01}}};
}

// What the force of a spring reads, kept where others can write to it.
struct Elsewhere {
  double stiffness = 1.0, push = 0.0;
};
const auto sprung = [](const Elsewhere& e) {
  return scene(unit_mass, generalized_force([&e](const auto& q, const auto&) { return vector(e.push - e.stiffness * q[0]); }));
};

}  // namespace

TEST_CASE("what a force reads may change in the action of an event, and every method feels it from there on") {
  Elsewhere e;
  const auto system = sprung(e);
  const auto stiffer = events(event("stiffer", at_one).action([&e](State<1>&) { e.stiffness = 4.0; }));
  for (const auto& [name, method] : all_methods(system)) {
    INFO(name);
    e = {};
    const auto run = simulate(system, released, 3.0, method, {}, stiffer);
    REQUIRE(run.completed());
    CHECK_THAT(run.y[0], WithinAbs(after_change(2.0, 3.0), of_method));  // −0.0347515
  }
}

TEST_CASE("a mass that changes at a stop time is felt by methods that factor M once") {
  double m = 1.0;
  const auto heavier = [&m](const StepView& step) { m = step.t() >= 1.0 ? 4.0 : 1.0; };
  const auto T = [&m](const auto& v) { return 0.5 * m * v.squaredNorm(); };
  const auto V = [](const auto& q) { return 0.5 * q.squaredNorm(); };
  const Options options{.stop_times = {1.0}};
  const double expected = after_change(0.5, 3.0);

  m = 1.0;
  CHECK_THAT(simulate(mechanical_system<1>(T, V), released, 3.0, Splitting{.step = 0.01}, options, heavier).y[0], WithinAbs(expected, of_method));
  const auto any_number = mechanical_system(1, T, V);
  const State<Dynamic> start{0.0, Eigen::VectorXd::Ones(1), Eigen::VectorXd::Zero(1)};
  m = 1.0;
  CHECK_THAT(simulate(any_number, start, 3.0, Dop853{}, options, heavier).y[0], WithinAbs(expected, of_method));
  m = 1.0;
  CHECK_THAT(simulate(any_number, start, 3.0, CvodeBdf{}, options, heavier).y[0], WithinAbs(expected, of_method));
  m = 1.0;
  const auto on_line = scene(mechanical_system<2>(T, V), holonomic("line", [](const auto& q) { return q[1]; }));
  CHECK_THAT(simulate(on_line, State<2>{0.0, Vector2d(1.0, 0.0), Vector2d(0.0, 0.0)}, 3.0, Rattle{.step = 0.01}, options, heavier).y[0],
             WithinAbs(expected, of_method));
}

TEST_CASE("a constraint that is turned in the action of an event holds in its new direction") {
  // On y = a x a unit mass in V = ½ x² has the frequency 1/√(1 + a²).
  double a = 0.0;
  const auto line = scene(mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return 0.5 * q[0] * q[0]; }),
                          holonomic("line", [&a](const auto& q) { return q[1] - a * q[0]; }));
  const auto turned = events(event("turned", at_one).action([&a](State<2>& s) {
    a = 1.0;
    s.q[1] = s.q[0];
    s.qdot[1] = s.qdot[0];
  }));
  for (const auto& [name, method] : std::map<std::string, AnyMethod<decltype(line)>>{{"dop853", Dop853{}}, {"taylor", Taylor{}}}) {
    INFO(name);
    a = 0.0;
    const auto run = simulate(line, State<2>{0.0, Vector2d(1.0, 0.0), Vector2d(0.0, 0.0)}, 3.0, method, {}, turned);
    REQUIRE(run.completed());
    CHECK_THAT(run.y[0], WithinAbs(after_change(1.0 / std::sqrt(2.0), 3.0), of_method));
    CHECK_THAT(run.y[1], WithinAbs(run.y[0], of_method));
  }
}

TEST_CASE("a sampled controller that writes at its stop times drives all methods the same way") {
  Elsewhere e;
  const auto system = sprung(e);
  Options options;
  for (int i = 1; i < 200; ++i) options.stop_times.push_back(0.01 * i);
  std::size_t next = 0;
  const auto sample = [&](const StepView& step) {
    if (next == options.stop_times.size() || step.t() != options.stop_times[next]) return;
    e.push = -40.0 * step.q()[0] - 8.0 * step.qdot()[0];
    ++next;
  };
  double first = 0.0;
  for (const auto& [name, method] : all_methods(system)) {
    INFO(name);
    e = {.stiffness = -9.81, .push = 0.0};  // it would fall
    next = 0;
    const auto run = simulate(system, State<1>{0.0, V1(0.3), V1(0.0)}, 2.0, method, options, sample);
    REQUIRE(run.completed());
    CHECK(std::abs(run.y[0]) < 1e-3);  // it stands
    if (first == 0.0) first = run.y[0];
    CHECK_THAT(run.y[0], WithinAbs(first, of_method));
  }
}

TEST_CASE("an observer that writes to what a force reads after every step ends the run by name, with every method") {
  Elsewhere e;
  const auto system = sprung(e);
  for (const auto& [name, method] : all_methods(system)) {
    INFO(name);
    e = {.stiffness = -9.81, .push = 0.0};
    const auto run = simulate(system, State<1>{0.0, V1(0.3), V1(0.0)}, 5.0, method, {},
                              [&e](const StepView& step) { e.push = -40.0 * step.q()[0] - 8.0 * step.qdot()[0]; });
    REQUIRE(run.outcome == Outcome::model_changed);
    CHECK(failed(run.outcome));
    CHECK(run.statistics.steps <= 7);
    CHECK(run.trajectory.back_time() == run.t);
    CHECK(contains(run.message, "functors must depend on nothing but their arguments, but the rate of qdot0 at t = "));
    CHECK(contains(run.message, std::string(advice(Outcome::model_changed))));
  }
}

TEST_CASE("what changes once between two stop times is found at the next of them, and what alternates is found as well") {
  Elsewhere e;
  const AnyMethod<decltype(sprung(e))> dop853 = Dop853{};
  const auto system = sprung(e);
  const auto run_with = [&](double t_end, const Options& options, const std::function<void(const StepView&)>& observer) {
    e = {};
    return simulate(system, released, t_end, dop853, options, observer);
  };
  const auto late = run_with(50.0, {.stop_times = {40.0}}, [&e](const StepView& step) { e.push = step.t() > 39.0 ? 1e-3 : 0.0; });
  CHECK(late.outcome == Outcome::model_changed);
  CHECK(late.t <= 40.0);
  long calls = 0;
  CHECK(run_with(1e3, {}, [&](const StepView&) { e.push = ++calls > 200 && calls % 2 == 0 ? 1e-3 : 0.0; }).outcome == Outcome::model_changed);
}

TEST_CASE("a force with a memory of its own is no function, and is told so") {
  double integral = 0.0;
  const auto pid = scene(unit_mass, generalized_force([&integral](const auto& q, const auto&) {
                           using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
                           if constexpr (std::is_same_v<S, double>) integral += 1e-3 * q[0];
                           return vector(S(-q[0] - integral));
                         }));
  const auto run = simulate(pid, released, 10.0, Dop853{});
  CHECK(run.outcome == Outcome::model_changed);
}

TEST_CASE("a recording that holds no longer is found even where nobody feels it") {
  // The force is zero, to the last bit, before q = 2.
  double k = 1.0;
  const auto far_away = scene(unit_mass, generalized_force([&k](const auto& q, const auto&) {
                                using std::exp;
                                return vector(-k * exp(1000.0 * (q[0] - 2.0)));
                              }));
  const State<1> start{0.0, V1(0.0), V1(1e-3)};
  const auto change = [&k](const StepView& step) { k = step.t() > 1.0 ? 2.0 : 1.0; };
  const auto run = simulate(far_away, start, 10.0, Taylor{}, {.max_step = 0.5}, change);
  CHECK(run.outcome == Outcome::model_changed);
  CHECK(contains(run.message, "has become another formula, or the same with another constant"));
}

TEST_CASE("a potential or a constraint that changes unseen ends the run as well") {
  double k = 1.0;
  const auto moved = [&k](const StepView& step) { k = step.t() > 1.0 ? 2.0 : 1.0; };
  const auto spring = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [&k](const auto& q) { return 0.5 * k * q[0] * q[0]; });
  CHECK(simulate(spring, released, 10.0, Dop853{}, {}, moved).outcome == Outcome::model_changed);
  k = 1.0;
  CHECK(simulate(spring, released, 10.0, CvodeBdf{}, {}, moved).outcome == Outcome::model_changed);  // whose error test it fails
  k = 1.0;
  // φ̈ does not know the radius, the projection does.
  const auto ring = scene(mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }),
                          holonomic("ring", [&k](const auto& q) { return q.squaredNorm() - k * k; }));
  const auto run = simulate(ring, State<2>{0.0, Vector2d(1.0, 0.0), Vector2d(0.0, 1.0)}, 10.0, Dop853{}, {},
                            [&k](const StepView& step) { k = step.t() > 1.0 ? 1.01 : 1.0; });
  CHECK(run.outcome == Outcome::model_changed);
  CHECK(contains(run.message, "the constraint 'ring'"));
}

TEST_CASE("a force that gets a kink in the action of an event is taken over by Dop853, and refused by Taylor with the motion so far") {
  bool rough = false;
  const auto system = scene(unit_mass, generalized_force([&rough](const auto& q, const auto&) {
                              using std::abs;
                              return vector(rough ? -abs(q[0]) * q[0] / q[0] : -q[0]);
                            }));
  const auto rougher = events(event("rougher", at_one).action([&rough](State<1>&) { rough = true; }));
  const auto run = simulate(system, released, 1.5, Automatic{}, {}, rougher);
  CHECK(run.completed());
  CHECK_THAT(run.y[0], WithinAbs(std::cos(1.5), of_method));  // |q| = q there
  CHECK(contains(run.statistics.method, "taylor, dop853"));
  rough = false;
  const auto refused = simulate(system, released, 1.5, Taylor{}, {}, rougher);
  CHECK(refused.outcome == Outcome::model_changed);
  CHECK(contains(refused.message, "the force of an effect uses the function abs"));
  CHECK_THAT(refused.trajectory.at(0.5).q[0], WithinAbs(std::cos(0.5), of_method));
}

TEST_CASE("noise as small as rounding is no change of the model") {
  // As of a sum whose order depends on threads, in a stiff system: 1e8 q is known to 1e-8 of itself near its equilibrium.
  std::mt19937 chance(7);
  const auto noisy = scene(mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }), generalized_force([&chance](const auto& q, const auto& v) {
                             const double noise = 1.0 + 2e-16 * std::uniform_real_distribution<double>(-1.0, 1.0)(chance);
                             return vector(-1e8 * (q[0] * noise - 1.0) - 1e4 * v[0]);
                           }));
  CHECK(simulate(noisy, released, 1.0, CvodeBdf{}, {.rtol = 1e-6}).completed());
  CHECK(simulate(noisy, State<1>{0.0, V1(1.1), V1(0.0)}, 0.01, Dop853{}, {.rtol = 1e-6}).completed());
}

TEST_CASE("honest systems give the same bits, however stiff, near to singular, huge or tiny they are") {
  const auto chain = [](double m, double k) {
    return mechanical_system(40, [m](const auto& v) { return 0.5 * m * v.squaredNorm(); },
                             [k](const auto& q) {
                               auto sum = 0.5 * k * q[0] * q[0];
                               for (Eigen::Index i = 1; i < q.size(); ++i)
                                 sum += 0.5 * k * (q[i] - q[i - 1]) * (q[i] - q[i - 1]) + 1e-3 * k * q[i] * q[i] * q[i] * q[i];
                               return sum;
                             });
  };
  Eigen::VectorXd q = Eigen::VectorXd::Zero(40);
  q[20] = 1.0;
  const State<Dynamic> plucked{0.0, q, Eigen::VectorXd::Zero(40)};
  for (const double scale : {1e-100, 1.0, 1e100}) {
    CHECK(simulate(chain(scale, 1e12 * scale), plucked, 1e-5, CvodeBdf{}, {.rtol = 1e-6, .atol = 1e-9}).completed());
    CHECK(simulate(chain(scale, scale), plucked, 20.0, CvodeBdf{}, {.rtol = 1e-6}).completed());
  }
  const auto nearly_singular = mechanical_system<2>(
      [](const auto& v) { return 0.5 * (v[0] + v[1]) * (v[0] + v[1]) + 0.5e-12 * v[1] * v[1]; },
      [](const auto& x) {
        using std::cos;
        return -cos(x[0] + x[1]) - 1e-12 * cos(x[1]);
      });
  CHECK(simulate(nearly_singular, State<2>{0.0, Vector2d(1.0, 2.0), Vector2d(0.0, 0.0)}, 20.0, Dop853{}, {.rtol = 1e-6}).outcome != Outcome::model_changed);
  const auto ball = scene(mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& x) { return 9.81 * x[0]; }),
                          contact("floor", [](const auto& x) { return x[0]; }, restitution(0.7)));
  CHECK(simulate(ball, released, 10.0, Dop853{}).completed());
}

TEST_CASE("a level that the observer moves at a stop time is no crossing, and counts from there on") {
  // x = cos t. Until t = 1 the level is −2, which x never meets; then it is 0.8 and above x.
  const double angle = std::acos(0.8), turn = 2 * std::acos(-1.0);
  const Options options{.rtol = 1e-10, .atol = 1e-10, .stop_times = {1.0}};
  const Elsewhere e;
  const auto system = sprung(e);
  for (const auto& [name, method] : all_methods(system)) {
    INFO(name);
    double level = -2.0;
    const auto raise = [&level](const StepView& step) {
      if (step.t() >= 1.0) level = 0.8;
    };
    const auto crossing = events(event("level", [&level](const auto& q) { return q[0] - level; }));
    const auto run = simulate(system, released, 8.0, method, options, raise, crossing);
    REQUIRE(run.completed());
    REQUIRE(run.events.size() == 2);
    CHECK_THAT(run.events[0].t, WithinAbs(turn - angle, of_method));
    CHECK_THAT(run.events[1].t, WithinAbs(turn + angle, of_method));
  }
}

TEST_CASE("a level that the observer moves between stop times ends the run by name") {
  double level = -2.0;
  const auto raise = [&level](const StepView& step) {
    if (step.t() >= 1.0) level = 0.8;
  };
  const auto crossing = events(event("level", [&level](const auto& q) { return q[0] - level; }));
  const auto run = simulate(unit_mass, released, 8.0, Dop853{}, {}, raise, crossing);
  CHECK(run.outcome == Outcome::model_changed);
  CHECK(contains(run.message, "that of 'level' at t = "));
  CHECK(run.events.empty());
}

namespace {
double global_stiffness = 1.0;
}

TEST_CASE("energies that read a global number which changes end the run by name") {
  const auto system = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                           [](const auto& q) { return 0.5 * global_stiffness * q[0] * q[0]; });
  const auto damped = scene(system, viscous_damping(V1(0.0)));
  const auto stiffen = [](const StepView& step) {
    if (step.t() >= 1.0) global_stiffness = 4.0;
  };
  const auto check = [&](const auto& model, const AnyMethod<std::decay_t<decltype(model)>>& method) {
    global_stiffness = 1.0;
    const auto run = simulate(model, released, 8.0, method, {}, stiffen);
    CHECK(run.outcome == Outcome::model_changed);
    CHECK(contains(run.message, "between events and stop times functors must depend on nothing but their arguments"));
  };
  check(system, Dop853{});
  check(system, CvodeBdf{});
  check(damped, Dop853{});
  global_stiffness = 1.0;
}

TEST_CASE("energies that count their calls end the run by the name of model_changed, whatever the number of calls in an evaluation is") {
  for (const int period : {2, 3}) {
    int calls = 0;
    const auto counting = mechanical_system<1>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [&calls, period](const auto& q) {
      return ++calls % period != 0 ? 1.0 * q[0] : -1.0 * q[0];
    });
    CHECK(simulate(counting, released, 1.0, Dop853{}).outcome == Outcome::model_changed);
  }
}
