// SPDX-License-Identifier: MIT
//
// Two hundred runs that fail leave nothing behind: as many allocations are alive as before (and the leak sanitizer agrees), whatever
// the method and however the run ends.
#include <cmath>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "catch2_bridge.hpp"
#include "count.hpp"
#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/cvode_automatic.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/symplectic.hpp"
#include "qdot/integrate/taylor.hpp"

#if defined(QDOT_TEST_COUNTS_ALLOCATIONS)

namespace {

using namespace qdot;

struct Broken : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A particle that flies from x = 0.28 against x = 0.3, where its potential (0.3 − x)^(3/2) ends and its force becomes NaN; or, where
// it `throws`, the functor of the potential gives up shortly before.
struct Wall {
  bool throws = false;

  template <class S>
  S operator()(const Vector<S, 1>& q) const {
    using std::sqrt;
    if constexpr (requires { innermost_value(q[0]) > 0.29; }) {
      if (throws && innermost_value(q[0]) > 0.29) throw Broken("the wall gives way");
    }
    const S left = 0.3 - q[0];
    return left * sqrt(left);
  }
};
const auto speed = [](const auto& v) { return 0.5 * v[0] * v[0]; };
using Particle = decltype(mechanical_system<1>(speed, Wall{}));

// A particle whose mass 0.3 − x vanishes at x = 0.3.
const auto fading = mechanical_system<1>([](const auto& q, const auto& v) { return 0.5 * (0.3 - q[0]) * v[0] * v[0]; },
                                         [](const auto& q) { return -50.0 * q[0]; });

template <class System>
std::vector<std::pair<std::string, AnyMethod<System>>> methods() {
  std::vector<std::pair<std::string, AnyMethod<System>>> all = {{"dop853", Dop853{}}, {"taylor", Taylor{}}, {"bdf", CvodeBdf{}}};
  for (const int stages : {1, 2, 3, 4}) all.emplace_back("gauss" + std::to_string(2 * stages), Gauss{.step = 0.005, .stages = stages});
  if constexpr (std::is_same_v<System, Particle>) {
    all.insert(all.end(), {{"auto", Automatic{}}, {"dopri5", Dopri5{}}, {"adams", CvodeAdams{}}});
    for (const SplittingScheme scheme : {SplittingScheme::verlet, SplittingScheme::yoshida_4, SplittingScheme::mclachlan_atela_4,
                                         SplittingScheme::blanes_moan_4, SplittingScheme::kahan_li_6, SplittingScheme::blanes_moan_6,
                                         SplittingScheme::kahan_li_8})
      all.emplace_back(std::string(detail::splitting(scheme).name), Splitting{.step = 0.005, .scheme = scheme});
  }
  return all;
}

const State<1> start{0.0, Vector<double, 1>(0.28), Vector<double, 1>(1.0)};
const Options coarse{.rtol = 1e-5, .atol = 1e-5, .max_steps = 500, .output_times = {0.001, 0.01, 0.5}};
constexpr int runs = 200;

// Calls `once(i)`, which fails, so often that each method has its part of two hundred; returns how many more allocations are alive.
template <class Once>
long left_behind(std::size_t count, const Once& once) {
  for (std::size_t i = 0; i < count; ++i) once(i);  // what the C++ and C libraries keep for themselves from their first time on
  const long before = memory::alive;
  for (int run = 0; run < runs; ++run) once(static_cast<std::size_t>(run) % count);
  return memory::alive - before;
}

}  // namespace

TEST_CASE("two hundred runs against forces that become NaN leave nothing behind, whatever the method") {
  const auto particle = mechanical_system<1>(speed, Wall{});
  const auto all = methods<Particle>();
  REQUIRE(all.size() == 17);
  std::vector<int> failures(all.size(), 0);
  CHECK(left_behind(all.size(), [&](std::size_t i) {
          const auto alone = mechanical_system<1>(particle.energies());  // which keeps its derived lines, and machine code once there is some
          failures[i] += failed(simulate(alone, start, 1.0, all[i].second, coarse).outcome);
        }) == 0);
  for (std::size_t i = 0; i < all.size(); ++i) {
    INFO(all[i].first);
    CHECK(failures[i] > runs / 17);
  }
}

TEST_CASE("two hundred runs that end by an exception of the user's leave nothing behind, whatever the method") {
  const auto particle = mechanical_system<1>(speed, Wall{true});
  const auto all = methods<Particle>();
  int thrown = 0;
  CHECK(left_behind(all.size(), [&](std::size_t i) {
          try {
            (void)simulate(particle, start, 1.0, all[i].second, coarse);
          } catch (const Broken&) {
            ++thrown;
          } catch (const NotAnalytic&) {  // a series refuses a functor that looks at values
            ++thrown;
          }
        }) == 0);
  CHECK(thrown >= runs);
}

TEST_CASE("two hundred runs into a singular mass matrix leave nothing behind, whatever the method") {
  const auto all = methods<std::remove_const_t<decltype(fading)>>();
  std::vector<int> failures(all.size(), 0);
  CHECK(left_behind(all.size(), [&](std::size_t i) {
          const auto alone = mechanical_system<1>(fading.energies());  // which keeps its derived lines, and machine code once there is some
          failures[i] += failed(simulate(alone, start, 1.0, all[i].second, coarse).outcome);
        }) == 0);
  for (std::size_t i = 0; i < all.size(); ++i) {
    INFO(all[i].first);
    CHECK(failures[i] > runs / static_cast<int>(all.size()));
  }
}

TEST_CASE("two hundred starts that are refused leave nothing behind, whatever the method") {
  const auto particle = mechanical_system<1>(speed, Wall{});
  const auto all = methods<Particle>();
  int refused = 0;
  CHECK(left_behind(all.size(), [&](std::size_t i) {
          const State<1> beyond{0.0, Vector<double, 1>(0.5), Vector<double, 1>(1.0)};
          try {
            (void)simulate(particle, beyond, 1.0, all[i].second, coarse);
          } catch (const Error&) {
            ++refused;
          }
        }) == 0);
  CHECK(refused >= runs);
}

#endif
