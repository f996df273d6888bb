// SPDX-License-Identifier: MIT
//
// Formulas have the values that duals give: every name in them is looked up, every sum and product carried out.
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include "catch2_bridge.hpp"
#include "qdot/mechanics/energy.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/mechanics/mass_matrix.hpp"
#include "qdot/report/equations.hpp"
#include "scenes/atwood.hpp"
#include "scenes/bead_on_hoop.hpp"
#include "scenes/cartpole.hpp"
#include "scenes/chain.hpp"
#include "scenes/chaplygin_sleigh.hpp"
#include "scenes/charged_particle.hpp"
#include "scenes/coupled_oscillators.hpp"
#include "scenes/cycloid.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/elastic_pendulum.hpp"
#include "scenes/four_bar.hpp"
#include "scenes/heavy_top.hpp"
#include "scenes/henon_heiles.hpp"
#include "scenes/kepler.hpp"
#include "scenes/mathieu.hpp"
#include "scenes/morse.hpp"
#include "scenes/rod_and_ring.hpp"
#include "scenes/rolling_hoop.hpp"
#include "scenes/slider_crank.hpp"
#include "scenes/spherical_pendulum.hpp"

namespace {

using namespace qdot;
using report::Expression;

// Sums of some dozen terms that may cancel, and M with a condition of at most 1e3.
constexpr double rounding = 1e-9;

struct Values {
  std::map<std::string, double> of[3];  // by the dots above the name

  double operator()(const Expression& e) const {
    switch (e.kind) {
      case Expression::Kind::symbol: return of[e.dots].at(e.name);
      case Expression::Kind::sum: {
        double sum = 0.0;
        for (const Expression& part : e.parts) sum += (*this)(part);
        return sum;
      }
      case Expression::Kind::product: {
        double product = e.number;
        for (const Expression& part : e.parts) product *= (*this)(part);
        for (const Expression& divisor : e.divisors) product /= (*this)(divisor);
        return product;
      }
      case Expression::Kind::power: return std::pow((*this)(e.parts[0]), e.number);
      case Expression::Kind::function: break;
    }
    static const std::map<std::string, std::function<double(double)>> functions = {
        {"sin", [](double x) { return std::sin(x); }}, {"cos", [](double x) { return std::cos(x); }}, {"exp", [](double x) { return std::exp(x); }},
        {"ln", [](double x) { return std::log(x); }},  {"tanh", [](double x) { return std::tanh(x); }}};
    return functions.at(e.name)((*this)(e.parts[0]));
  }
};

class Comparison {
 public:
  template <int n, class E>
  void operator()(const std::string& name, const E& energies, const std::vector<std::string>& coordinates,
                  const std::vector<report::NamedParameter<E>>& parameters) {
    INFO(name);
    const auto dof = static_cast<Eigen::Index>(coordinates.size());
    const report::Equations e = report::equations_of(report::equation_source<n>(energies, coordinates, parameters));
    for (int trial = 0; trial < 3; ++trial) {
      E changed = energies;
      Values values;
      for (const auto& p : parameters) {
        double& value = changed.*p.member;
        if (trial > 0) value = value == 0.0 ? random(0.1, 0.5) : value * random(0.6, 1.5);
        values.of[0][p.name] = changed.*p.member;
      }
      Vector<double, n> q(dof), v(dof);
      const double t = random(0.0, 2.0);
      for (Eigen::Index i = 0; i < dof; ++i) {
        values.of[0][coordinates[static_cast<std::size_t>(i)]] = q[i] = random(0.3, 1.3);
        values.of[1][coordinates[static_cast<std::size_t>(i)]] = v[i] = random(-1.0, 1.0);
      }
      if (!values.of[0].contains("t")) values.of[0]["t"] = t;
      const auto system = [&] {
        if constexpr (n == Dynamic) {
          return mechanical_system(dof, changed);
        } else {
          return mechanical_system<n>(changed);
        }
      }();
      const auto a = acceleration(system, q, v, t);
      const auto M = mass_matrix(system, q, v, t);
      const auto p = conjugate_momenta(system, q, v, t);
      for (Eigen::Index i = 0; i < dof; ++i) values.of[2][coordinates[static_cast<std::size_t>(i)]] = a[i];
      const auto same = [](double formula, double number) { CHECK_THAT(formula, WithinAbs(number, rounding * (1.0 + std::abs(number)))); };
      same(values(e.L), lagrangian(system, q, v, t));
      const Eigen::VectorXd force = M * a;
      for (Eigen::Index i = 0; i < dof; ++i) {
        const auto k = static_cast<std::size_t>(i);
        same(values(e.p[k]), p[i]);
        same(values(e.r[k]), force[i]);
        for (Eigen::Index j = 0; j <= i; ++j) same(values(e.M[k][static_cast<std::size_t>(j)]), M(i, j));
        same(values(e.rows[k].left) - values(e.rows[k].right), 0.0);
        if (!e.qddot.empty()) same(values(e.qddot[k].right), a[i]);
      }
    }
  }

  template <class E, int n>
  void scene(const scenes::Scene<E, n>& s, const E& energies = {}) {
    std::vector<std::string> names;
    std::vector<report::NamedParameter<E>> parameters;
    for (const auto& c : s.coordinates(energies)) names.push_back(c.name);
    for (const auto& p : s.parameters)
      if (const auto* member = std::get_if<double E::*>(&p.member)) parameters.push_back({p.name, *member});
    this->template operator()<n>(s.name, energies, names, parameters);
  }

 private:
  double random(double least, double most) { return std::uniform_real_distribution<double>(least, most)(engine_); }
  std::mt19937 engine_{11};
};

}  // namespace

TEST_CASE("formulas of the catalogue's scenes have the values of T, V and q̈") {
  Comparison compare;
  compare.scene(scenes::atwood());
  compare.scene(scenes::bead_on_hoop());
  compare.scene(scenes::cartpole());
  compare.scene(scenes::chain(), scenes::Chain{.n = 3});
  compare.scene(scenes::chain(), scenes::Chain{.n = 5});
  compare.scene(scenes::chaplygin_sleigh());
  compare.scene(scenes::charged_particle());
  compare.scene(scenes::coupled_oscillators());
  compare.scene(scenes::cycloid());
  compare.scene(scenes::double_pendulum());
  compare.scene(scenes::elastic_pendulum());
  compare.scene(scenes::four_bar());
  compare.scene(scenes::heavy_top());
  compare.scene(scenes::henon_heiles());
  compare.scene(scenes::kepler());
  compare.scene(scenes::mathieu());
  compare.scene(scenes::morse());
  compare.scene(scenes::rod_and_ring());
  compare.scene(scenes::rolling_hoop());
  compare.scene(scenes::slider_crank());
  compare.scene(scenes::spherical_pendulum());
}

namespace {

// Three coordinates that all meet, so that two are left for Cramer's rule; a frame that turns, a sum in a sum, equal parameters.
struct Meeting {
  double m = 1.0, M = 1.0, k = 1.0, a = 0.0, w = 1.0;
  auto T(const auto& q, const auto& v, const auto& t) const {
    using std::cos, std::sin;
    const auto x = v[0] + a * w * cos(w * t), y = v[1] * sin(q[2]) + v[0];
    return 0.5 * m * (x * x + v[1] * v[1] * q[0] * q[0]) + 0.5 * M * (y * y + v[2] * v[2] * (2.0 + cos(q[1]))) + 0.25 * m * v[1] * v[2] * cos(q[0] + q[1]);
  }
  auto V(const auto& q, const auto& t) const {
    using std::exp, std::log, std::sin, std::sqrt;
    return k * (q[0] - a) * (q[0] - a) * (q[1] + M) / (1.0 + q[2] * q[2]) + m * sqrt(k / M) * exp(-q[1]) * sin(w * t) + log(q[0] + m * q[2]);
  }
};

struct NoQuadraticForm {
  double m = 2.0, c = 1.0;
  auto T(const auto& q, const auto& v) const {
    using std::sqrt;
    return m * sqrt(c * c + v[0] * v[0] + v[1] * v[1]) * (1.0 + q[0] * q[0]);
  }
  auto V(const auto& q) const {
    using std::tanh;
    return m * tanh(c * q[0]) * q[1];
  }
};

}  // namespace

TEST_CASE("formulas of coordinates that all meet, of a moving frame, and of a T that is no quadratic form have the values of T, V and q̈") {
  Comparison compare;
  compare.operator()<3>("meeting", Meeting{}, {"x", "y", "z"},
                        {{"m", &Meeting::m}, {"M", &Meeting::M}, {"k", &Meeting::k}, {"a", &Meeting::a}, {"w", &Meeting::w}});
  compare.operator()<3>("some named", Meeting{.a = 0.7}, {"x", "y", "z"}, {{"m", &Meeting::m}, {"a", &Meeting::a}});
  compare.operator()<2>("no quadratic form", NoQuadraticForm{}, {"x", "y"}, {{"m", &NoQuadraticForm::m}, {"c", &NoQuadraticForm::c}});
}
