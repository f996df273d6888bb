#pragma once
// SPDX-License-Identifier: MIT
//
// Power series through a graph, order by order: x(s) = Σ x_k sᵏ of every node, from orders up to k − 1 and the variables' k.
//
//     affine      w_k = Σ c x_k                                 product     w_k = Σ_{j=0…k} a_j b_{k−j}
//     quotient    w_k = (a_k − Σ_{j=1…k} b_j w_{k−j}) / b₀
//     power aᶜ    w_k = Σ_{j=1…k} ((c + 1) j/k − 1) a_j w_{k−j} / a₀           from a w˙ = c w a˙
//     function    w_k = Σ_{j=1…k} (j/k) a_j z_{k−j},  z the slope node         from   w˙ = z a˙
//
// p orders cost about p²/2 multiplications per node that is not affine, and no transcendental function beyond order 0.
// Two passes per order. The terms j = 1 … k − 1 of a sum, its *interior*, hold lower orders only, so interiors do not
// depend on one another. The *ends* are linear in coefficients k, with factors of order 0 that stay the same for all
// orders:
//
//     product     w_k = interior + b₀ a_k + a₀ b_k          power      w_k = interior + (c w₀/a₀) a_k
//     quotient    w_k = interior + a_k/b₀ − (w₀/b₀) b_k      function   w_k = interior + z₀ a_k

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "qdot/ad/formula/graph.hpp"
#include "qdot/ad/formula/lines.hpp"
#include "qdot/ad/native/line_evaluator.hpp"
#include "qdot/ad/series/interiors.hpp"
#include "qdot/ad/series/sweep_outputs.hpp"

namespace qdot::taylor {

/// A graph compiled for computing with power series up to a highest order.
///
/// Memory 16 bytes per nonlinear operation and order, taken in the constructor. Later only machine code is allocated, once for each table.
class Sweep {
 public:
  Sweep() = default;
  Sweep(Graph& graph, const SweepOutputs& outputs, int highest_order) : highest_(highest_order) { compile(graph, outputs); }

  /// Where a node lives, for set(), value() and latest().
  int slot(int node) const { return slot_of_[index(node)]; }

  /// The value of order 0, as of the last start().
  double value(int slot) const { return values_[index(slot)]; }

  /// The coefficient of the order that was made last; between advance() and complete() as if the late variables' coefficients were zero.
  double latest(int slot) const { return x_[number_[is_early_ ? 0 : 1][index(slot)]]; }

  /// A variable's coefficient of the order that was made last.
  double variable(int slot) const { return x_[number_[1][index(slot)]]; }

  /// Sets a variable's coefficient of the order that comes next: 0 before start(), k before advance(k) or complete(k).
  void set(int slot, double x) { x_[number_[1][index(slot)]] = x; }

  /// Sets τ, and where there is a recurrence, L and 1/D of M₀ = L D Lᵀ: row by row, 1/D on the diagonal; after start().
  void set_time_unit(double unit) { unit_ = unit; }
  std::span<double> mass_factors() { return {x_.data() + mass_factors_, recurrence_.mass.size()}; }
  /// And of rows, B = L⁻¹W₀ᵀ and S = Bᵀ D⁻¹ B = L' D' L'ᵀ: D⁻¹B and B, a row of W after the other, then L' with 1/D' on the diagonal.
  std::span<double> row_factors() { return {x_.data() + row_factors_, 2 * recurrence_.jacobian.size() + triangle(recurrence_.rows.size())}; }
  /// λ_{k−1}, where order k was made last.
  double multiplier(std::size_t row) const { return x_[number_[1][first_multiplier_ + row]]; }

  /// When the lines of an order become machine code, from here on.
  [[gnu::cold]] void begin_machine_code(formula::MachineCodeBegins begins) {
    for (formula::LineEvaluator& end : ends_) end.begin(begins);
  }

  /// Order 0 of every node, and the factors of the ends.
  void start() {
    for (const int slot : variables_) values_[index(slot)] = x_[number_[1][index(slot)]];
    for (const Formula& s : formulas_) evaluate(s);
    for (const Formula& s : series_) set_end_factors(s);
    for (std::size_t slot = 0; slot < index(series_count_); ++slot)
      if (number_[1][slot] != zero) x_[number_[1][slot]] = values_[slot];
    for (std::size_t i = 0; i < rates_.size(); ++i) x_[first_rate_ + i] = values_[index(rates_[i])];
    is_early_ = false;
  }

  /// Order k of the nodes that can be made before the late variables' coefficient k; where there is a recurrence, of all variables.
  ///
  /// Late variables are velocities: coefficient k follows from M v_k = …, whose right side needs some nodes, the early outputs, as if v_k were zero. So
  /// this makes all interiors, and the ends of nodes that do not depend on late variables or that early outputs need.
  void advance(int k) {
    if (time_ != zero) x_[time_] = k == 1 ? unit_ : 0.0;
    x_[rate_number] = unit_ / k;
    for (const int slot : constants_) x_[number_[1][index(slot)]] = 0.0;
    x_[order_number] = k;
    x_[inverse_order_number] = 1.0 / k;
    add_interiors_(rows_, index(k), x_.data() + interiors_);
    ends_[0](x_.data());
    is_early_ = true;
  }

  /// Order k of all other nodes, after the late variables have been set to their coefficient k.
  void complete(int k) {
    ends_[1](x_.data());
    is_early_ = false;
    write_rows(rows_, index(k), x_.data());
  }

 private:
  struct Formula {  // of order 0
    Kind kind = Kind::constant;
    Function function = Function::none;
    int slot = 0, a = -1, b = -1;    // slots
    int slope_a = -1, slope_b = -1;  // slots of a function's slopes
    int partner = -1;                // of a sine the cosine of the same argument, and the other way round
    int first = 0, count = 0;        // terms of the end
    int factor = 0;                  // of the end, two numbers; that of a term of a sum is a constant
    double c = 0.0;
  };
  // An interior Σ_{j=1…k−1} L_j R_{k−j}. Coefficients j of all left factors are in one row, those of the right ones in another: one instruction works for as
  // many lanes as a register holds (interiors.hpp). Where L_j is j a_j, it is stored like that.
  struct Lane {  // slots of the factors
    int left, right;
  };
  struct Interior {  // of a lane that needs more than its sum
    int factor, lane, other;
    double c = 0.0;
  };
  struct End {  // coefficient k of `slot` is its interior and Σ factor · coefficient k of another
    int slot, lane, first, terms, factor, depth;
    bool early, late;
  };
  using Number = std::uint32_t;
  static constexpr Number order_number = 0, inverse_order_number = 1, rate_number = 2, zero = 3, first_factor = 4;  // k, 1/k, τ/k, 0

  static constexpr std::size_t index(int i) { return static_cast<std::size_t>(i); }

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
    double* factor = x_.data() + s.factor;
    switch (s.kind) {
      case Kind::product:
        factor[0] = s.a == s.b ? 2.0 * at(s.a) : at(s.b);
        if (s.a != s.b) factor[1] = at(s.a);
        break;
      case Kind::quotient:
        factor[0] = 1.0 / at(s.b);
        factor[1] = -at(s.slot) * factor[0];
        break;
      case Kind::power:
        factor[1] = 1.0 / at(s.a);
        factor[0] = s.c * at(s.slot) * factor[1];
        break;
      case Kind::function:
        factor[0] = at(s.slope_a);
        if (s.b >= 0 && s.b == s.a) factor[0] += at(s.slope_b);
        else if (s.b >= 0) factor[1] = at(s.slope_b);
        break;
      default: break;
    }
  }

  void compile(Graph& graph, const SweepOutputs& outputs);
  void add_node(const class SweptNodes& nodes, int w, int& next_factor, std::vector<End>& made);
  void add_affine_terms(const SweptNodes& nodes, int w, Formula& s);
  void add_arguments(const SweptNodes& nodes, int w, Formula& s);
  void pair_sines_with_cosines();
  int add_interior(const Formula& s);
  int final_lane(int lane) const;
  void take_recurrence(const Graph& graph, const Recurrence& recurrence);
  void place_lanes();
  static constexpr std::size_t triangle(std::size_t n) { return n * (n + 1) / 2; }
  void write_ends(const std::vector<End>& ends, const std::vector<char>& is_late, const std::vector<char>& is_read, Number next);
  Number after_inputs(const std::vector<char>& is_late, Number next);
  std::vector<Number> finished_interiors(class LineList& early) const;
  using EndTerm = std::pair<int, Number>;  // which of an end's terms, and its coefficient
  std::vector<EndTerm> terms_in(const std::vector<Number>& number, const End& end, const std::vector<char>& is_constant) const;
  Number end_sum(LineList& lines, const End& end, const std::vector<EndTerm>& terms, const std::vector<Number>& interior) const;
  void solve_for_late(LineList& early, const std::vector<Number>& interior);
  void set_rows();
  void set_tables(std::array<formula::LineTable, 2> tables, const std::vector<char>& is_read);

  static constexpr int weighted_mark = 1 << 28, square_mark = 1 << 29;  // on lanes that are not placed yet

  int highest_ = 0;
  int series_count_ = 0;                        // slots below carry series, those above a value only
  std::vector<int> slot_of_;                    // of each node; −1 if it is not needed
  std::vector<Formula> formulas_;               // in the order of computing
  std::vector<Formula> series_;                 // of them those with series and not affine
  std::vector<Lane> plain_, weighted_;          // the lanes, one after the other
  std::vector<int> squares_;                    // slots of what is squared
  std::vector<Interior> quotients_, powers_, second_arguments_;
  std::vector<int> terms_;                      // slots
  std::vector<double> factors_;                 // of affine terms
  std::vector<int> variables_, constants_;      // slots
  SeriesRows rows_;
  decltype(fastest_interiors()) add_interiors_ = fastest_interiors();
  std::vector<double> values_;                  // of slots
  std::vector<double> x_;                       // the numbers of the lines
  Recurrence recurrence_;
  std::vector<int> rates_;                      // slots of rates, then of forces
  Number first_rate_ = 0, mass_factors_ = 0, row_factors_ = 0, time_ = zero;
  std::size_t first_multiplier_ = 0;            // slots of multipliers, which no node has
  struct Reaction {
    int lane;
    std::size_t column;
  };
  std::vector<Reaction> reactions_;             // Σ W_j λ_{k−1−j} of an entry of W that is not constant
  double unit_ = 1.0;
  std::size_t interiors_ = 0;                   // where sums of lanes, then of squares, stand in it
  std::array<std::vector<Number>, 2> number_;   // of a slot's coefficient among them, before and after the late variables are known
  std::array<formula::LineEvaluator, 2> ends_;  // lines on x_: before the late variables are known, where these are left out as zeros, and after
  bool is_early_ = false;
};

// What a method asks of a sweep, compiled once in a program, or in the library (qdot::compiled).
template <class Number = double>
Sweep sweep_of(formula::BasicGraph<Number>& graph, const SweepOutputs& outputs, int highest_order) {
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
extern template Sweep sweep_of<double>(formula::BasicGraph<double>&, const SweepOutputs&, int);
extern template void start<double>(Sweep&);
extern template void advance<double>(Sweep&, int);
extern template void complete<double>(Sweep&, int);
#endif

}  // namespace qdot::taylor

#include "qdot/ad/series/sweep.ipp"
