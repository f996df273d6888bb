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
// Layout. Every interior is a sum Σ_{j=1…k−1} L_j R_{k−j}: one *lane*. Coefficient j of all lanes' left factors stands in one
// row, that of the right factors in another, so that one instruction works for as many lanes as a register holds and
// no lane waits for its own sum. Where L_j is j a_j, it is stored so. Rows are filled when an order is complete.
// Coefficients k of all nodes stand side by side while order k is made, which makes the ends fast.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "qdot/ad/formula/graph.hpp"

namespace qdot::taylor {

// The formulas that are swept.
using formula::actual, formula::BasicGraph, formula::BasicNode, formula::decisive, formula::Function, formula::Kind, formula::power_of, formula::value_of;

/// What one register holds. (GCC keeps wider vectors that are summed up in a loop in memory.)
#if defined(__AVX512F__)
inline constexpr int register_lanes = 8;
#elif defined(__AVX__)
inline constexpr int register_lanes = 4;
#else
inline constexpr int register_lanes = 2;
#endif
using Lanes [[gnu::vector_size(8 * register_lanes)]] = double;
[[gnu::always_inline]] inline void read(Lanes& x, const double* from) { __builtin_memcpy(&x, from, sizeof x); }
[[gnu::always_inline]] inline void write(double* to, const Lanes& x) { __builtin_memcpy(to, &x, sizeof x); }

/// What a sweep computes.
struct SweepOutputs {
  std::vector<int> early;    ///< nodes needed before the late variables' coefficient is known
  std::vector<int> series;   ///< nodes needed after
  std::vector<int> values;   ///< nodes needed at order 0 only
  std::vector<int> late;     ///< variables whose coefficient is known late
};

/// A graph compiled for computing with power series up to a highest order.
///
/// Memory 16 bytes per nonlinear operation and order, taken in the constructor; nothing is allocated afterwards.
class Sweep {
 public:
  Sweep() = default;
  template <class Coefficient>
  constexpr Sweep(BasicGraph<Coefficient>& graph, const SweepOutputs& outputs, int highest_order) : highest_(highest_order) {
    compile(graph, outputs);
  }

  /// Where a node lives, for set() and coefficient().
  constexpr int slot(int node) const { return slot_of_[index(node)]; }

  /// The value of order 0, as of the last start().
  double value(int slot) const { return values_[index(slot)]; }

  /// The coefficient of the order that was made last.
  double latest(int slot) const { return latest_[index(slot)]; }

  /// Sets a variable's coefficient of the order that comes next: 0 before start(), k before advance(k) or complete(k).
  void set(int slot, double x) { latest_[index(slot)] = x; }

  /// Order 0 of every node, and the factors of the ends.
  void start() {
    for (const int slot : variables_) values_[index(slot)] = latest_[index(slot)];
    for (const Formula& s : formulas_) evaluate(s);
    for (const Formula& s : series_) set_end_factors(s);
    std::copy(values_.begin(), values_.begin() + series_count_, latest_.begin());
    file(0);
  }

  /// Order k of the nodes that can be made before the late variables' coefficient k, which must be set to 0.
  void advance(int k) {
    for (const int slot : constants_) latest_[index(slot)] = 0.0;
    make_interiors(k);
    make_ends(early_);
  }

  /// Order k of all other nodes, after the late variables have been set to their coefficient k.
  void complete(int k) {
    make_ends(late_);
    file(k);
  }

 private:
  struct Formula {  // of order 0
    Kind kind = Kind::constant;
    Function function = Function::none;
    int slot = 0, a = -1, b = -1;    // slots
    int slope_a = -1, slope_b = -1;  // slots of a function's slopes
    int partner = -1;                // of a sine the cosine of the same argument, and the other way round
    int first = 0, count = 0;        // terms of the end
    double c = 0.0;
  };
  struct Lane {  // slots of the factors
    int left, right;
  };
  struct Interior {  // of a lane that needs more than its sum
    int slot, lane, other;
    double c = 0.0;
  };
  struct End {  // coefficient k of `slot` is its interior and Σ factor · coefficient k of another
    int slot, lane, first;
  };
  struct Ends {  // those that follow each other and have the same number of terms
    int terms, first, last;
  };

  static constexpr std::size_t index(int i) { return static_cast<std::size_t>(i); }

  // Writes coefficients k to the rows of the lanes.
  void file(int k) {
    double* const left = left_.data() + index(k) * width_;
    double* const right = right_.data() + index(k) * width_;
    const double* const latest = latest_.data();
    const std::size_t plain = plain_.size(), all = plain + weighted_.size();
    for (std::size_t i = 0; i < plain; ++i) {
      left[i] = latest[plain_[i].left];
      right[i] = latest[plain_[i].right];
    }
    for (std::size_t i = plain; i < all; ++i) {
      left[i] = k * latest[weighted_[i - plain].left];
      right[i] = latest[weighted_[i - plain].right];
    }
    double* const square = square_.data() + index(k) * square_width_;
    for (std::size_t i = 0; i < squares_.size(); ++i) square[i] = latest[squares_[i]];
  }

  void evaluate(const Formula& s) {
    if (s.kind != Kind::function || s.partner < 0) {
      values_[index(s.slot)] = evaluated(s);
    } else if (s.function == Function::sin) {  // side by side, so that compilers make one call of both
      const double a = values_[index(s.a)];
      values_[index(s.slot)] = std::sin(a);
      values_[index(s.partner)] = std::cos(a);
    }
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
        return power_of_value(at(s.a), s.c);
      case Kind::function: return value_of(s.function, at(s.a), s.b < 0 ? 0.0 : at(s.b));
      default: return at(s.slot);
    }
  }

  // xᶜ, with the few powers that laws of nature consist of by roots.
  static double power_of_value(double x, double c) {
    if (c == -1.0) return 1.0 / x;
    if (c == 0.5) return std::sqrt(x);
    if (c == -0.5) return 1.0 / std::sqrt(x);
    if (c == -1.5) return 1.0 / (x * std::sqrt(x));
    return std::pow(x, c);
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
    const double inverse_k = 1.0 / k;
    double* const sum = interior_.data();
    const double* const left = left_.data();
    const double* const right = right_.data();
    const std::size_t last_row = index(k - 1);
    // Two registers at a time, and two terms of each sum, so that few additions wait for others.
    constexpr std::size_t one = register_lanes, two = 2 * one;
    const std::size_t width = width_;
    for (std::size_t lane = 0; lane < width; lane += two) {
      Lanes a{}, b{}, c{}, d{}, x, y;
      const double* l = left + width + lane;              // order 1
      const double* r = right + last_row * width + lane;  // order k − 1
      const auto add = [&](Lanes& first, Lanes& second) __attribute__((always_inline)) {
        read(x, l);
        read(y, r);
        first += x * y;
        read(x, l + one);
        read(y, r + one);
        second += x * y;
        l += width;
        r -= width;
      };
      std::size_t left_over = last_row;
      for (; left_over > 1; left_over -= 2) {
        add(a, b);
        add(c, d);
      }
      if (left_over > 0) add(a, b);
      write(sum + lane, a + c);
      write(sum + lane + one, b + d);
    }
    for (std::size_t i = plain_.size(); i < plain_.size() + weighted_.size(); ++i) sum[i] *= inverse_k;
    double* const squares = sum + width_;
    for (std::size_t lane = 0; lane < square_width_; lane += one) {
      Lanes half{}, x, y;
      for (std::size_t j = 1; 2 * j < index(k); ++j) {
        read(x, square_.data() + j * square_width_ + lane);
        read(y, square_.data() + (index(k) - j) * square_width_ + lane);
        half += x * y;
      }
      half += half;
      if (k % 2 == 0) {
        read(x, square_.data() + index(k / 2) * square_width_ + lane);
        half += x * x;
      }
      write(squares + lane, half);
    }
    for (const Interior& s : quotients_) sum[s.lane] *= -inverse_[index(s.slot)];
    for (const Interior& s : powers_) sum[s.lane] = inverse_[index(s.slot)] * ((s.c + 1.0) * sum[s.other] - sum[s.lane]);
    for (const Interior& s : second_arguments_) sum[s.lane] += sum[s.other];
  }

  void make_ends(const std::vector<Ends>& groups) {
    double* const latest = latest_.data();
    const double* const interior = interior_.data();
    const double* const factors = factors_.data();
    const int* const terms = terms_.data();
    for (const Ends& group : groups) {
      const End* const last = ends_.data() + group.last;
      const End* end = ends_.data() + group.first;
      if (group.terms == 2) {
        for (; end != last; ++end) {
          const int i = end->first;
          latest[end->slot] = (interior[end->lane] + factors[i] * latest[terms[i]]) + factors[i + 1] * latest[terms[i + 1]];
        }
      } else if (group.terms == 1) {
        for (; end != last; ++end) latest[end->slot] = interior[end->lane] + factors[end->first] * latest[terms[end->first]];
      } else {
        for (; end != last; ++end) {
          double w = interior[end->lane];
          for (int i = end->first; i < end->first + group.terms; ++i) w += factors[i] * latest[terms[i]];
          latest[end->slot] = w;
        }
      }
    }
  }

  template <class Coefficient>
  constexpr void compile(BasicGraph<Coefficient>& graph, const SweepOutputs& outputs);
  constexpr void pair_sines_with_cosines();
  constexpr int add_interior(const Formula& s);
  constexpr int final_lane(int lane) const;
  constexpr void place_lanes();

  static constexpr int weighted_mark = 1 << 28, square_mark = 1 << 29;  // on lanes that are not placed yet

  int highest_ = 0;
  int series_count_ = 0;                        // slots below carry series, those above a value only
  std::vector<int> slot_of_;                    // of each node; −1 if it is not needed
  std::vector<Formula> formulas_;               // in the order of computing
  std::vector<Formula> series_;                 // of them those with series and not affine
  std::vector<Lane> plain_, weighted_;          // the lanes, one after the other
  std::vector<int> squares_;                    // slots of what is squared
  std::vector<Interior> quotients_, powers_, second_arguments_;
  std::vector<End> ends_;
  std::vector<Ends> early_, late_;
  std::vector<int> terms_;                      // slots
  std::vector<double> factors_;
  std::vector<int> variables_, constants_;      // slots
  std::size_t width_ = 0, square_width_ = 0;    // of a row
  std::vector<double> left_, right_, square_;   // a row for each order
  std::vector<double> interior_;                // of lanes, then of squares, then a zero
  std::vector<double> values_, inverse_, latest_;
};

// What a method asks of a sweep, compiled once in a program, or in the library (qdot::compiled).
template <class Number = double>
Sweep sweep_of(BasicGraph<Number>& graph, const SweepOutputs& outputs, int highest_order) {
  return Sweep(graph, outputs, highest_order);
}
template <class Number = double>
void start(Sweep& sweep) {
  sweep.start();
}
template <class Number = double>
void advance(Sweep& sweep, int k) {
  sweep.advance(k);
}
template <class Number = double>
void complete(Sweep& sweep, int k) {
  sweep.complete(k);
}

#ifdef QDOT_COMPILED
extern template Sweep sweep_of<double>(BasicGraph<double>&, const SweepOutputs&, int);
extern template void start<double>(Sweep&);
extern template void advance<double>(Sweep&, int);
extern template void complete<double>(Sweep&, int);
#endif

}  // namespace qdot::taylor

#include "qdot/ad/series/sweep_compile.hpp"
