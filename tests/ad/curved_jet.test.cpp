// SPDX-License-Identifier: MIT
//
// Gradients on their way, and Hessians, against nested duals.
#include "qdot/ad/places/curved_jet.hpp"

#include <algorithm>
#include <cmath>

#include "../catch2_bridge.hpp"
#include "qdot/ad/derivatives.hpp"

using namespace qdot;

namespace {

// Both round what they compute, some ten operations one after another.
constexpr double rounded = 1e-13;

using Point = Vector<double, 3>;
const Point q(0.4, 0.9, 0.3), qdot(0.3, -1.2, 0.7), qddot(-2.0, 0.4, 1.1);
constexpr double t = 0.6;

// The worst difference of f's value, J, J̇, J̈ and H on its way through q at the time t.
template <class F>
double difference(const F& f) {
  using S = detail::CurvedJet<3>;
  Vector<S, 3> x;
  for (int i = 0; i < 3; ++i) x[i] = S::coordinate(i, q[i], qdot[i], qddot[i]);
  const S jet = f(x, S::time(t));
  using Along = Dual<double, 1>;
  using Twice = Dual<Along, 1>;
  using Slope = Dual<Twice, 3>;
  Vector<Slope, 3> moving;
  for (int i = 0; i < 3; ++i) {
    moving[i] = Slope(Twice(Along(q[i])));
    moving[i].value.value.tangent[0] = moving[i].value.tangent[0].value = qdot[i];
    moving[i].value.tangent[0].tangent[0] = qddot[i];
    moving[i].tangent[static_cast<std::size_t>(i)] = Twice(1.0);
  }
  Slope time{Twice(Along(t))};
  time.value.value.tangent[0] = time.value.tangent[0].value = 1.0;
  const Slope expected = f(moving, time);
  const Matrix<double, 3> H = hessian([&](const auto& p) {
    using D = typename std::remove_cvref_t<decltype(p)>::Scalar;
    return f(p, D(t));
  }, q);
  double worst = std::max({std::abs(jet.value.value - expected.value.value.value), std::abs(jet.rate - expected.value.tangent[0].value),
                           std::abs(jet.bend - expected.value.tangent[0].tangent[0])});
  for (int i = 0; i < 3; ++i) {
    const bool there = i >= jet.first && i < jet.last;
    const Twice& slope = expected.tangent[static_cast<std::size_t>(i)];
    worst = std::max({worst, std::abs((there ? jet.J[i] : 0.0) - slope.value.value), std::abs((there ? jet.Jdot[i] : 0.0) - slope.tangent[0].value),
                      std::abs((there ? jet.Jddot[i] : 0.0) - slope.tangent[0].tangent[0])});
    for (int j = 0; j <= i; ++j) worst = std::max(worst, std::abs((there && j >= jet.first ? jet.H(i)[j] : 0.0) - H(i, j)));
  }
  return worst;
}

TEST_CASE("gradients on their way follow products, quotients and functions") {
  using std::atan2, std::cos, std::exp, std::hypot, std::log, std::pow, std::sin, std::sqrt, std::tanh;
  CHECK(difference([](const auto& x, const auto& s) { return x[0] * x[2] - 2.0 * x[1] * s + x[0] * x[0] * x[1]; }) < rounded);
  CHECK(difference([](const auto& x, const auto& s) { return (x[0] - s) / (1.0 + x[1] * x[2]) + 3.0 / x[2]; }) < rounded);
  CHECK(difference([](const auto& x, const auto&) { return sin(x[0]) + cos(x[2] * x[0]) - sin(x[1]); }) < rounded);
  CHECK(difference([](const auto& x, const auto& s) { return sqrt(x[0] + x[1] * x[1]) * exp(0.3 * s * x[2]) - log(x[1]); }) < rounded);
  CHECK(difference([](const auto& x, const auto& s) { return tanh(x[0] * s) + pow(x[1], 3) + pow(x[2], x[0]); }) < rounded);
  CHECK(difference([](const auto& x, const auto& s) { return atan2(x[0] * s, x[1]) + hypot(x[1], x[2]); }) < rounded);
}

TEST_CASE("what was added to in place knows the coordinates of both, in any order") {
  CHECK(difference([](const auto& x, const auto&) {
          auto sum = x[2] * x[2];
          sum += x[0];
          sum -= x[1] * x[2];
          sum *= x[1];
          return sum;
        }) < rounded);
}

}  // namespace
