// SPDX-License-Identifier: MIT
//
// What every method owes: its order, forward and backward in time, and the way back to where it began.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "../catch2_bridge.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/symplectic.hpp"
#include "qdot/integrate/taylor.hpp"

namespace {

using namespace qdot;

// A planet in Cartesian coordinates: nonlinear, of the kind that all methods take, and known in closed form.
struct Planet {
  auto T(const auto& qdot) const { return 0.5 * (qdot[0] * qdot[0] + qdot[1] * qdot[1]); }
  auto V(const auto& q) const {
    using std::sqrt;
    return -1.0 / sqrt(q[0] * q[0] + q[1] * q[1]);
  }
};
const auto planet = mechanical_system<2>(Planet{});

// The ellipse with semi-major axis 1 and e = 0.2, by Kepler's equation.
State<2> on_ellipse(double t) {
  const double e = 0.2;
  double E = t;
  for (int i = 0; i < 50; ++i) E -= (E - e * std::sin(E) - t) / (1 - e * std::cos(E));
  const double b = std::sqrt(1 - e * e), rate = 1 / (1 - e * std::cos(E));
  return {t, {std::cos(E) - e, b * std::sin(E)}, {-std::sin(E) * rate, b * std::cos(E) * rate}};
}

constexpr double t_start = 0.7;  // away from the apsides, where errors cancel by symmetry

template <class Method>
double error_at(double t_end, const Method& method, const Options& options) {
  const auto run = simulate(planet, on_ellipse(t_start), t_end, method, options);
  REQUIRE(run.completed());
  const State<2> end = run.state(), exact = on_ellipse(t_end);
  return std::max((end.q - exact.q).cwiseAbs().maxCoeff(), (end.qdot - exact.qdot).cwiseAbs().maxCoeff());
}

// Steps of one length from a method that chooses its own: no error is too large for it.
Options steps_of(double h) { return {.rtol = 0.9, .atol = 1e9, .initial_step = h, .max_step = h, .keep_trajectory = false}; }

template <class Run>
void check_order(const std::string& name, int order, double h, const Run& error) {
  for (const double t_end : {t_start + 2.0, t_start - 2.0}) {
    const double coarse = error(t_end, h), fine = error(t_end, h / 2);
    const double measured = std::log2(coarse / fine);
    INFO(name << " to t = " << t_end << ", errors " << coarse << ", " << fine << ", order " << measured);
    CHECK(measured > order - 0.6);
    CHECK(measured < order + 1.6);
  }
}

const std::vector<SplittingScheme> schemes = {SplittingScheme::verlet,        SplittingScheme::yoshida_4,  SplittingScheme::mclachlan_atela_4,
                                              SplittingScheme::blanes_moan_4, SplittingScheme::kahan_li_6, SplittingScheme::blanes_moan_6,
                                              SplittingScheme::kahan_li_8};

TEST_CASE("every method of fixed order converges with its order, forward and backward in time") {
  check_order("dopri5", 5, 0.1, [](double t_end, double h) { return error_at(t_end, Dopri5{}, steps_of(h)); });
  check_order("dop853", 8, 0.25, [](double t_end, double h) { return error_at(t_end, Dop853{}, steps_of(h)); });
  for (const int order : {4, 5, 8, 11}) {
    const double h = order < 8 ? 0.1 : 0.25;
    check_order("taylor " + std::to_string(order), order, h,
                [order](double t_end, double step) { return error_at(t_end, Taylor{.order = order}, steps_of(step)); });
  }
  for (const int stages : {1, 2, 3, 4, 5}) {
    const double h = stages < 3 ? 0.1 : stages < 5 ? 0.25 : 0.5;
    check_order("gauss " + std::to_string(stages), 2 * stages, h, [stages](double t_end, double step) {
      return error_at(t_end, Gauss{.step = step, .stages = stages}, {.keep_trajectory = false});
    });
  }
  for (const SplittingScheme scheme : schemes) {
    const auto [name, order, kicks, drifts] = detail::splitting(scheme);
    check_order(std::string(name), order, order < 4 ? 0.05 : order < 6 ? 0.1 : 0.2, [scheme](double t_end, double step) {
      return error_at(t_end, Splitting{.step = step, .scheme = scheme}, {.keep_trajectory = false});
    });
  }
}

TEST_CASE("the error of every adaptive method follows its tolerance, forward and backward in time") {
  const auto check = [](const auto& method, double largest) {
    for (const double t_end : {t_start + 10.0, t_start - 10.0}) {
      double before = 1.0;
      for (const double tol : {1e-5, 1e-7, 1e-9, 1e-11}) {
        const double error = error_at(t_end, method, {.rtol = tol, .atol = tol, .keep_trajectory = false});
        INFO(method.name << " to t = " << t_end << " with " << tol << ": " << error / tol << " tolerances");
        CHECK(error < largest * tol);
        CHECK(error < 0.2 * before);
        before = error;
      }
    }
  };
  // Ten time units move an error in the energy three times its size along the orbit for each of them; multistep methods
  // take more and shorter steps, each of which may spend its tolerance.
  check(Dopri5{}, 1000);
  check(Dop853{}, 300);
  check(Taylor{}, 100);
  check(CvodeAdams{}, 3000);
  check(CvodeBdf{}, 10000);
}

TEST_CASE("forth and back every adaptive method returns within its tolerance, and every reversible one to rounding") {
  const State<2> start = on_ellipse(t_start);
  const auto distance = [&](const auto& method, const Options& options) {
    const auto forth = simulate(planet, start, t_start + 10.0, method, options);
    const auto back = simulate(planet, forth.state(), t_start, method, options);
    REQUIRE(back.completed());
    CHECK(back.t == t_start);
    return std::max((back.state().q - start.q).cwiseAbs().maxCoeff(), (back.state().qdot - start.qdot).cwiseAbs().maxCoeff());
  };
  for (const double tol : {1e-6, 1e-9, 1e-12}) {
    const Options options{.rtol = tol, .atol = tol, .keep_trajectory = false};
    INFO("tolerance " << tol);
    CHECK(distance(Dopri5{}, options) < 1000 * tol);
    CHECK(distance(Dop853{}, options) < 300 * tol);
    CHECK(distance(Taylor{}, options) < std::max(300 * tol, 1e-13));
    CHECK(distance(CvodeAdams{}, options) < 3000 * tol);
    if (tol > 1e-10) CHECK(distance(CvodeBdf{}, options) < 10000 * tol);
  }
  // A thousand steps, each with its rounding.
  for (const int stages : {1, 2, 3, 4, 5}) CHECK(distance(Gauss{.step = 0.02, .stages = stages}, {.keep_trajectory = false}) < 1e-13);
  for (const SplittingScheme scheme : schemes) {
    INFO(detail::splitting(scheme).name);
    const double error = distance(Splitting{.step = 0.02, .scheme = scheme}, {.keep_trajectory = false});
    CHECK(error < (scheme == SplittingScheme::mclachlan_atela_4 ? 1e-6 : 1e-13));  // that one is no palindrome
  }
}

}  // namespace
