// SPDX-License-Identifier: MIT
//
// The algebra by which equations are derived to be read, on what T and V recorded, against nested duals.
#include "qdot/mechanics/derive/by_terms.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "bench/chain_energies.hpp"
#include "catch2_bridge.hpp"
#include "mechanics/many_functions.hpp"
#include "qdot/mechanics/acceleration_jacobian.hpp"
#include "qdot/mechanics/derive/derivation.ipp"
#include "qdot/mechanics/derive/lines.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"

namespace {

using namespace qdot;

// Sums of a few hundred operations, M of a condition up to 1e3.
constexpr double rounding = 1e-11;

// All nodes of a graph of numbers, in one whose coefficients are compared up to rounding.
std::vector<int> copied(const formula::Graph& from, detail::DerivationByTerms::Graph& to) {
  std::vector<int> copy;
  const auto at = [&](int x) { return x < 0 ? -1 : copy[static_cast<std::size_t>(x)]; };
  for (const formula::Node& w : from.nodes()) {
    copy.push_back(to.copy_of({w.kind, w.function, w.kind == formula::Kind::variable ? w.a : at(w.a), at(w.b), w.ca, w.cb, w.c}));
    to.set_domain(copy.back(), w.domain);
  }
  return copy;
}

template <int n, class E>
detail::DerivedLines lines_by_terms(const E& energies) {
  detail::RecordedMotion recorded = detail::motion_variables(n);
  detail::run_energies<n>(recorded, energies);
  detail::DerivationByTerms d(n);
  const std::vector<int> copy = copied(recorded.recording.graph, d.graph);
  const auto node = [&](std::size_t k) { return copy[static_cast<std::size_t>(recorded.returned[k])]; };
  const detail::DerivedJacobian equations = d.jacobian_by_terms(node(0), node(1));
  REQUIRE(d.is_possible);
  detail::DerivedLines lines;
  detail::DerivedLineWriter writer(d.graph, n, detail::DerivedLines::most(n));
  writer.write_equations(equations, {}, {}, lines);
  writer.write_slopes(equations, lines);
  return lines;
}

// M, r and the slopes of r − M a at a few states.
template <int n, class E>
void check(const E& energies) {
  const detail::DerivedLines lines = lines_by_terms<n>(energies);
  const auto system = mechanical_system<n>(energies);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(0.2, 1.2);
  for (int k = 0; k < 5; ++k) {
    const double t = number(random);
    Vector<double, n> q, qdot;
    for (int i = 0; i < n; ++i) q[i] = number(random), qdot[i] = number(random) - 0.7;
    const auto expected = detail::general_mass_and_rhs<n>(energies, q, qdot, t);
    MassAndRhs<double, n> found = expected;
    REQUIRE(lines.template with_mass_and_rhs<n>(q.data(), qdot.data(), t, detail::CopyTo<n>{found.M, found.r}));
    CHECK((found.M - expected.M).cwiseAbs().maxCoeff() <= rounding * expected.M.cwiseAbs().maxCoeff());
    CHECK((found.r - expected.r).cwiseAbs().maxCoeff() <= rounding * (1.0 + expected.r.cwiseAbs().maxCoeff()));
    const auto J = acceleration_jacobian(system, q, qdot, t);
    double M[n * (n + 1) / 2];
    double rows[n][2 * n];
    const auto known = [&](const double*, double* to) { return std::copy_n(J.qddot.data(), n, to), true; };
    REQUIRE(lines.template write_slopes<n>(q.data(), qdot.data(), t, M, rows, known));
    for (int j = 0; j < 2 * n; ++j) {
      Vector<double, n> slope;  // M ∂q̈
      for (int i = 0; i < n; ++i) slope[i] = rows[i][j];
      const Vector<double, n> along = expected.M * Vector<double, n>(j < n ? J.d_q.col(j) : J.d_qdot.col(j - n));
      CHECK((slope - along).cwiseAbs().maxCoeff() <= rounding * (1.0 + along.cwiseAbs().maxCoeff() + slope.cwiseAbs().maxCoeff()));
    }
  }
}

// A mass in spherical coordinates r, φ, θ, on a spring: what turns φ is φ̇ times a sum of the other two.
struct SphericalMass {
  double m = 0.7, k = 1.3;
  auto T(const auto& q, const auto& v) const {
    using std::sin;
    const auto across = q[0] * sin(q[2]) * v[1], down = q[0] * v[2];
    return 0.5 * m * (v[0] * v[0] + across * across + down * down);
  }
  auto V(const auto& q) const { return 0.5 * k * q[0] * q[0]; }
};

TEST_CASE("M, r and slopes of a T that is multiplied out are those of nested duals") {
  check<2>(bench::LoopedChain{});
  check<4>(bench::PairedChain{});
  check<3>(tests::ManyFunctions{});
  check<3>(SphericalMass{});
}

TEST_CASE("a T that is no quadratic form in the velocities is not multiplied out") {
  detail::RecordedMotion recorded = detail::motion_variables(1);
  detail::run_energies<1>(recorded, mechanical_system<1>([](const auto& v) { return v[0] * v[0] * v[0] * v[0]; }).energies());
  detail::DerivationByTerms d(1);
  const std::vector<int> copy = copied(recorded.recording.graph, d.graph);
  d.jacobian_by_terms(copy[static_cast<std::size_t>(recorded.returned[0])], copy[static_cast<std::size_t>(recorded.returned[1])]);
  CHECK(!d.is_possible);
}

}  // namespace
