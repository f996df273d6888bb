// SPDX-License-Identifier: MIT
//
// Many motions of one system without lanes; tests/optimized/many_in_lanes.test.cpp has those that share packs.
#include "../catch2_bridge.hpp"

#include <cmath>
#include <cstddef>

#include "qdot/integrate/many_in_lanes.hpp"
#include "qdot/mechanics/system.hpp"

using namespace qdot;

namespace {

struct Spring {
  auto T(const auto&, const auto& qdot) const { return 0.5 * qdot.dot(qdot); }
  auto V(const auto& q) const { return 0.5 * q.dot(q); }
};

template <int n>
auto start_of(std::size_t i) {
  return State<n>{0.0, Vector<double, n>::Constant(2, 1.0 + 0.1 * static_cast<double>(i)), Vector<double, n>::Zero(2)};
}

template <class Sys, int n, class Method>
void check_that_bad_options_throw(const Sys& system, State<n> (*start)(std::size_t), const Method& method) {
  CHECK_THROWS_AS(ensemble(system, 2, start, 1.0, method, {.rtol = -1.0}), InvalidValue);
  CHECK_THROWS_AS(ensemble(system, 0, start, 1.0, method, {.rtol = std::nan("")}), InvalidValue);
  CHECK_THROWS_AS(ensemble(system, 2, start, 1.0, method, {.atol = -1.0}), InvalidValue);
  CHECK_THROWS_AS(ensemble(system, 2, start, std::nan(""), method, Options{}), InvalidValue);
}

TEST_CASE("options outside their range are refused once, not for each motion, whatever way motions go") {
  const auto system = mechanical_system<2>(Spring{});
  check_that_bad_options_throw(system, start_of<2>, Dop853{});
  check_that_bad_options_throw(system, start_of<2>, Dopri5{});
  CHECK_THROWS_AS(ensemble(system, 2, start_of<2>, 1.0, Dopri5{}, Options{.atol = Eigen::VectorXd(Eigen::VectorXd::Constant(3, 1e-9))}), DimensionError);
  check_that_bad_options_throw(mechanical_system(2, Spring{}), start_of<Dynamic>, Dop853{});
}

TEST_CASE("motions that are to be evaluated one way go alone, with the bits of such a run") {
  const auto system = mechanical_system<2>(Spring{});
  const Options by_duals{.by = By::duals};
  for (const auto& ends : {ensemble(system, 9, start_of<2>, 1.0, Dop853{}, by_duals),
                           ensemble(system.by(By::duals), 9, start_of<2>, 1.0, Dop853{}, Options{})})
    for (std::size_t i = 0; i < ends.size(); ++i)
      CHECK(ends[i].value->state.q == simulate(system, start_of<2>(i), 1.0, Dop853{}, by_duals).state().q);
}

TEST_CASE("motions that go alone end where the closed form does") {
  constexpr double accuracy = 1e-8;  // rtol 1e-10 over one unit of time
  const auto ends = ensemble(mechanical_system(2, Spring{}), 3, start_of<Dynamic>, 1.0, Dopri5{}, {.rtol = 1e-10, .atol = 1e-10});
  for (std::size_t i = 0; i < ends.size(); ++i) {
    REQUIRE(ends[i].completed());
    CHECK(std::abs(ends[i].value->state.q[1] - start_of<Dynamic>(i).q[1] * std::cos(1.0)) < accuracy);
  }
}

}  // namespace
