// SPDX-License-Identifier: MIT
//
// A method of one's own: the classical Runge-Kutta method with a fixed step, whose steps simulate() drives like those of any other. Output times,
// events and trajectories come from the polynomial that each step leaves behind.

#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>

#include <qdot/integrate/simulate.hpp>
#include <qdot/qdot.hpp>

template <qdot::FirstOrderSystem F>
class ClassicalStepper {
 public:
  ClassicalStepper(F system, double h) : system_(std::move(system)), h_(h) { statistics_.method = "classical"; }

  void reset(double t, const Eigen::VectorXd& y) {
    t_ = before_ = t;
    y_ = y;
    for (auto& k : k_) k.setZero(y.size());
    coefficients_.setZero(y.size(), 4);
    system_.derivative(t, y_, k_[0]);  // throws here what is wrong with the start
  }

  bool step(double limit) {
    const double direction = limit > t_ ? 1.0 : -1.0;
    const bool arrives = std::abs(limit - t_) <= h_ * (1.0 + 1e-12);
    const double h = arrives ? limit - t_ : direction * h_;
    try {
      Eigen::VectorXd at = y_;
      system_.derivative(t_, at, k_[0]);
      system_.derivative(t_ + 0.5 * h, at = y_ + 0.5 * h * k_[0], k_[1]);
      system_.derivative(t_ + 0.5 * h, at = y_ + 0.5 * h * k_[1], k_[2]);
      system_.derivative(t_ + h, at = y_ + h * k_[2], k_[3]);
    } catch (const qdot::NonFinite& error) {  // t() and y() are still those of the last good step
      failure_ = {qdot::Outcome::non_finite, error.what()};
      return false;
    }
    // y and its slope at both ends: Hermite's cubic in s = (t − t₀)/h.
    const Eigen::VectorXd next = y_ + h / 6.0 * (k_[0] + 2.0 * k_[1] + 2.0 * k_[2] + k_[3]), change = next - y_;
    system_.derivative(t_ + h, next, k_[1]);
    coefficients_ << y_, h * k_[0], 3.0 * change - h * (2.0 * k_[0] + k_[1]), h * (k_[0] + k_[1]) - 2.0 * change;
    before_ = t_;
    t_ = arrives ? limit : t_ + h;
    y_ = next;
    ++statistics_.steps;
    statistics_.evaluations += 5;
    return true;
  }

  qdot::PolynomialView polynomial() const {
    return {.origin = before_, .scale = t_ - before_, .coefficients = coefficients_.data(), .size = y_.size(), .degree = 3, .begin = before_, .end = t_};
  }
  void interpolate(double t, Eigen::Ref<Eigen::VectorXd> out) const { polynomial().evaluate(t, out); }

  const qdot::Failure& failure() const { return failure_; }
  double t() const { return t_; }
  double t_previous() const { return before_; }
  const Eigen::VectorXd& y() const { return y_; }
  int order() const { return 4; }
  const qdot::Statistics& statistics() const { return statistics_; }

 private:
  F system_;
  double h_, t_ = 0.0, before_ = 0.0;
  Eigen::VectorXd y_;
  std::array<Eigen::VectorXd, 4> k_;
  Eigen::MatrixXd coefficients_;
  qdot::Failure failure_;
  qdot::Statistics statistics_;
};

struct Classical {
  static constexpr std::string_view name = "classical";
  double step = 0.01;

  template <qdot::FirstOrderSystem F>
  ClassicalStepper<F> stepper(const F& system, const qdot::Options&) const {
    return {system, step};
  }
};

int main() {
  const auto oscillator = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.5 * q[0] * q[0]; });
  const qdot::State<1> start{0.0, {1.0}, {0.0}};
  std::printf("step     error at t = 10    of the order\n");
  double before = 0.0;
  for (const double h : {0.2, 0.1, 0.05}) {
    const auto run = simulate(oscillator, start, 10.0, Classical{h});
    const double error = std::abs(run.state().q[0] - std::cos(10.0));
    if (before == 0.0) std::printf("%.2f     %.1e\n", h, error);
    else std::printf("%.2f     %.1e            %.1f\n", h, error, std::log2(before / error));
    before = error;
  }
  const auto zero = qdot::event("zero", [](const auto& q) { return q[0]; });  // found on the cubics, at (k + 1/2) pi
  const auto run = simulate(oscillator, start, 10.0, Classical{0.01}, zero);
  for (const auto& e : run.events) std::printf("%s at t = %.6f\n", e.name.c_str(), e.t);
}
