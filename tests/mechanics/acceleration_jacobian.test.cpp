// SPDX-License-Identifier: MIT
//
// Exact derivatives of q̈ against quotients of differences of q̈.
#include "catch2_bridge.hpp"

#include "bench/chain_energies.hpp"
#include "mechanics/difference_from_quotients.hpp"

using namespace qdot;

namespace {

template <int n>
Vector<double, n> spread(Eigen::Index size, double from, double to) {
  return Vector<double, n>::LinSpaced(size, from, to);
}

}  // namespace

TEST_CASE("derivatives of accelerations are limits of quotients: chains") {
  CHECK(difference_from_quotients(mechanical_system<3>(bench::LoopedChain{}), spread<3>(3, -1.0, 1.2), spread<3>(3, 1.0, -0.7)) < differenced);
}

TEST_CASE("derivatives of accelerations are limits of quotients: sizes known at run time, within the limit of the records and beyond") {
  for (const Eigen::Index n : {2, 7, 33})
    CHECK(difference_from_quotients(mechanical_system(n, bench::LoopedChain{}), spread<Dynamic>(n, -1.0, 1.2), spread<Dynamic>(n, 1.0, -0.7)) <
          differenced);
}

TEST_CASE("derivatives of accelerations are limits of quotients: energies of several formulas, sizes known at run time") {
  const auto stops = mechanical_system(Eigen::Index(2), [](const auto& v) { return 0.5 * v.dot(v); },
                                       [](const auto& q) {
                                         using std::max;
                                         const auto into_stop = max(q[0] - 0.5, 0.0 * q[0]);
                                         return 20.0 * into_stop * into_stop * into_stop + q[0] * q[1];
                                       });
  for (const double x : {0.2, 0.9})
    CHECK(difference_from_quotients(stops, Vector<double, Dynamic>{{x, -0.4}}, Vector<double, Dynamic>{{0.9, 0.5}}) < differenced);
}

TEST_CASE("derivatives of accelerations are limits of quotients: indefinite mass matrices") {
  const auto exchanged = mechanical_system<2>([](const auto& q, const auto& v) { return (1.0 + q[0] * q[0]) * v[0] * v[1]; },
                                              [](const auto& q) { return sin(q[0]) * q[1]; })
                             .with_indefinite_mass_matrix();
  const Vector<double, 2> q(0.6, -0.4), v(0.9, 0.5);
  CHECK(difference_from_quotients(exchanged, q, v) < differenced);
}

TEST_CASE("derivatives of accelerations do not exist where the mass matrix is singular") {
  const auto s = mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] + v[1]) * (v[0] + v[1]); });
  CHECK_THROWS_AS(acceleration_jacobian(s, Vector<double, 2>(0, 0), Vector<double, 2>(0, 0)), SingularMassMatrix);
}
