#pragma once
// SPDX-License-Identifier: MIT
//
// Newton's method for a motion between two places, by multiple shooting
// =====================================================================
//
// A single shot from q_a misses q_b by far where neighbours part quickly. So the time is cut into legs, each with a start x_k = (q_k, q̇_k) of its own.
// Each leg must end where the next one begins, and the last one at q_b:
//
//     φ_k(x_k) − x_{k+1} = d_k = 0 ,    q(t_b) − q_b = 0 ;        unknown: q̇_0 and x_1 … x_{K−1}.
//
// With Φ_k = ∂φ_k/∂x_k, exact, a step is δx_k = c_k + C_k w with w = δq̇_0,
//
//     c_{k+1} = Φ_k c_k + d_k ,   C_{k+1} = Φ_k C_k ,        and w from the upper half of the last one:  C_K w = −c_K .
//
// C_K = ∂q(t_b)/∂q̇_a is singular where the ends are conjugate; what it leaves open stays where it is. A step that does not shorten the gaps is halved.
// Gaps are measured in extents of the path.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "qdot/analysis/linear/shortest_step.hpp"
#include "qdot/analysis/variations/flow_in_pieces.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/outcome.hpp"

namespace qdot {

/// How a search for a motion between two places ended.
enum class BoundaryValueOutcome {
  found,           ///< it is there, and no neighbour of it has the same ends
  conjugate_ends,  ///< to first order, motions that leave q_a differently meet at t_b: there is no motion, or it is one of many
  not_found,       ///< no step of Newton's method closes the gaps any further
  run_failed       ///< a run did not come to its end; run_outcome says why
};

/// The outcome's name, "conjugate_ends".
constexpr const char* name(BoundaryValueOutcome outcome) noexcept {
  return detail::name_in({"found", "conjugate_ends", "not_found", "run_failed"}, outcome);
}

namespace detail {

struct BoundaryValueSearch {
  FlowInPieces leg;                   // from one of the times to the next
  std::vector<std::string> names;     // of the components of x
  std::vector<double> t{};            // K + 1 times
  std::vector<Eigen::VectorXd> x{};   // K + 1 states of the guess; the first and the last have the given q
  int most_iterations = 0;
  double tolerance = 0.0;
};

// How far a search came: states at the times, the runs from there, and their gaps.
struct BoundaryValuePoint {
  std::vector<Eigen::VectorXd> x{};
  std::vector<PieceOfFlow> legs{};
  std::vector<Eigen::VectorXd> gaps{};  // of legs, in extents; the last one of q alone
  double size = std::numeric_limits<double>::infinity();
};

struct BoundaryValueEnd {
  BoundaryValueOutcome outcome = BoundaryValueOutcome::not_found;
  BoundaryValuePoint point{};
  bool conjugate = false;
  int iterations = 0;
  double worst_gap = 0.0, worst_t = 0.0;  // in its own units
  std::string worst{};
  PieceOfFlow failed{};
};

template <class = void>  // compiled only where it is made
class BoundaryValueNewton {
 public:
  explicit BoundaryValueNewton(BoundaryValueSearch search)
      : search_(std::move(search)), n_(static_cast<Eigen::Index>(search_.names.size()) / 2), K_(search_.t.size() - 1) {
    measure();
  }

  BoundaryValueEnd end() {
    BoundaryValueEnd end;
    end.point = at(search_.x);
    for (;; ++end.iterations) {
      BoundaryValuePoint& here = end.point;
      if (!trouble_.message.empty() && !std::isfinite(here.size)) {
        end.outcome = BoundaryValueOutcome::run_failed;
        end.failed = trouble_;
        return end;
      }
      const Direction direction = step(here);
      end.conjugate = direction.conjugate;
      if (here.size <= search_.tolerance) {
        end.outcome = direction.conjugate ? BoundaryValueOutcome::conjugate_ends : BoundaryValueOutcome::found;
        const BoundaryValuePoint polished = moved(here, direction, 1.0);
        if (!direction.conjugate && polished.size < here.size) here = polished;
        name_worst(end);
        return end;
      }
      double fraction = 1.0;
      BoundaryValuePoint next;
      for (; fraction >= 1e-3; fraction *= 0.5) {
        next = moved(here, direction, fraction);
        if (next.size <= (1.0 - 0.25 * fraction) * here.size) break;
      }
      if (fraction < 1e-3 || end.iterations == search_.most_iterations) {
        end.outcome = direction.conjugate ? BoundaryValueOutcome::conjugate_ends : BoundaryValueOutcome::not_found;
        name_worst(end);
        return end;
      }
      here = std::move(next);
    }
  }

 private:
  struct Direction {
    std::vector<Eigen::VectorXd> dx;
    bool conjugate = false;
  };

  void measure() {
    scale_ = Eigen::VectorXd::Zero(2 * n_);
    const double leg = (search_.t.back() - search_.t.front()) / static_cast<double>(K_);
    auto of_q = scale_.head(n_);
    for (const auto& x : search_.x) of_q = of_q.cwiseMax((x - search_.x.front()).head(n_).cwiseAbs());
    const double most = of_q.maxCoeff();
    for (double& scale : of_q)
      if (!(scale > 1e-3 * most)) scale = most > 0.0 ? most : 1.0;
    scale_.tail(n_) = of_q / leg;
  }

  BoundaryValuePoint at(std::vector<Eigen::VectorXd> x) {
    BoundaryValuePoint point;
    point.x = std::move(x);
    double sum = 0.0;
    for (std::size_t k = 0; k < K_; ++k) {
      PieceOfFlow leg;
      try {
        leg = search_.leg(search_.t[k], point.x[k], search_.t[k + 1]);
      } catch (const Error& error) {  // no model there
        leg.outcome = Outcome::solver_error;
        leg.message = error.what();
      }
      if (leg.outcome != Outcome::completed) {
        trouble_ = leg;
        return point;
      }
      point.gaps.push_back((leg.y - point.x[k + 1]).cwiseQuotient(scale_).head(k + 1 < K_ ? 2 * n_ : n_));
      sum += point.gaps.back().squaredNorm();
      point.legs.push_back(std::move(leg));
    }
    point.size = std::sqrt(sum);
    return point;
  }

  Direction step(const BoundaryValuePoint& here) const {
    constexpr double negligible = 1e-7;
    std::vector<Eigen::VectorXd> c(K_ + 1, Eigen::VectorXd::Zero(2 * n_));
    std::vector<Eigen::MatrixXd> C(K_ + 1, Eigen::MatrixXd::Zero(2 * n_, n_));
    C[0].bottomRows(n_).setIdentity();
    double largest = 0.0;
    for (std::size_t k = 0; k < K_; ++k) {
      const Eigen::MatrixXd Phi = scale_.cwiseInverse().asDiagonal() * here.legs[k].Phi * scale_.asDiagonal();
      c[k + 1] = Phi * c[k];
      c[k + 1].head(here.gaps[k].size()) += here.gaps[k];
      C[k + 1] = Phi * C[k];
      largest = std::max(largest, C[k + 1].topRows(n_).norm());
    }
    const double cut = std::min(1.0, negligible * largest / std::max(C[K_].topRows(n_).norm(), 1e-300));
    const ShortestStep solved = shortest_step(C[K_].topRows(n_), -c[K_].head(n_), cut);
    Direction direction;
    direction.conjugate = solved.open.cols() > 0;
    for (std::size_t k = 0; k < K_; ++k) {
      direction.dx.push_back(scale_.cwiseProduct(c[k] + C[k] * solved.x));
    }
    return direction;
  }

  BoundaryValuePoint moved(const BoundaryValuePoint& here, const Direction& direction, double fraction) {
    std::vector<Eigen::VectorXd> x = here.x;
    for (std::size_t k = 0; k < K_; ++k) x[k] += fraction * direction.dx[k];
    return at(std::move(x));
  }

  void name_worst(BoundaryValueEnd& end) const {
    double most = -1.0;
    for (std::size_t k = 0; k < end.point.gaps.size(); ++k)
      for (Eigen::Index i = 0; i < end.point.gaps[k].size(); ++i) {
        if (!(std::abs(end.point.gaps[k][i]) > most)) continue;
        most = std::abs(end.point.gaps[k][i]);
        end.worst = search_.names[static_cast<std::size_t>(i)];
        end.worst_gap = end.point.gaps[k][i] * scale_[i];
        end.worst_t = search_.t[k + 1];
      }
  }

  BoundaryValueSearch search_;
  Eigen::Index n_;
  std::size_t K_;
  Eigen::VectorXd scale_;
  PieceOfFlow trouble_{};
};

template <class = void>  // compiled only where it is called
BoundaryValueEnd boundary_value_end(BoundaryValueSearch search) {
  return BoundaryValueNewton(std::move(search)).end();
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template BoundaryValueEnd boundary_value_end<void>(BoundaryValueSearch);
#endif

}  // namespace detail

}  // namespace qdot
