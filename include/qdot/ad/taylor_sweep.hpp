#pragma once
// SPDX-License-Identifier: MIT
//
// Power series through a graph, order by order.
//
// Every node's value along the motion is a power series x(s) = Σ x_k sᵏ. If all series are known to order
// k − 1 and the variables to order k, every node follows to order k:
//
//     affine      w_k = Σ c x_k
//     product     w_k = Σ_{j=0…k} a_j b_{k−j}
//     quotient    w_k = (a_k − Σ_{j=1…k} b_j w_{k−j}) / b₀
//     power aᶜ    w_k = Σ_{j=1…k} ((c + 1) j/k − 1) a_j w_{k−j} / a₀           from a w˙ = c w a˙
//     function    w_k = Σ_{j=1…k} (j/k) a_j z_{k−j},  z the slope node         from   w˙ = z a˙
//
// So p orders cost about p²/2 multiplications per node that is not affine, and no transcendental function
// beyond order 0. This header turns a graph into a list of such steps and carries them out.
//
// Two passes per order. In each sum the terms with j = 1 … k − 1 hold lower orders only: these *interiors* do
// not depend on one another and keep the processor's pipelines full. What is left at the *ends* is linear in
// coefficients k, with factors of order 0 that stay the same for all orders:
//
//     product     w_k = interior + b₀ a_k + a₀ b_k          power      w_k = interior + (c w₀/a₀) a_k
//     quotient    w_k = interior + a_k/b₀ − (w₀/b₀) b_k      function   w_k = interior + z₀ a_k
//
// and affine nodes have that form already. So the second pass is one sparse triangular product for all kinds.
//
// *Late* variables. In Lagrange's equations the velocity's next coefficient is not given but follows from
// solving M v_k = …, where the right-hand side needs some nodes at order k as if v_k were zero. So
// advance(k) makes interiors, and the ends of the nodes that do not depend on late variables or that the
// *early outputs* need; the caller solves and sets the late coefficients; complete(k) runs the ends of all
// that depends on them.
//
// Layout. Coefficients k of all nodes stand side by side while order k is made, which makes the ends fast.
// Then those that interiors will need are filed: forwards or backwards, so that an interior is an inner
// product of two contiguous pieces, and for arguments of powers and functions as j a_j.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "qdot/ad/taylor_graph.hpp"

namespace qdot::taylor {

/// Σ a_i b_i of two contiguous pieces.
inline double inner_product(const double* a, const double* b, int count) {
  double even = 0.0, odd = 0.0;
  int i = 0;
  for (; i + 1 < count; i += 2) {
    even += a[i] * b[i];
    odd += a[i + 1] * b[i + 1];
  }
  if (i < count) even += a[i] * b[i];
  return even + odd;
}

/// What a sweep computes.
struct SweepOutputs {
  std::vector<int> early;    ///< nodes needed before the late variables' coefficient is known
  std::vector<int> series;   ///< nodes needed after
  std::vector<int> values;   ///< nodes needed at order 0 only
  std::vector<int> late;     ///< variables whose coefficient is known late
};

/// A graph compiled for computing with power series up to a highest order.
///
/// Memory 16 bytes per node and order, taken in the constructor; nothing is allocated afterwards.
class Sweep {
 public:
  Sweep() = default;
  Sweep(Graph& graph, const SweepOutputs& outputs, int highest_order) : highest_(highest_order) { compile(graph, outputs); }

  /// Where a node lives, for set() and coefficient().
  int slot(int node) const { return slot_of_[index(node)]; }

  /// The value of order 0, as of the last start().
  double value(int slot) const { return values_[index(slot)]; }

  /// The coefficient of the order that was made last.
  double latest(int slot) const { return latest_[index(slot)]; }

  /// Sets a variable's coefficient of the order that comes next: 0 before start(), k before advance(k) or complete(k).
  void set(int slot, double x) { latest_[index(slot)] = x; }

  /// Order 0 of every node, and the factors of the ends.
  void start() {
    for (const int slot : variables_) values_[index(slot)] = latest_[index(slot)];
    for (const Formula& s : formulas_) values_[index(s.slot)] = evaluated(s);
    for (const Formula& s : formulas_)
      if (s.slot < series_count_ && s.kind != Kind::affine) set_end_factors(s);
    std::copy(values_.begin(), values_.begin() + series_count_, latest_.begin());
    file(0);
  }

  /// Order k of the nodes that can be made before the late variables' coefficient k, which must be set to 0.
  void advance(int k) {
    make_interiors(k);
    for (const End& end : early_) make_end(end);
  }

  /// Order k of all other nodes, after the late variables have been set to their coefficient k.
  void complete(int k) {
    for (const End& end : late_) make_end(end);
    file(k);
  }

 private:
  struct Formula {  // of order 0
    Kind kind = Kind::constant;
    Function function = Function::none;
    int slot = 0, a = -1, b = -1;    // slots
    int slope_a = -1, slope_b = -1;  // slots of a function's slopes
    int first = 0, count = 0;        // terms of the end
    double c = 0.0;
  };
  struct Interior {
    int slot;
    std::size_t left, right;  // places in data_: of coefficient 1, and of the backward series
    std::size_t weighted = 0; // place of 1·a₁
    double c = 0.0;
  };
  struct End {  // coefficient k of `slot` is its interior and Σ factor · coefficient k of another
    int slot, first, count;
  };
  struct Place {  // where in data_ the coefficients of a slot are filed
    int slot;
    std::size_t place;
  };

  static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  // Writes coefficients k to where interiors will look for them.
  void file(int k) {
    const std::size_t up = index(k), down = index(highest_ - k);
    for (const Place& p : forward_) data_[p.place + up] = latest_[index(p.slot)];
    for (const Place& p : backward_) data_[p.place + down] = latest_[index(p.slot)];
    for (const Place& p : weighted_) data_[p.place + up] = k * latest_[index(p.slot)];
  }

  double evaluated(const Formula& s) {
    const auto at = [&](int slot) { return values_[index(slot)]; };
    switch (s.kind) {
      case Kind::affine: {
        double w = s.c;
        for (int i = s.first; i < s.first + s.count; ++i) w += factors_[index(i)] * at(terms_[index(i)]);
        return w;
      }
      case Kind::product: return at(s.a) * at(s.b);
      case Kind::quotient: return at(s.a) / at(s.b);
      case Kind::power:
        return s.c == -1.0 ? 1.0 / at(s.a) : s.c == 0.5 ? std::sqrt(at(s.a)) : std::pow(at(s.a), s.c);
      case Kind::function: return value_of(s.function, at(s.a), s.b < 0 ? 0.0 : at(s.b));
      default: return at(s.slot);
    }
  }

  void set_end_factors(const Formula& s) {
    const auto at = [&](int slot) { return values_[index(slot)]; };
    double* factor = factors_.data() + s.first;
    switch (s.kind) {
      case Kind::product:
        factor[0] = s.a == s.b ? 2.0 * at(s.a) : at(s.b);
        if (s.a != s.b) factor[1] = at(s.a);
        break;
      case Kind::quotient:
        inverse_[index(s.slot)] = 1.0 / at(s.b);
        factor[0] = inverse_[index(s.slot)];
        factor[1] = -at(s.slot) * factor[0];
        break;
      case Kind::power:
        inverse_[index(s.slot)] = 1.0 / at(s.a);
        factor[0] = s.c * at(s.slot) * inverse_[index(s.slot)];
        break;
      case Kind::function:
        factor[0] = at(s.slope_a);
        if (s.b >= 0) factor[1] = at(s.slope_b);
        break;
      default: break;
    }
  }

  void make_interiors(int k) {
    const int count = k - 1;  // j = 1 … k − 1
    const double inverse_k = 1.0 / k;
    const double* data = data_.data();
    const std::size_t shift = index(highest_ - k + 1);  // of b_{k−1} in a backward series
    for (const Interior& s : products_) interior_[index(s.slot)] = inner_product(data + s.left, data + s.right + shift, count);
    for (const Interior& s : squares_) {
      const double half = inner_product(data + s.left, data + s.right + shift, count / 2);
      const double middle = count % 2 == 1 ? data[s.left + index(count / 2)] : 0.0;
      interior_[index(s.slot)] = 2.0 * half + middle * middle;
    }
    for (const Interior& s : quotients_)
      interior_[index(s.slot)] = -inverse_[index(s.slot)] * inner_product(data + s.left, data + s.right + shift, count);
    for (const Interior& s : powers_)
      interior_[index(s.slot)] = inverse_[index(s.slot)] *
                                 ((s.c + 1.0) * inverse_k * inner_product(data + s.weighted, data + s.right + shift, count) -
                                  inner_product(data + s.left, data + s.right + shift, count));
    for (const Interior& s : functions_)
      interior_[index(s.slot)] = inverse_k * inner_product(data + s.weighted, data + s.right + shift, count);
    for (const Interior& s : second_arguments_)
      interior_[index(s.slot)] += inverse_k * inner_product(data + s.weighted, data + s.right + shift, count);
  }

  void make_end(const End& end) {
    double w = interior_[index(end.slot)];
    for (int i = end.first; i < end.first + end.count; ++i) w += factors_[index(i)] * latest_[index(terms_[index(i)])];
    latest_[index(end.slot)] = w;
  }

  void compile(Graph& graph, const SweepOutputs& outputs);
  void add_interior(const Formula& s);

  int highest_ = 0;
  int series_count_ = 0;                        // slots below carry series, those above a value only
  std::vector<int> slot_of_;                    // of each node; −1 if it is not needed
  std::vector<Formula> formulas_;               // in the order of computing
  std::vector<Interior> products_, squares_, quotients_, powers_, functions_, second_arguments_;
  std::vector<End> early_, late_;
  std::vector<int> terms_;                      // slots
  std::vector<double> factors_;
  std::vector<int> variables_;                  // slots
  std::vector<Place> forward_, backward_, weighted_;
  std::vector<double> data_;                    // series of highest order + 1 coefficients
  std::vector<double> values_, inverse_, interior_, latest_;
};

}  // namespace qdot::taylor

#include "qdot/ad/taylor_sweep_compile.hpp"
