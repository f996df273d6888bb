#pragma once
// SPDX-License-Identifier: MIT
//
// The function of limit_of_slopes.hpp. A program that links qdot::compiled has it from there.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>

#include <Eigen/Core>

#include "qdot/error.hpp"
#include "qdot/mechanics/equations/limit_of_slopes.hpp"

namespace qdot::detail {

template <class>
bool slopes_in_the_limit(const Eigen::VectorXd& y, Eigen::Index dof, Eigen::MatrixXd& J,
                         const std::function<void(const Eigen::VectorXd&, Eigen::MatrixXd&)>& slopes_at) {
  constexpr double beside_zero = 1e-30, beside_others = 0x1p-40, agreement = 1e-6;
  Eigen::VectorXd distance(y.size());
  std::fill_n(distance.data(), distance.size(), 0.0);
  for (const Eigen::Index first : {Eigen::Index(0), dof}) {
    const Eigen::Index end = std::min(first + dof, y.size());
    double least = 0.0;  // of the entries that are not zero
    for (Eigen::Index i = first; i < end; ++i)
      if (y[i] != 0.0 && (least == 0.0 || std::abs(y[i]) < least)) least = std::abs(y[i]);
    for (Eigen::Index i = first; i < end; ++i)
      distance[i] = y[i] != 0.0 ? beside_others * std::abs(y[i]) : least > 0.0 ? beside_others * least : beside_zero;
  }
  std::array<Eigen::MatrixXd, 8> at;
  for (std::size_t k = 0; k < at.size(); ++k) {
    Eigen::VectorXd place = y;
    for (Eigen::Index i = 0; i < y.size(); ++i) {
      const bool opposite = (std::popcount(static_cast<std::uint64_t>(i) & (k / 2)) + static_cast<int>(k)) % 2 != 0;
      const double size = 0.5 + std::fmod(0.618 * static_cast<double>((i + 1)) * static_cast<double>(k / 2 + 1), 1.0);
      place[i] += (opposite ? -size : size) * distance[i];
    }
    try {
      slopes_at(place, at[k]);
    } catch (const Error&) {
      return false;
    }
  }
  J.resize(at[0].rows(), at[0].cols());
  std::fill_n(J.data(), J.size(), 0.0);
  for (Eigen::Index i = 0; i < J.rows(); ++i) {
    double largest = 0.0, apart = 0.0;
    for (Eigen::Index j = 0; j < J.cols(); ++j)
      for (const Eigen::MatrixXd& each : at) {
        if (!std::isfinite(each(i, j))) return false;
        J(i, j) += each(i, j) / static_cast<double>(at.size());
        largest = std::max(largest, std::abs(each(i, j)));
        apart = std::max(apart, std::abs(each(i, j) - at[0](i, j)));
      }
    if (apart > std::max(agreement * largest, beside_zero)) return false;
  }
  return true;
}

}  // namespace qdot::detail
