// SPDX-License-Identifier: MIT
//
// What accuracy costs with each method. For every problem and every error asked for, the cheapest tolerance (or step) that
// reaches it, its time and its evaluations, beside Dop853 at the same error.
#include "bench/steppers.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <string>
#include <vector>

#include "bench/chain_energies.hpp"
#include "qdot/integrate/any_system.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/symplectic.hpp"
#include "qdot/integrate/taylor.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/kepler.hpp"

namespace qdot::bench {
namespace {

template <class System>
void plane_rows(std::vector<Row>& rows, const MotionProblem& problem, const System& system) {
  MotionRows each(rows, problem);
  each.adaptive(system, Dop853{});
  each.adaptive(system, Dopri5{});
  each.adaptive(system, Taylor{});
  each.adaptive(system, CvodeAdams{});
  each.adaptive(system, CvodeBdf{});
  each.fixed("gauss, 4 stages", system, [](double step) { return Gauss{.step = step, .stages = 4}; });
  if constexpr (System::kinetic_signature == KineticSignature::velocity)
    for (const SplittingScheme scheme : {SplittingScheme::blanes_moan_4, SplittingScheme::blanes_moan_6, SplittingScheme::kahan_li_8})
      each.fixed(std::string(detail::splitting(scheme).name), system,
                 [scheme](double step) { return Splitting{.step = step, .scheme = scheme}; });
}

// What Taylor pays once for each system: running T and V, differentiating the record, laying out the sweep.
template <class System>
Row recording_time(const std::string& problem, const System& system) {
  double least = std::numeric_limits<double>::infinity();
  for (int round = 0; round < 20; ++round) {
    const auto before = std::chrono::steady_clock::now();
    const auto stepper = Taylor{}.stepper(first_order_form(system), {});
    const auto after = std::chrono::steady_clock::now();
    if (stepper.order() > 0) least = std::min(least, std::chrono::duration<double, std::micro>(after - before).count());
  }
  return {problem + ", making the taylor stepper", least, 0.0, "", "us"};
}

// What a run costs whose system is hidden, beside the same with its type.
template <class System>
Row hidden_run(const MotionProblem& problem, const System& system) {
  const Options options{.rtol = 1e-10, .atol = 1e-12, .keep_trajectory = false};
  const FirstOrderState start{0.0, Eigen::Map<const Eigen::VectorXd>(problem.start.data(), 2 * problem.n)};
  const AnySystem hidden = system;
  const auto seconds = [&](const auto& of) {
    double least = std::numeric_limits<double>::infinity();
    for (int round = 0; round < 10; ++round) {
      const auto before = std::chrono::steady_clock::now();
      const bool completed = simulate(of, start, problem.t_end, Dop853{}, options).completed();
      const auto after = std::chrono::steady_clock::now();
      if (completed) least = std::min(least, std::chrono::duration<double>(after - before).count());
    }
    return least;
  };
  const double known = seconds(system);
  return {problem.name + ", dop853 with the system's type hidden", seconds(hidden), known, "with its type", "s"};
}

Findings steppers() {
  Findings findings;
  const auto double_pendulum = mechanical_system<2>(scenes::DoublePendulum{});
  const auto planet = mechanical_system<2>(scenes::Kepler{});
  for (const MotionProblem& problem : motion_problems("double pendulum")) plane_rows(findings.rows, problem, double_pendulum);
  for (const MotionProblem& problem : motion_problems("kepler")) plane_rows(findings.rows, problem, planet);
  short_chain_rows(findings.rows);
  long_chain_rows(findings.rows);
  findings.rows.push_back(recording_time("double pendulum", double_pendulum));
  findings.rows.push_back(hidden_run(motion_problems("double pendulum").front(), double_pendulum));
  findings.rows.push_back(hidden_run(motion_problems("kepler").front(), planet));
  for (const int n : {8, 16}) findings.rows.push_back(recording_time("chain " + std::to_string(n), mechanical_system(n, LoopedChain{})));
  findings.note =
      "Minimum over several runs of the steps alone, without trajectory; errors against ends that are known to more digits "
      "(src/bench/motion_problems.hpp), relative to the largest entry of the end.";
  return findings;
}

}  // namespace

Benchmark benchmark() {
  return {"steppers", "time to reach an error with each method, beside dop853 at the same error", steppers};
}

}  // namespace qdot::bench
