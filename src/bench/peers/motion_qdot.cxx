// SPDX-License-Identifier: MIT
//
// motion_qdot [PROBLEM]: the time that qdot needs from T and V to each error; one line "problem;error;method;setting;reached;microseconds".
#include "bench/chain_energies.hpp"
#include "bench/peers/motion.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/taylor.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/kepler.hpp"

namespace {

using namespace qdot;
using namespace qdot::bench;

template <class System, class Method>
void measured(const MotionProblem& problem, const System& system, const Method& method) {
  const auto form = first_order_form(system);
  const Eigen::VectorXd y0 = Eigen::Map<const Eigen::VectorXd>(problem.start.data(), 2 * problem.n);
  print_cheapest(problem, std::string(Method::name), [&](double tol, bool timed) {
    auto stepper = method.stepper(form, {.rtol = tol, .atol = tol});
    const auto go = [&] {
      stepper.reset(0.0, y0);
      while (stepper.t() != problem.t_end && stepper.step(problem.t_end)) {
      }
    };
    go();
    const double error = stepper.t() == problem.t_end ? problem.error(stepper.y()) : INFINITY;
    return std::pair(error, timed ? least_microseconds(go) : 0.0);
  });
}

template <class System>
void measured(const MotionProblem& problem, const System& system) {
  measured(problem, system, Dop853{});
  if constexpr (System::dof_at_compile_time <= 4) measured(problem, system, Dopri5{});
  measured(problem, system, Taylor{});
}

template <int n>
void chain(const MotionProblem& problem) {
  if constexpr (n <= 4) {
    measured(problem, mechanical_system<n>(LoopedChain{}));
  } else if constexpr (n <= 8) {
    measured(problem, mechanical_system<n>(UnrolledChain<n>{}));
  } else {
    measured(problem, mechanical_system<n>(LoopedChain{}));
  }
}

}  // namespace

int main(int argc, char** argv) {
  for (const MotionProblem& problem : motion_problems(argc > 1 ? argv[1] : "")) {
    if (problem.name.starts_with("kepler")) {
      measured(problem, mechanical_system<2>(scenes::Kepler{}));
    } else if (problem.name.starts_with("double")) {
      measured(problem, mechanical_system<2>(scenes::DoublePendulum{}));
    } else {
      switch (problem.n) {
        case 1: chain<1>(problem); break;
        case 2: chain<2>(problem); break;
        case 3: chain<3>(problem); break;
        case 4: chain<4>(problem); break;
        case 6: chain<6>(problem); break;
        case 8: chain<8>(problem); break;
        case 12: chain<12>(problem); break;
        case 16: chain<16>(problem); break;
        default: break;
      }
    }
  }
}
