#pragma once
// SPDX-License-Identifier: MIT
//
// Power series of many columns side by side.
//
// Columns x of Φ, and what is made of them, obey linear equations with the same coefficients. So order k of all of them consists of sums Σ_j w_j x_{k−j} whose
// numbers w all columns share. Here x is stored order by order, a row for each component with all columns in it, and the weights with the highest order
// first. Then both are read in the same direction, and a register holds as many columns as it can.

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "qdot/ad/pack.hpp"

namespace qdot::detail {

struct SeriesColumns {
  Eigen::Index state = 0, count = 0, stride = 0, place = 0;  // size of each, how many, with what fills the last register, and where they begin in y
  std::vector<double> x;                                     // of all orders, a row for each component
  std::vector<double> sums;                                  // of each equation

  SeriesColumns() = default;
  SeriesColumns(Eigen::Index state_, Eigen::Index count_, Eigen::Index place_, int highest_order, Eigen::Index equations)
      : state(state_), count(count_), stride((count_ + register_lanes - 1) / register_lanes * register_lanes), place(place_) {
    x.assign(static_cast<std::size_t>(state * (highest_order + 1) * stride), 0.0);
    sums.assign(static_cast<std::size_t>(equations * stride), 0.0);
  }

  double& at(int k, Eigen::Index i, Eigen::Index c) { return x[static_cast<std::size_t>((state * k + i) * stride + c)]; }
  double* sums_of(Eigen::Index equation) { return sums.data() + equation * stride; }

  using Lanes = Register<double, register_lanes>;
  static void read(Lanes& x, const double* from) { __builtin_memcpy(&x, from, sizeof x); }
  static void write(double* to, const Lanes& x) { __builtin_memcpy(to, &x, sizeof x); }

  // into ← Σ w x of the first rows, an even number, from the register on in which column `first` is.
  void sum(const double* w, Eigen::Index rows, Eigen::Index first, double* into) const {
    for (Eigen::Index c = first / register_lanes * register_lanes; c < stride; c += register_lanes) {
      Lanes even{}, odd{}, a, b;
      const double* from = x.data() + c;
      for (Eigen::Index l = 0; l < rows; l += 2, from += 2 * stride) {
        read(a, from);
        read(b, from + stride);
        even += w[l] * a;
        odd += w[l + 1] * b;
      }
      write(into + c, even + odd);
    }
  }

  // into ← Σ w x of some components only, in orders 0 … k; the weights of each stand together, `apart` from those of the next.
  void sum_of(std::span<const Eigen::Index> components, const double* w, std::size_t apart, int k, double* into) const {
    const Eigen::Index order = state * stride;
    for (Eigen::Index c = 0; c < stride; c += register_lanes) {
      Lanes even{}, odd{}, a, b;
      const double* weights = w;
      for (const Eigen::Index l : components) {
        const double* from = x.data() + l * stride + c;
        int j = 0;
        for (; j < k; j += 2, from += 2 * order) {
          read(a, from);
          read(b, from + order);
          even += weights[j] * a;
          odd += weights[j + 1] * b;
        }
        if (j == k) {
          read(a, from);
          even += weights[j] * a;
        }
        weights += apart;
      }
      write(into + c, even + odd);
    }
  }
};

}  // namespace qdot::detail
