// SPDX-License-Identifier: MIT
//
// Random scenes whose effects have states, a contact, dry friction, a controller and an input, through every analysis that takes them: each gives
// finite numbers in as many entries as there are, or says by name why it has none. At a state the laws of contact and friction are checked.
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>

#include "catch2_bridge.hpp"
#include "qdot/analysis/adjoint.hpp"
#include "qdot/analysis/generalized_alignment_index.hpp"
#include "qdot/analysis/damped_modes.hpp"
#include "qdot/analysis/linearization.hpp"
#include "qdot/analysis/lyapunov.hpp"
#include "qdot/analysis/lqr.hpp"
#include "qdot/analysis/return_map.hpp"
#include "qdot/analysis/steady_state.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/dry_friction.hpp"
#include "qdot/effects/input.hpp"
#include "qdot/effects/scene_at_state.hpp"
#include "seed.hpp"

namespace {

using namespace qdot;
using Eigen::Vector2d;

// A body on a slope in a plane, on springs.
struct Body {
  double m, k, g, tilt;
  auto T(const auto& v) const { return 0.5 * m * (v[0] * v[0] + v[1] * v[1]); }
  auto V(const auto& q) const { return 0.5 * k * q[0] * q[0] + m * g * (q[1] + tilt * q[0]); }
};

// ż = a q₀ − b z, Q₀ = −c z.
struct Lag {
  double a, b, c;
  Vector<double, 1> initial_state() const { return Vector<double, 1>(0.1); }
  template <class S, int n>
  Vector<S, n> force(const Vector<S, n>& q, const Vector<S, n>&, const Vector<S, 1>& z, const S&) const {
    Vector<S, n> Q = Vector<S, n>::Zero(q.size());
    Q[0] = -c * z[0];
    return Q;
  }
  template <class S, int n>
  Vector<S, 1> state_rate(const Vector<S, n>& q, const Vector<S, n>&, const Vector<S, 1>& z, const S&) const {
    return Vector<S, 1>(S(a * q[0] - b * z[0]));
  }
};

long cases() {
  const char* const given = std::getenv("QDOT_CASES");
  return given ? std::atol(given) : 4;
}

bool finite(const auto& x) { return x.size() == 0 || x.allFinite(); }

}  // namespace

TEST_CASE("scenes whose effects have states get finite numbers of every analysis, or the reason why not") {
  std::mt19937_64 random(fuzz::seed());
  const auto between = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  const auto one_of = [&](auto... values) {
    const double all[] = {values...};
    return all[std::uniform_int_distribution<std::size_t>(0, sizeof...(values) - 1)(random)];
  };
  for (long k = 0; k < cases(); ++k) {
    const double F_k = between(0.0, 3.0), F_s = F_k + one_of(0.0, 0.0, 1.0), e = one_of(0.0, 0.5, 1.0), bend = one_of(0.0, 0.3), rate = between(-2.0, 2.0);
    const Body body{between(0.5, 2.0), one_of(0.0, 3.0), one_of(0.0, 9.81), one_of(0.0, 0.4)};
    const auto gap = [bend](const auto& q) { return q[1] - bend * q[0] * q[0]; };
    const auto whole = scene(mechanical_system<2>(body), contact("floor", gap, restitution(e)), dry_friction("pad", 0, F_k, F_s),
                             Lag{between(-1.0, 1.0), between(0.1, 2.0), between(-1.0, 1.0)}, viscous_damping(Vector2d(one_of(0.0, 0.5), one_of(0.0, 0.5))),
                             input("push", 0, one_of(0.0, 1.0)));
    const double x = one_of(0.0, 0.3), v = one_of(0.0, 1.0, -1.0);
    const State<2> start{0.0, {x, bend * x * x + one_of(0.0, 0.0, 0.5)}, {v, 2.0 * bend * x * v + one_of(0.0, 0.0, rate)}};
    CAPTURE(fuzz::seed_text(), k, F_k, F_s, e, bend, body.m, body.k, body.g, body.tilt, start.q, start.qdot);
    const auto tried = [&](const char* what, const auto& ask) {
      try {
        if (!ask()) FAIL(std::string(what) + " is not finite, or of another size");
      } catch (const Error& error) {
        CHECK(std::string(error.what()).size() > 40);  // a sentence
      }
    };
    tried("a number at the state", [&] {
      const auto z = detail::states_at(whole, start);
      const Vector2d a = acceleration(whole, start), R = reactions(whole, start);
      const double slope = -2.0 * bend * x, lambda = R[1], least = 1e-9 * (1.0 + R.norm() + a.norm());  // J of the gap is (slope, 1)
      const double closing = a[1] + slope * a[0] - 2.0 * bend * v * v;
      CHECK(lambda >= -least);
      if (z[0] == 1.0) CHECK(std::abs(closing) < 100 * least);
      if (z[1] == 0.0) {
        CHECK(std::abs(a[0]) < least);
        CHECK(std::abs(R[0] - slope * lambda) <= F_s + least);
      }
      CHECK((inverse_dynamics(whole, start, a) - R).norm() < 100 * least);
      const auto J = acceleration_jacobian(whole, start);
      return std::isfinite(power(whole, start)) && J.d_q.allFinite() && J.d_qdot.allFinite();
    });
    tried("equilibrium_near", [&] {
      const auto found = equilibrium_near(whole, start.q);
      return found.z.allFinite() && found.lambda.allFinite() && acceleration(whole, found.state, found.z).norm() < 1e-6;
    });
    tried("linearization", [&] {
      const auto linear = linearization(whole, start);
      return linear.A.rows() == linear.A.cols() && finite(linear.A) && linear.B.cols() == 1 && finite(linear.B);
    });
    tried("modes and lqr", [&] {
      const auto linear = linearization(whole, equilibrium_near(whole, start.q));
      const Eigen::Index N = linear.A.rows();
      const auto modes = damped_modes(linear);
      if (!finite(modes.exponents) || modes.exponents.size() != N) return false;
      return finite(lqr(linear, Eigen::MatrixXd::Identity(N, N), Eigen::MatrixXd::Identity(1, 1)).K);
    });
    const Options loose{.rtol = 1e-8, .atol = 1e-10, .max_steps = 4000};
    tried("sensitivities and finite_time_lyapunov", [&] {
      const auto s = sensitivities(whole, start, 2.0, Dop853{}, loose);
      return s.Phi.cols() == 4 && s.Phi.rows() == s.y.size() && (!s.completed() || finite(finite_time_lyapunov(s.Phi).sigma));
    });
    tried("lyapunov_spectrum", [&] {
      const auto found = lyapunov_spectrum(whole, start, 3.0, Dop853{}, loose, {.interval = 0.5, .settle = 0.5});
      return finite(found.lambda) && (!found.completed() || (found.lambda.size() > 0 && found.lambda.size() <= 5));
    });
    tried("generalized_alignment_index", [&] {
      const auto found = generalized_alignment_index(whole, start, 3.0, Dop853{}, loose, {.interval = 0.5});
      for (const double index : found.index)
        if (!(index >= 0.0 && index <= 1.0 + 1e-9)) return false;
      return found.growth.empty() || std::isfinite(found.growth.back());
    });
    tried("return_map", [&] {
      const auto plane = event("plane", [](const auto& q, const auto& qdot) { return q[0] + 0.1 * qdot[0] - 0.05; });
      const auto found = return_map(whole, start, plane, 5.0, Dop853{}, loose);
      return finite(found.y) && finite(found.derivative) && (!found.complete() || found.derivative.cols() == 4);
    });
    tried("adjoint_sensitivities", [&] {
      const auto found = adjoint_sensitivities(whole, start, 1.0, end_value([](const auto& q, const auto& qdot) { return q[0] + qdot[1]; }), Dop853{}, loose);
      return !found.completed() || (std::isfinite(found.value) && finite(found.by_start));
    });
  }
}
