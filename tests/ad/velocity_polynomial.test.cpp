// SPDX-License-Identifier: MIT
//
// Sums of terms c · μ(q) · q̇ q̇: sums, products, cos² + sin², and their value as nodes of a graph.
#include "catch2_bridge.hpp"

#include <cmath>
#include <random>
#include <vector>

#include "qdot/ad/formula/polynomial_node.hpp"
#include "qdot/ad/formula/velocity_polynomial.hpp"

using namespace qdot::formula;

namespace {

// Some thirty operations on numbers of order one, with divisions.
constexpr double rounded = 1e-12;

// Atoms are the variables 0 … atoms − 1 of a graph, velocities the variables after those.
constexpr int atoms = 4, velocities = 3;

double value_of_terms(const Polynomial& p, const MonomialTable& monomials, const std::vector<double>& x) {
  double sum = 0.0;
  for (const Term& t : p) {
    double product = t.c.value;
    const Monomial& m = monomials[t.monomial];
    for (int i = 0; i < m.count; ++i) product *= std::pow(x[static_cast<std::size_t>(m.factor[i].atom)], m.factor[i].exponent);
    for (const int v : {t.a, t.b})
      if (v >= 0) product *= x[static_cast<std::size_t>(atoms + v)];
    sum += product;
  }
  return sum;
}

double value_of_node(const BasicGraph<Coefficient>& graph, int output, const std::vector<double>& x) {
  std::vector<double> v;
  for (const auto& w : graph.nodes()) {
    const auto at = [&v](int k) { return v[static_cast<std::size_t>(k)]; };
    switch (w.kind) {
      case Kind::constant: v.push_back(w.c.value); break;
      case Kind::variable: v.push_back(x[static_cast<std::size_t>(w.a)]); break;
      case Kind::affine: v.push_back(w.ca.value * at(w.a) + (w.b >= 0 ? w.cb.value * at(w.b) : 0.0) + w.c.value); break;
      case Kind::product: v.push_back(at(w.a) * at(w.b)); break;
      case Kind::quotient: v.push_back(at(w.a) / at(w.b)); break;
      case Kind::power: v.push_back(std::pow(at(w.a), w.c.value)); break;
      case Kind::function: v.push_back(value_of(w.function, at(w.a), w.b >= 0 ? at(w.b) : 0.0)); break;
    }
  }
  return v[static_cast<std::size_t>(output)];
}

struct Chance {
  std::mt19937 random{17};
  int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(random); }
  double number() { return std::uniform_real_distribution<double>(0.5, 1.5)(random); }
  std::vector<double> state() {
    std::vector<double> x;
    for (int i = 0; i < atoms + velocities; ++i) x.push_back(number());
    return x;
  }
  Polynomial polynomial(MonomialTable& monomials, int terms, int degree) {
    Polynomial p;
    for (int k = 0; k < terms; ++k) {
      int m = 0;
      for (int i = 0; i < 3; ++i) m = monomials.product(m, monomials.atom(below(atoms), 1 + below(2)));
      if (below(2) == 0) m = monomials.product(m, monomials.atom(below(atoms), -2));
      Term t{below(3) == 0 ? 2.0 : below(2) == 0 ? -2.0 : number(), m};
      const int d = below(degree + 1), a = below(velocities), b = below(velocities);
      if (d > 0) t.a = a;
      if (d > 1) {
        t.a = std::max(a, b);
        t.b = std::min(a, b);
      }
      p.push_back(t);
    }
    collect(p);
    return p;
  }
};

}  // namespace

TEST_CASE("sums and products of polynomials are those of their values") {
  Chance chance;
  MonomialTable monomials;
  for (int sample = 0; sample < 50; ++sample) {
    const auto x = chance.state();
    const Polynomial p = chance.polynomial(monomials, 6, 1), r = chance.polynomial(monomials, 5, 1);
    const double P = value_of_terms(p, monomials, x), R = value_of_terms(r, monomials, x);
    CHECK_THAT(value_of_terms(sum_of(p, r, -3.0), monomials, x), WithinAbs(P - 3.0 * R, 100 * rounded));
    CHECK_THAT(value_of_terms(product_of(p, r, monomials), monomials, x), WithinAbs(P * R, 1000 * rounded));
    CHECK(sum_of(p, p, -1.0).empty());
  }
  CHECK(monomials.is_complete());
}

TEST_CASE("a polynomial arranged as nodes has the value of its terms, whatever they have in common") {
  Chance chance;
  for (int sample = 0; sample < 200; ++sample) {
    MonomialTable monomials;
    BasicGraph<Coefficient> graph;
    for (int i = 0; i < atoms + velocities; ++i) graph.variable(i);
    const auto x = chance.state();
    const Polynomial p = chance.polynomial(monomials, 1 + chance.below(9), 2);
    const int node = PolynomialNodes(graph, monomials, atoms).node_of(p);
    CHECK_THAT(value_of_node(graph, node, x), WithinAbs(value_of_terms(p, monomials, x), 100 * rounded));
  }
}

TEST_CASE("cos² + sin² of one angle is one, with like coefficients and no others") {
  MonomialTable monomials;
  const auto cosine_of = [](int atom) { return atom == 0 ? 1 : -1; };  // atom 0 is the sine, atom 1 the cosine
  const int s2 = monomials.atom(0, 2), c2 = monomials.atom(1, 2), other = monomials.atom(2);
  Polynomial p{{3.0, monomials.product(s2, other), 1, 0}, {3.0, monomials.product(c2, other), 1, 0}};
  collect(p);
  simplify_squares(p, monomials, cosine_of);
  REQUIRE(p.size() == 1);
  CHECK(p[0].monomial == other);
  CHECK(p[0].c.value == 3.0);
  Polynomial unlike{{3.0, s2, 1, 0}, {2.0, c2, 1, 0}, {3.0, c2, 1, 1}};
  collect(unlike);
  simplify_squares(unlike, monomials, cosine_of);
  CHECK(unlike.size() == 3);
  // sin⁴ + 2 sin² cos² + cos⁴
  Polynomial fourth{{1.0, monomials.atom(0, 4)}, {2.0, monomials.product(s2, c2)}, {1.0, monomials.atom(1, 4)}};
  collect(fourth);
  simplify_squares(fourth, monomials, cosine_of);
  const std::vector<double> x{std::sin(0.7), std::cos(0.7), 1, 1, 1, 1, 1};
  CHECK_THAT(value_of_terms(fourth, monomials, x), WithinAbs(1.0, rounded));
}

TEST_CASE("monomials are products of powers; too many factors are noticed") {
  MonomialTable monomials;
  const int x = monomials.atom(3), y = monomials.atom(5, -2);
  CHECK(monomials.product(x, y) == monomials.product(y, x));
  CHECK(monomials.product(monomials.product(x, y), monomials.power(monomials.product(x, y), -1)) == 0);
  CHECK(monomials[monomials.power(y, -3)].exponent_of(5) == 6);
  int many = 0;
  for (int k = 0; k < Monomial::most_factors; ++k) many = monomials.product(many, monomials.atom(10 + k));
  CHECK(monomials.is_complete());
  monomials.product(many, x);
  CHECK(!monomials.is_complete());
}
