// SPDX-License-Identifier: MIT
//
// What accuracy costs with each method: for every problem and every error asked for, the cheapest tolerance (or step) that
// reaches it, its time and its evaluations, beside Dop853 at the same error.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "bench/bench.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/symplectic.hpp"
#include "qdot/integrate/taylor.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/kepler.hpp"

namespace qdot::bench {
namespace {

// n links of mass 1 and length 1, absolute angles, velocities summed link by link.
struct NaturalChain {
  auto T(const auto& q, const auto& qdot) const {
    using std::cos, std::sin;
    using S = typename std::decay_t<decltype(q)>::Scalar;
    S vx(0.0), vy(0.0), sum(0.0);
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      vx += cos(q[k]) * qdot[k];
      vy += sin(q[k]) * qdot[k];
      sum += 0.5 * (vx * vx + vy * vy);
    }
    return sum;
  }
  auto V(const auto& q) const {
    using std::cos;
    using S = typename std::decay_t<decltype(q)>::Scalar;
    S y(0.0), sum(0.0);
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      y -= cos(q[k]);
      sum += 9.81 * y;
    }
    return sum;
  }
};

struct Measured {
  double setting = 0;  // tolerance, or step of a fixed-step method
  double error = 0;    // largest difference from the reference, beside its largest entry
  long evaluations = 0;
  double microseconds = 0;
};

template <class System, class Start, class Method>
Measured measured(const System& system, const Start& start, double t_end, const Eigen::VectorXd& exact, const Method& method,
                  const Options& options, double setting, bool timed) {
  Measured m{.setting = setting, .error = std::numeric_limits<double>::infinity()};
  const auto run = simulate(system, start, t_end, method, options);
  if (!run.completed()) return m;
  m.error = (run.y - exact).cwiseAbs().maxCoeff() / exact.cwiseAbs().maxCoeff();
  m.evaluations = run.statistics.evaluations;
  if (!timed) return m;
  // The steps alone: a stepper is made once and used for many runs. CPU-bound and short, so the least of several rounds is
  // the time without the machine's other business.
  const auto form = first_order_form(system);
  const Eigen::VectorXd y0 = form.packed(start);
  auto stepper = method.stepper(form, options);
  m.microseconds = std::numeric_limits<double>::infinity();
  const auto began = std::chrono::steady_clock::now();
  for (int round = 0; round < 200; ++round) {
    const auto before = std::chrono::steady_clock::now();
    stepper.reset(start.t, y0);
    while (stepper.t() != t_end && stepper.step(t_end)) {
    }
    const auto after = std::chrono::steady_clock::now();
    m.microseconds = std::min(m.microseconds, std::chrono::duration<double, std::micro>(after - before).count());
    if (round >= 4 && after - began > std::chrono::milliseconds(200)) break;
  }
  return m;
}

// The cheapest of a family of settings that reaches an error; evaluations decide, then it is timed.
template <class Family>
std::optional<Measured> cheapest(const Family& family, const std::vector<double>& settings, double error) {
  for (const double setting : settings) {  // from cheap to dear
    if (family(setting, false).error <= error) return family(setting, true);
  }
  return std::nullopt;
}

std::vector<double> powers_of_ten(double from, double to, int per_decade) {
  std::vector<double> result;
  for (double x = std::log10(from); x >= std::log10(to) - 1e-9; x -= 1.0 / per_decade) result.push_back(std::pow(10.0, x));
  return result;
}

template <class System, class Start>
void measure(std::vector<Row>& rows, const std::string& problem, const System& system, const Start& start, double t_end) {
  const Eigen::VectorXd exact =
      simulate(system, start, t_end, Taylor{}, {.rtol = 2.5e-15, .atol = 1e-16, .keep_trajectory = false}).y;
  const auto adaptive = [&](const auto& method) {
    return [&, method](double tol, bool timed) {
      return measured(system, start, t_end, exact, method, {.rtol = tol, .atol = tol, .keep_trajectory = false}, tol, timed);
    };
  };
  [[maybe_unused]] const auto gauss = [&](double step, bool timed) {
    return measured(system, start, t_end, exact, Gauss{.step = step, .stages = 4}, {.keep_trajectory = false}, step, timed);
  };
  const std::vector<double> tolerances = powers_of_ten(1e-3, 1e-14, 2);
  const std::vector<double> steps = powers_of_ten(t_end / 10, t_end / 1e4, 4);
  for (const double error : {1e-6, 1e-9, 1e-12}) {
    const auto baseline = cheapest(adaptive(Dop853{}), tolerances, error);
    const auto add = [&](const char* method, const std::optional<Measured>& m) {
      char text[200];
      if (m) {
        std::snprintf(text, sizeof text, "%s, error <= %.0e, %s: setting %.1e, error %.1e, %ld evaluations", problem.c_str(), error,
                      method, m->setting, m->error, m->evaluations);
      } else {
        std::snprintf(text, sizeof text, "%s, error <= %.0e, %s: not reached", problem.c_str(), error, method);
      }
      rows.push_back({text, m ? m->microseconds : 0.0, m && baseline ? baseline->microseconds : 0.0, "dop853", "us"});
    };
    add("dop853", baseline);
    add("taylor", cheapest(adaptive(Taylor{}), tolerances, error));
    if (error >= 1e-6) add("dopri5", cheapest(adaptive(Dopri5{}), tolerances, error));
    if constexpr (System::kinetic_signature == KineticSignature::velocity) {
      for (const SplittingScheme scheme : {SplittingScheme::blanes_moan_4, SplittingScheme::blanes_moan_6, SplittingScheme::kahan_li_8})
        add(std::string(detail::splitting(scheme).name).c_str(), cheapest(
                                                                     [&](double step, bool timed) {
                                                                       return measured(system, start, t_end, exact,
                                                                                       Splitting{.step = step, .scheme = scheme},
                                                                                       {.keep_trajectory = false}, step, timed);
                                                                     },
                                                                     steps, error));
    }
    if constexpr (System::dof_at_compile_time == 2)
      if (error >= 1e-9) add("gauss, 4 stages", cheapest(gauss, steps, error));
  }
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

Findings steppers() {
  Findings findings;
  const auto double_pendulum = mechanical_system<2>(scenes::DoublePendulum{});
  measure(findings.rows, "double pendulum, t=3", double_pendulum, State<2>{0.0, {1.7, 1.7}, {0.0, 0.0}}, 3.0);
  findings.rows.push_back(recording_time("double pendulum", double_pendulum));
  measure(findings.rows, "Kepler e=0.6, 10 periods", mechanical_system<2>(scenes::Kepler{}),
          State<2>{0.0, {0.4, 0.0}, {0.0, 2.0}}, 62.83185307179586);
  const auto chain_of_4 = mechanical_system<4>(NaturalChain{});
  measure(findings.rows, "chain n=4, t=3", chain_of_4,
          State<4>{0.0, Vector<double, 4>::Constant(1.7), Vector<double, 4>::Zero()}, 3.0);
  for (const int n : {8, 16}) {
    const auto chain = mechanical_system(n, NaturalChain{});
    const std::string name = "chain n=" + std::to_string(n) + " at run time";
    measure(findings.rows, name + ", t=2", chain,
            State<Dynamic>{0.0, Eigen::VectorXd::Constant(n, 1.7), Eigen::VectorXd::Zero(n)}, 2.0);
    findings.rows.push_back(recording_time(name, chain));
  }
  findings.note =
      "Minimum over several runs of the steps alone, without trajectory; errors against taylor at rtol 2.5e-15, relative to "
      "the largest entry of the end state.";
  return findings;
}

}  // namespace

Benchmark steppers_benchmark() {
  return {"steppers", "time to reach an error with each method, beside dop853 at the same error", steppers};
}

}  // namespace qdot::bench
