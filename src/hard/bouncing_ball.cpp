// SPDX-License-Identifier: MIT
//
// A ball on the floor, restitution e: impact n at t_n = √(2h/g) (1 + 2(e + … + eⁿ⁻¹)); all of them before √(2h/g) (1 + e)/(1 − e).
#include <algorithm>

#include "hard/motion.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/integrate/runge_kutta.hpp"

namespace qdot::hard {
namespace {

constexpr double g = 9.81, e = 0.9;

template <class Method>
std::vector<Row> bounced_by(const Method& method) {
  const auto falling = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return g * q[0]; });
  const auto ball = scene(falling, contact("floor", [](const auto& q) { return q[0]; }, restitution(e)));
  auto meter = energy_balance(ball);
  const State<1> start{0.0, Vector<double, 1>(1.0), Vector<double, 1>(0.0)};
  const auto run = simulate(ball, start, 10.0, method, {.rtol = 2.5e-15, .atol = 1e-15}, meter);

  const double first = std::sqrt(2.0 / g), limit = 8.578949178728887184565411;
  double worst = 0.0, t = first, flight = 2 * first;
  for (std::size_t k = 0; k < 44; ++k, t += flight *= e)
    worst = std::max(worst, k < run.events.size() ? std::abs(run.events[k].t - t) / t : 1.0);
  Row impacts{.problem = "bouncing ball, 44 impact times", .method = std::string(Method::name) + ", 2.5e-15"};
  impacts.digits_reached = -std::log10(std::max(worst, 1e-17));
  impacts.digits_good = 15.65 - std::log10(44.0);  // each impact rounds its time, and hands that on
  impacts.evaluations = run.statistics.evaluations;
  impacts.seconds = run.statistics.wall_seconds;
  impacts.energy_drift_max = meter.balance().residual;
  impacts.outcome = name(run.outcome);

  // At rest from the last event on, which must be the limit but for hops too low to tell.
  Row rest = impacts;
  rest.problem = "bouncing ball, time of rest";
  const bool rests = run.completed() && std::abs(run.y[0]) < 1e-14 && std::abs(run.y[1]) < 1e-14;
  rest.digits_reached = rests ? -std::log10(std::abs(run.events.back().t - limit) / limit) : 0.0;
  // A hop of height y is told from rest down to 100 (rtol y + atol); the time of all further hops is like its root.
  const double hop = std::sqrt(8 * 100 * 1e-15 / g);
  rest.digits_good = -std::log10(hop / (1 - e) / limit);
  return {impacts, rest};
}

std::vector<Row> rows() {
  std::vector<Row> rows = bounced_by(Dop853{});
  for (Row& row : bounced_by(Dopri5{})) rows.push_back(row);
  return rows;
}

}  // namespace

Case bouncing_ball() {
  return {"bouncing_ball", "Bouncing ball",
          "Infinitely many impacts before t = 8.578949178728887, each hop 0.9 times as long as the last. Event finders miss or "
          "repeat impacts near the limit, or let the ball fall through. Here it must come to rest there and stay at rest.",
          rows};
}

}  // namespace qdot::hard
