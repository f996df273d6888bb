#pragma once
// SPDX-License-Identifier: MIT
//
// Least squares within bounds: min ½ Σ rᵢ(x)² with lower ≤ x ≤ upper.
//
// The Levenberg–Marquardt method is Eigen's, after MINPACK: steps (JᵀJ + λD²) δ = −Jᵀr, of which λ shortens those that r does not bear out.
// It knows no bounds. Here they are an active set round it:
//
//     r is only ever asked for at points put back into the bounds, so that a step that leaves them is judged by what it brings there
//     an x that has arrived at a bound is held there, and the method goes on with the others
//     it is let go where −Jᵀr points inwards
//
// A change of variables that maps the whole line into the bounds would need none of this, but then slopes vanish at every bound. A search that begins
// there, or comes near, stays for no reason that lies in r. Nor can an x at its bound be told from one that nothing depends on.
//
// Where there is no r (a motion that fails, a mass below zero) the step counts as one that led far up, and a shorter one is tried.

#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <unsupported/Eigen/NonLinearOptimization>

#include "qdot/ad/vector.hpp"

namespace qdot::detail {

// r and J at a point, or why there are none.
struct ResidualsAt {
  Eigen::VectorXd x{}, r{};
  Eigen::MatrixXd J{};
  std::string trouble{};  // empty where there are
};

struct LeastSquaresSearch {
  std::function<ResidualsAt(const Eigen::VectorXd& x)> residuals;
  Eigen::VectorXd lower{}, upper{};
  int most_evaluations = 0;
  double tolerance = 0.0;   // of a step, as part of x, and of what it takes from Σr², as part of that
  double negligible = 0.0;  // a norm of r that counts as none
};

struct LeastSquaresEnd {
  ResidualsAt best{};
  std::vector<Eigen::Index> held{};  // entries of x at a bound, from which r would lead outwards
  int evaluations = 0;
  bool exhausted = false;  // as many evaluations as were allowed
  std::string trouble{};   // of the last point on the way that had no r
};

template <class = void>  // compiled only where it is made
class BoundedLeastSquares {
 public:
  explicit BoundedLeastSquares(const LeastSquaresSearch& search) : search_(search) {}

  LeastSquaresEnd end(const Eigen::VectorXd& guess);

  // As Eigen's method asks: entries of x that are free.
  int values() const { return static_cast<int>(std::max(best_.r.size(), best_.x.size())); }
  int operator()(const Eigen::VectorXd& u, Eigen::VectorXd& f) {
    constexpr double far_up = 1e3;
    const ResidualsAt& at = known(u);
    f.setZero(values());
    if (at.trouble.empty() && at.r.allFinite()) std::copy_n(at.r.data(), at.r.size(), f.data());
    else f.setConstant(far_up * (1.0 + best_.r.norm()));
    return 0;
  }
  template <class Slopes>
  int df(const Eigen::VectorXd& u, Slopes& slopes) {
    const ResidualsAt& at = known(u);
    slopes.setZero(values(), u.size());
    slopes.topRows(at.J.rows()) = at.J(Eigen::indexing::all, free_);
    return 0;
  }

 private:
  Eigen::VectorXd inside(Eigen::VectorXd x) const {
    for (Eigen::Index j = 0; j < x.size(); ++j) x[j] = std::min(std::max(x[j], search_.lower[j]), search_.upper[j]);
    return x;
  }
  Eigen::VectorXd whole(const Eigen::VectorXd& u) const {
    Eigen::VectorXd x = best_.x;
    x(free_) = u;
    return x;
  }
  ResidualsAt evaluated(const Eigen::VectorXd& x) {
    ++evaluations_;
    ResidualsAt at = search_.residuals(x);
    at.x = x;
    if (!at.trouble.empty()) trouble_ = at.trouble;
    return at;
  }
  // The method asks for slopes where it has asked for values before.
  const ResidualsAt& known(const Eigen::VectorXd& u) {
    const Eigen::VectorXd x = inside(whole(u));
    if (x == best_.x) return best_;
    if (last_.x.size() == 0 || x != last_.x) last_ = evaluated(x);
    return last_;
  }

  std::vector<Eigen::Index> free_entries() const {
    std::vector<Eigen::Index> free;
    for (Eigen::Index j = 0; j < best_.x.size(); ++j) {
      const double slope = best_.J.col(j).dot(best_.r);
      const bool leads_out = (best_.x[j] <= search_.lower[j] && slope >= 0.0) || (best_.x[j] >= search_.upper[j] && slope <= 0.0);
      if (!leads_out) free.push_back(j);
    }
    return free;
  }

  // From best_ on with what is free there, until nothing gets better.
  void descend() {
    for (;;) {
      const double before = best_.r.norm();
      free_ = free_entries();
      if (free_.empty() || before <= search_.negligible) return;
      Eigen::VectorXd u = best_.x(free_);
      Eigen::LevenbergMarquardt<BoundedLeastSquares> method(*this);
      method.parameters.factor = 1.0;  // the first step changes x by no more than all of it
      method.parameters.ftol = method.parameters.xtol = search_.tolerance;
      method.parameters.maxfev = std::max(search_.most_evaluations - evaluations_, 1);
      method.minimizeInit(u);
      bool arrived = false;
      auto status = Eigen::LevenbergMarquardtSpace::Running;
      while (status == Eigen::LevenbergMarquardtSpace::Running && !arrived && method.fnorm > search_.negligible) {
        status = method.minimizeOneStep(u);
        const ResidualsAt now = known(u);  // of an accepted step, or the last one
        arrived = now.x != whole(u);
        best_ = now;
        exhausted_ = evaluations_ >= search_.most_evaluations;
        if (exhausted_) return;
      }
      if (!(best_.r.norm() < before * (1.0 - search_.tolerance))) return;
      if (!arrived && free_entries() == free_) return;
    }
  }

  const LeastSquaresSearch& search_;
  ResidualsAt best_{}, last_{};
  std::vector<Eigen::Index> free_{};
  int evaluations_ = 0;
  bool exhausted_ = false;
  std::string trouble_{};
};

template <class Any>  // defined outside: compilers instantiate what is inline in spite of `extern template`
LeastSquaresEnd BoundedLeastSquares<Any>::end(const Eigen::VectorXd& guess) {
  best_ = evaluated(inside(guess));
  if (best_.trouble.empty()) descend();
  LeastSquaresEnd end{std::move(best_), {}, evaluations_, exhausted_, std::move(trouble_)};
  for (Eigen::Index j = 0; j < end.best.x.size(); ++j)
    if (std::find(free_.begin(), free_.end(), j) == free_.end()) end.held.push_back(j);
  return end;
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template class BoundedLeastSquares<void>;
#endif

}  // namespace qdot::detail
