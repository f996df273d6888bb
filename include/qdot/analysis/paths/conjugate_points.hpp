#pragma once
// SPDX-License-Identifier: MIT
//
// Where neighbours that leave one place meet again, and how often until then.
//
// X(t) = ∂q(t)/∂q̇_a and P(t) = ∂p(t)/∂q̇_a are the neighbours of a motion that begin at the same q_a. Where det X = 0,
// t is conjugate to t_a, with the dimension of X's kernel as its multiplicity; det X keeps its sign where that is even.
// XᵀP is symmetric (p δq − q δp is conserved), and so is X P⁻¹. Its eigenvalues tan φ_j have angles that pass the
// multiples of π forwards only, for M is positive definite, and each passage is one dimension of a kernel. With
// Θ = Σ φ_j = arg det (P + iX),
//
//     passages up to t = (Θ − Σ (φ_j mod π)) / π ,
//
// an integer, so no zero is searched for: halving an interval finds where it changes. In a frame turned by α,
//     A = (cos α X − sin α P)(cos α P + sin α X)⁻¹ ,     φ_j = α + atan a_j ,     det (P + iX) = e^{inα} Π (1 + i a_j) det (cos α P + sin α X) ,
// one of 2n + 1 angles α keeps away from all singularities. (Morse's index theorem; V. I. Arnold, Mathematical Methods
// of Classical Mechanics, appendix 11.)

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Jacobi>
#include <Eigen/LU>

namespace qdot::detail {

struct MeetingPoint {
  double t = 0.0;
  int multiplicity = 0;
};

// X and P, in units in which they are comparable.
struct DeviationFrame {
  Eigen::MatrixXd X, P;
};

// Eigenvalues of a small symmetric matrix, by rotations of two coordinates at a time (Jacobi, 1846).
template <class MatrixXd>  // compiled only where it is called
Eigen::VectorXd symmetric_eigenvalues(MatrixXd A) {
  constexpr int most_sweeps = 60;
  bool turned = true;
  for (int sweep = 0; turned && sweep < most_sweeps; ++sweep) {
    turned = false;
    for (Eigen::Index j = 0; j < A.rows(); ++j)
      for (Eigen::Index k = j + 1; k < A.rows(); ++k) {
        if (!(std::abs(A(j, k)) > 1e-16 * (std::abs(A(j, j)) + std::abs(A(k, k))))) continue;
        turned = true;
        Eigen::JacobiRotation<double> turn;
        turn.makeJacobi(A, j, k);
        A.applyOnTheLeft(j, k, turn.adjoint());
        A.applyOnTheRight(j, k, turn);
      }
  }
  return A.diagonal();
}

struct Phase {
  double whole = 0.0;      // Θ up to multiples of 2π
  double remainder = 0.0;  // Σ (φ_j mod π)
};

template <class MatrixXd>
Phase phase_of(MatrixXd X, MatrixXd P) {
  const Eigen::Index n = X.rows();
  const double pi = std::numbers::pi;
  for (Eigen::Index j = 0; j < n; ++j) {
    const double length = std::hypot(X.col(j).norm(), P.col(j).norm());
    X.col(j) /= length;
    P.col(j) /= length;
  }
  double best = -1.0, alpha = 0.0, determinant = 0.0;
  Eigen::FullPivLU<MatrixXd> factors, tried;
  for (Eigen::Index k = 0; k <= 2 * n; ++k) {
    const double angle = pi * static_cast<double>(k) / static_cast<double>(2 * n + 1);
    tried.compute((std::cos(angle) * P + std::sin(angle) * X).transpose());
    const double of_it = tried.determinant();
    if (std::abs(of_it) <= best) continue;
    best = std::abs(of_it);
    alpha = angle;
    determinant = of_it;
    factors = tried;
  }
  const MatrixXd turned = (std::cos(alpha) * X - std::sin(alpha) * P).transpose(), A = factors.solve(turned);
  Phase phase{static_cast<double>(n) * alpha + (determinant < 0.0 ? pi : 0.0), 0.0};
  for (const double a : symmetric_eigenvalues<MatrixXd>(0.5 * (A + A.transpose()))) {
    const double phi = alpha + std::atan(a);
    phase.whole += std::atan(a);
    phase.remainder += phi - pi * std::floor(phi / pi);
  }
  return phase;
}

template <class Neighbours>
class MeetingPoints {
 public:
  // @param neighbours  at t in [t_a, t_b], X = 0 at t_a
  MeetingPoints(Neighbours neighbours, double t_a, double t_b) : neighbours_(std::move(neighbours)), t_a_(t_a), t_b_(t_b) {}

  // @param times  moments between which little happens, such as those of a method's steps
  std::vector<MeetingPoint> between(const std::vector<double>& times) {
    constexpr int parts = 6;  // of a step
    const double end = t_b_ - 1e-7 * (t_b_ - t_a_);
    Counted here{t_a_, 0.0, 0};
    for (std::size_t k = 0; k + 1 < times.size(); ++k)
      for (int part = 1; part <= parts; ++part) {
        const double t = std::min(times[k] + (times[k + 1] - times[k]) * part / parts, end);
        if (t <= here.t) continue;
        const Counted next = counted(t, here);
        search(here, next);
        here = next;
      }
    return merged();
  }

 private:
  struct Counted {
    double t, theta;
    long passages;
  };

  Counted counted(double t, const Counted& before) const {
    const double pi = std::numbers::pi;
    const DeviationFrame frame = neighbours_(t);
    const Phase phase = phase_of(frame.X, frame.P);
    const double change = std::remainder(phase.whole - before.theta, 2.0 * pi), theta = before.theta + change;
    return {t, theta, std::lround((theta - phase.remainder) / pi)};
  }
  void search(const Counted& from, const Counted& to) {
    if (to.passages <= from.passages) return;
    if (to.t - from.t <= 1e-11 * (t_b_ - t_a_)) {
      found_.push_back({0.5 * (from.t + to.t), static_cast<int>(to.passages - from.passages)});
      return;
    }
    const Counted middle = counted(0.5 * (from.t + to.t), from);
    search(from, middle);
    search(middle, to);
  }
  // What the error of a run has split.
  std::vector<MeetingPoint> merged() const {
    std::vector<MeetingPoint> points;
    for (const MeetingPoint& each : found_) {
      if (!points.empty() && each.t - points.back().t <= 1e-7 * (t_b_ - t_a_)) points.back().multiplicity += each.multiplicity;
      else points.push_back(each);
    }
    return points;
  }

  Neighbours neighbours_;
  double t_a_, t_b_;
  std::vector<MeetingPoint> found_;
};

}  // namespace qdot::detail
