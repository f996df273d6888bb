#pragma once
// SPDX-License-Identifier: MIT
//
// A scalar that writes down what is done to it.
//
// Recorded is fed to T and V like any other scalar. It has no value: a sum of two Recorded is the graph
// node "sum of these two" (ad/formula/graph.hpp). Plain numbers stay plain until they meet a recorded one.
//
// The recording holds for every state only if the functor does the same operations everywhere. So
// comparing two Recorded by size, and functions with a kink (abs, min, max, floor), are refused with
// NotAnalytic: a formula with a branch is not one power series. One comparison is allowed, because guards like `if (r == 0)` are
// common and right. x == c is answered "no", and the node and c are noted as an assumption, which is checked at every point of
// expansion. A recorded number has no plain value either.
//
// A recording that is given the values of its variables (Recording::branches) answers comparisons by them, and notes the guards on which the branch
// that it has taken depends (ad/formula/branches.hpp).

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <concepts>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/ad/dual_math.hpp"
#include "qdot/ad/formula/branches.hpp"
#include "qdot/ad/formula/domains.hpp"
#include "qdot/ad/formula/formula_number.hpp"
#include "qdot/ad/formula/graph.hpp"
#include "qdot/error.hpp"

namespace qdot {

namespace formula {

/// What a recording of some functors has found.
struct Recording {
  struct Assumption {  ///< that this node never takes this value
    int node;
    double value;
    friend bool operator==(const Assumption&, const Assumption&) = default;
  };
  struct Turning {  ///< of a body: Ω = W ṗ, the numbers p with their rates, V with W V = 1 row by row, and what is not zero where W has full rank
    std::array<int, 3> omega;
    std::vector<std::pair<int, int>> coordinates;
    std::vector<int> inverse;
    int regular;
  };
  Graph graph;
  std::vector<Assumption> assumptions;
  std::vector<double> answers;  ///< to all comparisons that functors made, in their order: 1 or 0; and what they were given by floor
  std::vector<Turning> turnings;
  std::string source = "T or V";  ///< what is being run, for messages
  Branches* branches = nullptr;   ///< values and guards, where comparisons are answered; lives elsewhere
};

// The operations of two numbers.
enum class BinaryOperation : unsigned char { sum, difference, product, quotient, hypot, atan2 };

// Nodes of a recording, made while functors are run: once, so that nothing is gained where it is inlined into them.
template <class Number = double>
int operation_in(Recording& recording, BinaryOperation operation, int a, int b) {
  Graph& g = recording.graph;
  switch (operation) {
    case BinaryOperation::sum: return g.sum(a, b);
    case BinaryOperation::difference: return g.difference(a, b);
    case BinaryOperation::product: return g.product(a, b);
    case BinaryOperation::quotient: restrict_to(Domain::nonzero, g, b); return g.quotient(a, b);
    case BinaryOperation::hypot: return g.function(Function::hypot, a, b);
    case BinaryOperation::atan2: break;
  }
  return g.function(Function::atan2, a, b);
}
template <class Number = double>
int function_in(Recording& recording, Function f, int a) {
  restrict_to_function(recording.graph, f, a);
  return recording.graph.function(f, a);
}
template <class Number = double>
int power_in(Recording& recording, int a, double exponent) {
  restrict_to_power(recording.graph, a, exponent);
  return recording.graph.power(a, exponent);
}
template <class Number = double>
int constant_in(Recording& recording, double c) {
  return recording.graph.constant(c);
}

template <class Number = double>
int variable_in(Recording& recording, int number) {
  return recording.graph.variable(number);
}

#ifdef QDOT_COMPILED
extern template int variable_in<double>(Recording&, int);
extern template int operation_in<double>(Recording&, BinaryOperation, int, int);
extern template int function_in<double>(Recording&, Function, int);
extern template int power_in<double>(Recording&, int, double);
extern template int constant_in<double>(Recording&, double);
#endif

/// A number of a formula that is being recorded.
class Recorded : public FormulaNumber<Recorded> {
 public:
  static constexpr bool is_recorded = true;

  constexpr Recorded() = default;
  template <class Number>
    requires std::is_arithmetic_v<Number>
  constexpr Recorded(Number constant) : constant_(static_cast<double>(constant)) {}
  Recorded(Recording& recording, int node) : recording_(&recording), node_(node) {}

  bool is_constant() const { return recording_ == nullptr; }
  /// The node in the recording's graph, made for a constant if it is one.
  int node_in(Recording& recording) const { return recording_ ? node_ : constant_in(recording, constant_); }

  [[gnu::noinline]] friend Recorded operator-(const Recorded& x) {
    return x.recording_ ? -1.0 * x : Recorded(-x.constant_);
  }
  friend Recorded operator+(const Recorded& x, const Recorded& y) { return binary(BinaryOperation::sum, x, y); }
  friend Recorded operator-(const Recorded& x, const Recorded& y) { return binary(BinaryOperation::difference, x, y); }
  friend Recorded operator*(const Recorded& x, const Recorded& y) { return binary(BinaryOperation::product, x, y); }
  friend Recorded operator/(const Recorded& x, const Recorded& y) { return binary(BinaryOperation::quotient, x, y); }

  friend bool operator==(const Recorded& x, const Recorded& y) {
    if (!x.recording_ && !y.recording_) return x.constant_ == y.constant_;
    Recording& recording = x.recording_ ? *x.recording_ : *y.recording_;
    const Recorded d = x - y;
    const bool is_known = !d.recording_ && d.constant_ == 0.0;
    recording.answers.push_back(is_known ? 1.0 : 0.0);
    if (d.recording_) recording.assumptions.push_back({d.node_, 0.0});
    return is_known;
  }
  friend bool operator!=(const Recorded& x, const Recorded& y) { return !(x == y); }
  friend bool operator<(const Recorded& x, const Recorded& y) { return below(x, y, false, "the comparison ", "<"); }
  friend bool operator<=(const Recorded& x, const Recorded& y) { return below(x, y, true, "the comparison ", "<="); }
  friend bool operator>(const Recorded& x, const Recorded& y) { return below(y, x, false, "the comparison ", ">"); }
  friend bool operator>=(const Recorded& x, const Recorded& y) { return below(y, x, true, "the comparison ", ">="); }

  [[gnu::noinline]] static Recorded of(Function f, const Recorded& x) {
    if (!x.recording_) return Recorded(value_of(f, x.constant_));
    return wrapped(*x.recording_, function_in(*x.recording_, f, x.node_));
  }
  static Recorded of(Function f, const Recorded& x, const Recorded& y) {
    return binary(f == Function::hypot ? BinaryOperation::hypot : BinaryOperation::atan2, x, y);
  }

  [[gnu::noinline]] friend Recorded pow(const Recorded& x, double exponent) {
    if (!x.recording_) return Recorded(std::pow(x.constant_, exponent));
    if (exponent == 0.5 && x.recording_->branches != nullptr)
      if (const Node square = x.recording_->graph[x.node_]; square.kind == Kind::product && square.a == square.b)
        return is_below(Recorded(*x.recording_, square.a), 0.0, false, "the function ", "sqrt") ? -Recorded(*x.recording_, square.a)
                                                                                                : Recorded(*x.recording_, square.a);
    return wrapped(*x.recording_, power_in(*x.recording_, x.node_, exponent));
  }
  friend Recorded pow(const Recorded& x, const Recorded& y) {
    return y.recording_ ? exp(y * log(x)) : pow(x, y.constant_);
  }
  friend Recorded sqrt(const Recorded& x) { return pow(x, 0.5); }
  friend Recorded exp2(const Recorded& x) { return exp(x * std::log(2.0)); }
  friend Recorded log2(const Recorded& x) { return log(x) / std::log(2.0); }
  friend Recorded log10(const Recorded& x) { return log(x) / std::log(10.0); }
  // tanh′ without the |x| that keeps digits of plain numbers (ad/forward/transcendental.hpp).
  friend Recorded sech_squared(const Recorded& x) {
    const Recorded c = cosh(x);
    return 1.0 / (c * c);
  }

  friend const double& innermost_value(const Recorded& x) {
    if (x.recording_) refuse(*x.recording_, "the plain value", "");
    return x.constant_;
  }

  /// 1/x where it is known that x is not zero wherever this is asked for.
  friend Recorded reciprocal(const Recorded& x) {
    if (!x.recording_) return Recorded(1.0 / x.constant_);
    formula::Graph& graph = x.recording_->graph;
    return wrapped(*x.recording_, graph.quotient(graph.constant(1.0), x.node_));
  }
  /// Whether both are one node, or one constant.
  friend bool seen_to_be_one(const Recorded& x, const Recorded& y) {
    return x.recording_ == y.recording_ && (x.recording_ ? x.node_ == y.node_ : x.constant_ == y.constant_);
  }
  /// Notes a Recording::Turning: omega along the axes of a body, `count` numbers p with rates v, V of 3 count entries, and what is not zero where W is regular.
  friend void note_turning(const Recorded* omega, const Recorded* p, const Recorded* v, int count, const Recorded* inverse, const Recorded& regular) {
    Recording* recording = nullptr;
    for (int a = 0; a < 3; ++a) recording = omega[a].recording_ ? omega[a].recording_ : recording;
    if (recording == nullptr) return;
    Recording::Turning turning{{}, {}, {}, regular.node_in(*recording)};
    for (std::size_t a = 0; a < 3; ++a) turning.omega[a] = omega[a].node_in(*recording);
    for (int c = 0; c < count; ++c) turning.coordinates.emplace_back(p[c].node_in(*recording), v[c].node_in(*recording));
    for (int k = 0; k < 3 * count; ++k) turning.inverse.push_back(inverse[k].node_in(*recording));
    recording->turnings.push_back(std::move(turning));
  }

  friend Recorded abs(const Recorded& x) { return below(x, 0.0, false, "the function ", "abs") ? -x : x; }
  friend Recorded fabs(const Recorded& x) { return below(x, 0.0, false, "the function ", "fabs") ? -x : x; }
  friend Recorded floor(const Recorded& x) { return rounded_down(x, "floor"); }
  friend Recorded ceil(const Recorded& x) { return -rounded_down(-x, "ceil"); }
  // At a tie with a constant the other, as of duals (ad/forward/algebraic.hpp).
  friend Recorded max(const Recorded& x, const Recorded& y) { return below(x, y, !x.recording_, "the comparison ", "max") ? y : x; }
  friend Recorded min(const Recorded& x, const Recorded& y) { return below(y, x, !x.recording_, "the comparison ", "min") ? y : x; }
  friend Recorded copysign(const Recorded& x, const Recorded& y) {
    if (!x.recording_ && !y.recording_) return std::copysign(x.constant_, y.constant_);
    return below(x, 0.0, false, "the function ", "copysign") == below(y, 0.0, false, "the function ", "copysign") ? x : -x;
  }
  friend bool isfinite(const Recorded& x) { return std::isfinite(known(x, "isfinite")); }
  friend bool isnan(const Recorded& x) { return std::isnan(known(x, "isnan")); }
  friend bool isinf(const Recorded& x) { return std::isinf(known(x, "isinf")); }
  friend bool signbit(const Recorded& x) { return x.recording_ ? below(x, 0.0, false, "the function ", "signbit") : std::signbit(x.constant_); }

 private:
  static Recorded wrapped(Recording& recording, int node) {
    const Node& made = recording.graph[node];
    return made.kind == Kind::constant ? Recorded(made.c) : Recorded(recording, node);
  }

  static double of_constants(BinaryOperation operation, double a, double b) {
    switch (operation) {
      case BinaryOperation::sum: return a + b;
      case BinaryOperation::difference: return a - b;
      case BinaryOperation::product: return a * b;
      case BinaryOperation::quotient: return a / b;
      case BinaryOperation::hypot: return std::hypot(a, b);
      case BinaryOperation::atan2: break;
    }
    return std::atan2(a, b);
  }

  // Not inlined, for recording is done once: a loop in T would be unrolled with all of this in it.
  [[gnu::noinline]] static Recorded binary(BinaryOperation operation, const Recorded& x, const Recorded& y) {
    if (!x.recording_ && !y.recording_) return Recorded(of_constants(operation, x.constant_, y.constant_));
    Recording& recording = x.recording_ ? *x.recording_ : *y.recording_;
    const int a = x.node_in(recording), b = y.node_in(recording);
    return wrapped(recording, operation_in(recording, operation, a, b));
  }

  [[noreturn, gnu::cold, gnu::noinline]] static void refuse(const Recording& recording, const char* kind, const char* what) {
    throw NotAnalytic(detail::sentence({"power series, and derivatives by Taylor and Gauss, need energies and forces that are one formula everywhere, but ",
                                        recording.source, " uses ", kind, what, " of its arguments; Dop853 takes them as they are"}),
                      recording.source);
  }
  static std::string place(const Recording& recording, const char* kind, const char* what) {
    return detail::sentence({kind, what, " in ", recording.source});
  }
  // x < y, or x ≤ y, as functors ask.
  static bool below(const Recorded& x, const Recorded& y, bool or_equal, const char* kind, const char* what) {
    const bool answer = is_below(x, y, or_equal, kind, what);
    if (Recording* const recording = x.recording_ ? x.recording_ : y.recording_) recording->answers.push_back(answer ? 1.0 : 0.0);
    return answer;
  }
  [[gnu::noinline]] static bool is_below(const Recorded& x, const Recorded& y, bool or_equal, const char* kind, const char* what) {
    if (!x.recording_ && !y.recording_) return or_equal ? x.constant_ <= y.constant_ : x.constant_ < y.constant_;
    Recording& recording = x.recording_ ? *x.recording_ : *y.recording_;
    if (recording.branches == nullptr) refuse(recording, kind, what);
    const Recorded d = y - x;
    if (!d.recording_) return or_equal ? d.constant_ >= 0.0 : d.constant_ > 0.0;
    return is_above(recording.graph, *recording.branches, d.node_, 0.0, or_equal, place(recording, kind, what));
  }
  static double known(const Recorded& x, const char* function) {
    if (!x.recording_) return x.constant_;
    Recording& r = *x.recording_;
    if (r.branches == nullptr) refuse(r, "the function ", function);
    r.branches->read_values = true;
    evaluate_nodes(r.graph, r.branches->variables, r.branches->values, static_cast<std::size_t>(x.node_) + 1);
    return r.branches->values[static_cast<std::size_t>(x.node_)];
  }
  static Recorded rounded_down(const Recorded& x, const char* function) {
    if (!x.recording_) return std::floor(x.constant_);
    Recording& r = *x.recording_;
    if (r.branches == nullptr) refuse(r, "the function ", function);
    const double level = floor_of(r.graph, *r.branches, x.node_, place(r, "the function ", function));
    r.answers.push_back(level);
    return level;
  }

  Recording* recording_ = nullptr;  // of a constant: none
  int node_ = -1;
  double constant_ = 0.0;
};

}  // namespace formula
}  // namespace qdot

template <>
struct std::numeric_limits<qdot::formula::Recorded> : std::numeric_limits<double> {};

template <>
struct Eigen::NumTraits<qdot::formula::Recorded> : Eigen::NumTraits<double> {
  using Real = qdot::formula::Recorded;
  using NonInteger = Real;
  using Nested = Real;
  enum { IsInteger = 0, IsSigned = 1, IsComplex = 0, RequireInitialization = 1, ReadCost = 3, AddCost = 20, MulCost = 20 };
};

template <class Operation>
struct Eigen::ScalarBinaryOpTraits<qdot::formula::Recorded, double, Operation> {
  using ReturnType = qdot::formula::Recorded;
};
template <class Operation>
struct Eigen::ScalarBinaryOpTraits<double, qdot::formula::Recorded, Operation> {
  using ReturnType = qdot::formula::Recorded;
};
