// SPDX-License-Identifier: MIT
//
// Simulations in threads of their own share nothing: their results are those of one after another, bit for bit. ./check builds
// this folder with the thread sanitizer. SUNDIALS as Debian has it is not built with it: what its own code does to memory is not
// watched, only its calls of malloc and free, our callbacks, and everything of ours.
#include <cmath>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/taylor.hpp"

namespace {

using namespace qdot;
using Numbers = std::vector<double>;

struct DoublePendulum {
  auto T(const auto& q, const auto& qdot) const {
    using std::cos;
    return 0.5 * (2.0 * qdot[0] * qdot[0] + qdot[1] * qdot[1] + 2.0 * qdot[0] * qdot[1] * cos(q[0] - q[1]));
  }
  auto V(const auto& q) const {
    using std::cos;
    return -9.81 * (2.0 * cos(q[0]) + cos(q[1]));
  }
};

// Everything that a run returns, as numbers.
template <int n>
Numbers numbers_of(const Run<n>& run) {
  Numbers all(run.y.data(), run.y.data() + run.y.size());
  all.push_back(run.t);
  all.push_back(static_cast<double>(run.statistics.evaluations));
  for (const RecordedEvent& event : run.events) all.push_back(event.t);
  for (const double t : run.trajectory.times()) {
    const Eigen::VectorXd y = run.trajectory.y(t);
    all.insert(all.end(), y.data(), y.data() + y.size());
  }
  all.push_back(static_cast<double>(run.message.size()));
  return all;
}

// The systems are shared by all threads, as users share them.
const auto double_pendulum = mechanical_system<2>(DoublePendulum{});
// A pendulum in Cartesian coordinates that bounces off a wall: a constraint and events.
const auto bouncing =
    scene(mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return 9.81 * q[1]; }),
          holonomic("rod", [](const auto& q) { return q.squaredNorm() - 1.0; }),
          contact("wall", [](const auto& q) { return q[0] + 0.1; }, restitution(0.7)));

template <class Method>
Numbers swinging(const Method& method) {
  return numbers_of(simulate(double_pendulum, State<2>{0.0, Vector<double, 2>(1.7, 1.0), Vector<double, 2>(0.0, 0.3)}, 1.0, method,
                             {.rtol = 1e-8, .atol = 1e-8, .output_times = {0.3, 0.6}}));
}
template <class Method>
Numbers bounced(const Method& method) {
  return numbers_of(simulate(bouncing, State<2>{0.0, Vector<double, 2>(0.6, -0.8), Vector<double, 2>(0.0, 0.0)}, 1.5, method, {.rtol = 1e-7}));
}

// A run that ends by an exception of its own must not disturb the others.
Numbers thrown() {
  try {
    simulate(double_pendulum, State<2>{0.0, Vector<double, 2>(1.7, 1.0), Vector<double, 2>(0.0, NAN)}, 1.0, Dop853{});
  } catch (const Error& error) {
    return {static_cast<double>(std::string(error.what()).size())};
  }
  return {};
}

const std::vector<std::pair<std::string, std::function<Numbers()>>> jobs = {
    {"CvodeBdf", [] { return swinging(CvodeBdf{}); }},
    {"Dop853", [] { return swinging(Dop853{}); }},
    {"Taylor", [] { return swinging(Taylor{}); }},
    {"Gauss", [] { return swinging(Gauss{.step = 0.02}); }},
    {"Dop853 on a rod, against a wall", [] { return bounced(Dop853{}); }},
    {"an exception", thrown},
};

}  // namespace

TEST_CASE("runs in several threads at once give the bits of runs one after another, whatever the methods") {
  std::vector<Numbers> alone;
  for (const auto& [name, job] : jobs) alone.push_back(job());
  for (const Numbers& numbers : alone) REQUIRE_FALSE(numbers.empty());

  constexpr std::size_t threads = 4, rounds = 2;
  std::vector<std::vector<Numbers>> together(threads, std::vector<Numbers>(jobs.size() * rounds));
  std::vector<std::thread> running;
  for (std::size_t k = 0; k < threads; ++k)
    running.emplace_back([&together, k] {
      for (std::size_t i = 0; i < together[k].size(); ++i) together[k][i] = jobs[(i + 2 * k) % jobs.size()].second();  // each begins elsewhere
    });
  for (std::thread& thread : running) thread.join();

  for (std::size_t k = 0; k < threads; ++k)
    for (std::size_t i = 0; i < together[k].size(); ++i) {
      const std::size_t job = (i + 2 * k) % jobs.size();
      INFO(jobs[job].first);
      CHECK(together[k][i] == alone[job]);
    }
}
