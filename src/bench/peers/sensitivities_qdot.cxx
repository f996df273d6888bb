// SPDX-License-Identifier: MIT
//
// sensitivities_qdot: Phi of the double pendulum from T and V; lines as sensitivities.hpp has them.
#include "bench/peers/sensitivities.hpp"

#include <qdot/analysis/sensitivity.hpp>

namespace {

struct DoublePendulum {
  auto T(const auto& q, const auto& v) const {
    using std::cos;
    return v[0] * v[0] + 0.5 * v[1] * v[1] + v[0] * v[1] * cos(q[0] - q[1]);
  }
  auto V(const auto& q) const {
    using std::cos;
    return -9.81 * (2.0 * cos(q[0]) + cos(q[1]));
  }
};

}  // namespace

int main() {
  const auto pendulum = qdot::mechanical_system<2>(DoublePendulum{});
  const qdot::State<2> start{0.0, {qdot::bench::released_from, qdot::bench::released_from}, {0.0, 0.0}};
  const auto options = [](double tolerance) { return qdot::Options{.rtol = tolerance, .atol = tolerance, .keep_trajectory = false}; };
  qdot::bench::print_lines(
      "qdot",
      [&](double tolerance, double* Phi) {
        const auto s = sensitivities(pendulum, start, qdot::bench::asked_at, qdot::Dop853{}, options(tolerance));
        for (int i = 0; i < 16; ++i) Phi[i] = s.Phi(i / 4, i % 4);
      },
      [&](double tolerance) { simulate(pendulum, start, qdot::bench::asked_at, qdot::Dop853{}, options(tolerance)); });
}
