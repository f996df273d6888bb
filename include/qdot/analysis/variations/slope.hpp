#pragma once
// SPDX-License-Identifier: MIT
//
// Derivatives of what takes numbers only: a user's jump, an event's function, a model made from its parameters.
//
// Where duals cannot go, F(s) is evaluated at seven points, s = −3h … 3h, or 0 … 6h where one side has no model (a coefficient of
// restitution beyond 1). Such an F is computed to rounding, not integrated, so the formula of order six is good to some 1e-12 of the slope:
//
//     F′(0) ≈ (45 (F₁ − F₋₁) − 9 (F₂ − F₋₂) + (F₃ − F₋₃)) / 60h .
//
// Two doubts are looked into, and h made smaller while one of them stands:
//
//     order    the formula of order four says the same
//     kink     F₁ + F₋₁ − 2F₀ grows as h² and not as h:   9 (F₁ + F₋₁ − 2F₀) − (F₃ + F₋₃ − 2F₀) = O(h⁴)
//
// If one stands at the smallest h too, F has no derivative, and none is made up.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "qdot/error.hpp"

namespace qdot::detail {

// Where F is evaluated, in units of h, and the weights of two formulas for h F′(0).
struct SlopePoints {
  std::array<double, 7> at, weight, lower_weight;
  bool central;
};
inline constexpr std::array<SlopePoints, 3> slope_points{{
    {{0, 1, -1, 2, -2, 3, -3}, {0, 0.75, -0.75, -0.15, 0.15, 1 / 60.0, -1 / 60.0}, {0, 2 / 3.0, -2 / 3.0, -1 / 12.0, 1 / 12.0, 0, 0}, true},
    {{0, 1, 2, 3, 4, 5, 6}, {-2.45, 6, -7.5, 20 / 3.0, -3.75, 1.2, -1 / 6.0}, {-137 / 60.0, 5, -5, 10 / 3.0, -1.25, 0.2, 0}, false},
    {{0, -1, -2, -3, -4, -5, -6}, {2.45, -6, 7.5, -20 / 3.0, 3.75, -1.2, 1 / 6.0}, {137 / 60.0, -5, 5, -10 / 3.0, 1.25, -0.2, 0}, false},
}};

// h for parameters of size x: far enough for rounding, near enough for order six.
inline double parameter_step(double x) { return std::ldexp(x != 0.0 ? std::abs(x) : 1.0, -8); }

// Sizes of what the entries of [q; q̇; …] are made from, where projections and impacts mix them: of positions and of velocities the largest.
inline Eigen::VectorXd sizes_beside(Eigen::VectorXd sizes, Eigen::Index dof) {
  for (const Eigen::Index first : {Eigen::Index{0}, dof})
    if (dof > 0) sizes.segment(first, dof).setConstant(sizes.segment(first, dof).maxCoeff());
  return sizes;
}

// F′(0) of a vector function that is known at s of about `reach` and below; nothing where it has none.
//
// @param largest  sizes of entries to whose rounding they are known, where they are larger than the entries; or empty
// @param beside   sizes of what each entry is made from: one that changes by no more than the rounding of this is not looked into; or empty
template <class F>
std::optional<Eigen::VectorXd> slope_at_zero(const F& f, double reach, const Eigen::VectorXd& largest = {}, const Eigen::VectorXd& beside = {}) {
  constexpr double epsilon = std::numeric_limits<double>::epsilon();
  double h = std::ldexp(reach, -7);
  for (int attempt = 0; attempt < 8; ++attempt, h /= 8) {
    for (const SlopePoints& points : slope_points) {
      std::array<Eigen::VectorXd, 7> F_at;
      try {
        for (std::size_t i = 0; i < 7; ++i) F_at[i] = f(points.at[i] * h);
      } catch (const Error&) {
        continue;  // no model there; perhaps on the other side
      }
      Eigen::VectorXd slope = Eigen::VectorXd::Zero(F_at[0].size());
      bool doubtful = false;
      for (Eigen::Index k = 0; k < slope.size() && !doubtful; ++k) {
        double lower = 0.0, most = 0.0, size = largest.size() > 0 ? largest[k] : 0.0;
        for (std::size_t i = 0; i < 7; ++i) {
          const double change = F_at[i][k] - F_at[0][k];
          slope[k] += points.weight[i] * change / h;
          lower += points.lower_weight[i] * change / h;
          most = std::max(most, std::abs(change) / h);
          size = std::max(size, std::abs(F_at[i][k]));
        }
        if (beside.size() > 0 && most * h <= 64 * epsilon * beside[k]) continue;
        const double rounding = 64 * epsilon * size / h;
        doubtful = !(std::abs(slope[k] - lower) <= 1e-6 * most + rounding);
        if (points.central) {
          const double bend = 9 * (F_at[1][k] + F_at[2][k] - 2 * F_at[0][k]) - (F_at[5][k] + F_at[6][k] - 2 * F_at[0][k]);
          doubtful = doubtful || !(std::abs(bend) / h <= 1e-4 * most + rounding);
        }
      }
      if (!doubtful) return slope;
      break;
    }
  }
  return std::nullopt;
}

// F″(0) likewise, of order eight, where order six says the same and F has no kink in its slope, which is odd:
//
//     D(h) = F₂ − F₋₂ − 2 (F₁ − F₋₁)  grows as h³ and not as h² .
template <class F>
std::optional<Eigen::VectorXd> second_slope_at_zero(const F& f, double reach, const Eigen::VectorXd& largest) {
  constexpr double weight[5] = {0, 1.6, -0.2, 8 / 315.0, -1 / 560.0}, lower_weight[5] = {0, 1.5, -0.15, 1 / 90.0, 0};
  constexpr double epsilon = std::numeric_limits<double>::epsilon();
  const Eigen::VectorXd here = f(0.0);
  double h = std::ldexp(reach, -7);
  for (int attempt = 0; attempt < 4; ++attempt, h /= 4) {
    std::array<Eigen::VectorXd, 5> ahead, back;
    for (std::size_t k = 1; k <= 4; ++k) {
      ahead[k] = f(static_cast<double>(k) * h);
      back[k] = f(-static_cast<double>(k) * h);
    }
    Eigen::VectorXd slope(here.size());
    bool doubtful = false;
    for (Eigen::Index i = 0; i < slope.size() && !doubtful; ++i) {  // a loop, which is compiled in a tenth of the time of vectors
      double sum = 0.0, lower = 0.0, most = 0.0, size = std::max(std::abs(here[i]), largest[i]), odd[5];
      for (std::size_t k = 1; k <= 4; ++k) {
        const double both = (ahead[k][i] - here[i]) + (back[k][i] - here[i]);
        odd[k] = ahead[k][i] - back[k][i];
        sum += weight[k] * both / (h * h);
        lower += lower_weight[k] * both / (h * h);
        most = std::max(most, std::abs(both) / (h * h));
        size = std::max({size, std::abs(ahead[k][i]), std::abs(back[k][i])});
      }
      const double rounding = 64 * epsilon / (h * h) * size, nearby = (odd[2] - 2 * odd[1]) / (h * h), distant = (odd[4] - 2 * odd[2]) / (h * h);
      slope[i] = sum;
      doubtful = !(std::abs(sum - lower) <= 1e-9 * most + rounding) || !(std::abs(distant - 8 * nearby) <= 0.03 * most + 8 * rounding);
    }
    if (!doubtful) return slope;
  }
  return std::nullopt;
}

}  // namespace qdot::detail
