// SPDX-License-Identifier: MIT
//
// What a run can be asked: where to land and what to keep, what to do when something happens, and what it cost. A carriage on a spring is
// driven to its place by a controller with a state of its own. A skate moves on a slope, and its blade lets it go only ahead.

#include <cmath>
#include <cstdio>
#include <string>

#include <qdot/effects/constraints.hpp>
#include <qdot/effects/dissipation.hpp>
#include <qdot/effects/forces.hpp>
#include <qdot/effects/scene_at_state.hpp>
#include <qdot/integrate/event.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/simulate.hpp>
#include <qdot/report/csv.hpp>
#include <qdot/report/motion_table.hpp>

using namespace qdot;

// Where the carriage shall be.
const auto wanted = [](const auto& t) { return t < 1.0 ? 0.1 : 0.3; };

int main() {
  const auto carriage = mechanical_system<1>([](const auto&, const auto& v) { return 0.5 * v[0] * v[0]; },
                                             [](const auto& q) { return 20.0 * q[0] * q[0]; });
  const auto positioner = controller([](const auto& q, const auto&, const auto& z, const auto& t) { return vector(30.0 * (wanted(t) - q[0]) + z[0]); },
                                     [](const auto& q, const auto&, const auto&, const auto& t) { return vector(100.0 * (wanted(t) - q[0])); }, vector(0.0));
  const auto scene = qdot::scene(carriage, viscous_damping(vector(6.0)), positioner);
  const State<1> start{0.0, {0.0}, {0.0}};

  const auto arrives = event("is near", [](const auto& q) { return q[0] - 0.29; });        // recorded, in either direction
  const auto knocked = event("knock", [](const auto& q) { return q[0] - 0.15; }).rising().action([](State<1>& s) { s.qdot[0] -= 0.2; });
  const auto too_far = event("too far", [](const auto& q) { return q[0] - 0.5; }).stop();  // ends the run
  Options options{.rtol = 1e-10, .atol = {1e-12, 1e-12, 1e-10}};  // atol for q, q̇ and z
  options.stop_times = {1.0};                                     // the wanted place jumps: land there
  options.output_times = {0.5, 1.0, 2.0, 8.0};
  const auto run = simulate(scene, start, 8.0, Dop853{}, options, events(arrives, knocked, too_far));

  std::printf("%s\n", run.message.c_str());
  for (std::size_t k = 0; k < run.samples.t.size(); ++k) std::printf("q(%.1f) = %.6f\n", run.samples.t[k], run.samples.y(0, static_cast<Eigen::Index>(k)));
  for (const RecordedEvent& e : run.events) std::printf("%-8s  t = %.6f\n", e.name.c_str(), e.t);

  const double t_knock = run.events.front().t;  // both sides of a jump are kept
  std::printf("the knock: qdot = %.4f, then %.4f\n\n", run.trajectory.before(t_knock).qdot[0], run.trajectory.at(t_knock).qdot[0]);

  const Statistics& cost = run.statistics;
  std::printf("%s: %ld steps, %ld rejected, %ld fresh starts\n", cost.method.c_str(), cost.steps, cost.rejected(), cost.restarts);

  const std::string table = report::csv(report::motion_table(scene, run, 401));  // report::write_files({{"run.csv", table}}) makes a file of it
  std::printf("a table of %s\n\n", table.substr(0, table.find('\n')).c_str());

  // The blade: no velocity across it, sin θ ẋ = cos θ ẏ. On a slope it goes aside in a cycloid, and not down.
  const auto body = mechanical_system<3>([](const auto&, const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return -2.0 * q[0]; });
  const auto blade = nonholonomic("blade", [](const auto& q, const auto& v) {
    using std::cos, std::sin;
    return sin(q[2]) * v[0] - cos(q[2]) * v[1];
  });
  const auto skate = qdot::scene(body, blade);
  const State<3> spinning{0.0, Vector<double, 3>(0.0, 0.0, 0.0), Vector<double, 3>(0.0, 0.0, 1.0)};
  const double pi = std::acos(-1.0);
  const auto glide = simulate(skate, spinning, pi, Dop853{}, {.rtol = 1e-10});
  const State<3> lowest = glide.trajectory.at(pi / 2), end = glide.state();  // x = sin² t, y = t − sin t cos t
  std::printf("the skate at its lowest: x = %.6f, y = %.6f, and the blade bears %.6f\n", lowest.q[0], lowest.q[1], reactions(skate, lowest).norm());
  std::printf("back on its level:       |x| < 1e-8: %d, y = %.6f\n", std::abs(end.q[0]) < 1e-8, end.q[1]);
}
