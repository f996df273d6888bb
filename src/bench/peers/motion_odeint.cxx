// SPDX-License-Identifier: MIT
//
// motion_odeint [PROBLEM]: Boost.Odeint's controlled RKF78 and Dormand–Prince 5 on equations derived by hand; lines as motion_qdot's.
#include <array>
#include <boost/numeric/odeint.hpp>

#include "bench/peers/motion.hpp"

namespace {

using namespace qdot::bench;
namespace odeint = boost::numeric::odeint;

struct Measure {
  template <std::size_t size, class Rates>
  void operator()(const MotionProblem& problem, const Rates& rates) const {
    using Y = std::array<double, size>;
    with<size>(problem, rates, "odeint rkf78", odeint::runge_kutta_fehlberg78<Y>());
    with<size>(problem, rates, "odeint dopri5", odeint::runge_kutta_dopri5<Y>());
  }

  template <std::size_t size, class Rates, class Pair>
  static void with(const MotionProblem& problem, const Rates& rates, const char* name, const Pair& pair) {
    using Y = std::array<double, size>;
    print_cheapest(problem, name, [&](double tol, bool timed) {
      Y y{};
      const auto go = [&] {
        for (std::size_t i = 0; i < size; ++i) y[i] = problem.start[i];
        odeint::integrate_adaptive(odeint::make_controlled(tol, tol, pair),
                                   [&](const Y& at, Y& out, double) { rates(at.data(), out.data()); }, y, 0.0, problem.t_end, 0.01);
      };
      go();
      return std::pair(problem.error(y), timed ? least_microseconds(go) : 0.0);
    });
  }
};

}  // namespace

int main(int argc, char** argv) { for_each_problem(argc > 1 ? argv[1] : "", Measure{}); }
