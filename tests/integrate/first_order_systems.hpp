#pragma once
// SPDX-License-Identifier: MIT
//
// First-order systems without mechanics behind them, for tests of the integrate layer.
//
// Each is written by hand with its Jacobian, and counts its evaluations in a counter that all its
// copies share, because a stepper copies the system it is given.

#include <Eigen/Core>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "qdot/integrate/run.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace test {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using In = Eigen::Ref<const VectorXd>;
using OutVector = Eigen::Ref<VectorXd>;
using OutMatrix = Eigen::Ref<MatrixXd>;

/// ẏ = f(t, y) from two functions, with names for the components.
class FirstOrder {
 public:
  static constexpr int size_at_compile_time = Eigen::Dynamic;

  using Derivative = std::function<void(double, const In&, OutVector)>;
  using Jacobian = std::function<void(double, const In&, OutMatrix)>;

  FirstOrder(std::vector<std::string> names, Derivative derivative, Jacobian jacobian)
      : names_(std::move(names)), derivative_(std::move(derivative)), jacobian_(std::move(jacobian)) {}

  Index size() const { return static_cast<Index>(names_.size()); }
  void derivative(double t, const In& y, OutVector ydot) const {
    ++*evaluations_;
    derivative_(t, y, ydot);
  }
  void jacobian(double t, const In& y, OutMatrix J) const { jacobian_(t, y, J); }
  std::string component_name(Index i) const { return names_[static_cast<std::size_t>(i)]; }

  long evaluations() const { return *evaluations_; }

 private:
  std::vector<std::string> names_;
  Derivative derivative_;
  Jacobian jacobian_;
  std::shared_ptr<long> evaluations_ = std::make_shared<long>(0);
};

static_assert(qdot::FirstOrderSystem<FirstOrder>);

inline VectorXd vector(std::initializer_list<double> values) {
  return Eigen::Map<const VectorXd>(values.begin(), static_cast<Index>(values.size()));
}

/// ẍ = −x; from (1, 0) the motion is (cos t, −sin t).
inline FirstOrder oscillator() {
  return {{"x", "xdot"},
          [](double, const In& y, OutVector d) { d << y[1], -y[0]; },
          [](double, const In&, OutMatrix J) { J << 0, 1, -1, 0; }};
}

/// ẏ = −k y, of one component: it has no coordinates and velocities.
inline FirstOrder decay(double k) {
  return {{"y"},
          [k](double, const In& y, OutVector d) { d[0] = -k * y[0]; },
          [k](double, const In&, OutMatrix J) { J(0, 0) = -k; }};
}

/// Pendulum of unit length, g = 9.81.
inline FirstOrder pendulum() {
  constexpr double g = 9.81;
  return {{"theta", "thetadot"},
          [](double, const In& y, OutVector d) { d << y[1], -g * std::sin(y[0]); },
          [](double, const In& y, OutMatrix J) { J << 0, 1, -g * std::cos(y[0]), 0; }};
}

/// van der Pol's oscillator in the stiff scaling ε ẍ = (1 − x²) ẋ − x.
inline FirstOrder van_der_pol(double epsilon) {
  return {{"x", "xdot"},
          [epsilon](double, const In& y, OutVector d) { d << y[1], ((1 - y[0] * y[0]) * y[1] - y[0]) / epsilon; },
          [epsilon](double, const In& y, OutMatrix J) {
            J << 0, 1, (-2 * y[0] * y[1] - 1) / epsilon, (1 - y[0] * y[0]) / epsilon;
          }};
}

/// Robertson's chemical kinetics: three components, rates 0.04, 1e4 and 3e7.
inline FirstOrder robertson() {
  return {{"A", "B", "C"},
          [](double, const In& y, OutVector d) {
            d[0] = -0.04 * y[0] + 1e4 * y[1] * y[2];
            d[2] = 3e7 * y[1] * y[1];
            d[1] = -d[0] - d[2];
          },
          [](double, const In& y, OutMatrix J) {
            J << -0.04, 1e4 * y[2], 1e4 * y[1],               //
                0.04, -1e4 * y[2] - 6e7 * y[1], -1e4 * y[1],  //
                0, 6e7 * y[1], 0;
          }};
}

/// ẏ = y²: from 1 the solution 1/(1 − t) has a pole at t = 1.
inline FirstOrder blow_up() {
  return {{"y"},
          [](double, const In& y, OutVector d) { d[0] = y[0] * y[0]; },
          [](double, const In& y, OutMatrix J) { J(0, 0) = 2 * y[0]; }};
}

/// The pendulum whose right-hand side calls `instead` for t > t_bad.
inline FirstOrder pendulum_until(double t_bad, std::function<void(OutVector)> instead) {
  const FirstOrder good = pendulum();
  return {{"theta", "thetadot"},
          [=](double t, const In& y, OutVector d) {
            good.derivative(t, y, d);
            if (t > t_bad) instead(d);
          },
          [=](double t, const In& y, OutMatrix J) { good.jacobian(t, y, J); }};
}

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace test
