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
// NotAnalytic: a formula with a branch is not one power series. One comparison is let through, because
// guards like `if (r == 0)` are common and right: x == c is answered "no", the node and c are noted as an
// assumption, and the assumption is checked at every point of expansion. A recorded number has no plain value either.

#include <Eigen/Core>
#include <cmath>
#include <concepts>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/ad/dual_math.hpp"
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
  Graph graph;
  std::vector<Assumption> assumptions;
  std::string source = "T or V";  ///< what is being run, for messages
};

// The operations of two numbers.
enum class Operation : unsigned char { sum, difference, product, quotient, hypot, atan2 };

// Nodes of a recording, made while functors are run: once, so that nothing is gained where it is inlined into them.
template <class Number = double>
int operation_in(Recording& recording, Operation operation, int a, int b) {
  Graph& g = recording.graph;
  switch (operation) {
    case Operation::sum: return g.sum(a, b);
    case Operation::difference: return g.difference(a, b);
    case Operation::product: return g.product(a, b);
    case Operation::quotient: restrict_to(Domain::nonzero, g, b); return g.quotient(a, b);
    case Operation::hypot: return g.function(Function::hypot, a, b);
    case Operation::atan2: break;
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
extern template int operation_in<double>(Recording&, Operation, int, int);
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

  /// The node in the recording's graph, made for a constant if it is one.
  int node_in(Recording& recording) const { return recording_ ? node_ : constant_in(recording, constant_); }

  [[gnu::noinline]] friend Recorded operator-(const Recorded& x) {
    return x.recording_ ? -1.0 * x : Recorded(-x.constant_);
  }
  friend Recorded operator+(const Recorded& x, const Recorded& y) { return binary(Operation::sum, x, y); }
  friend Recorded operator-(const Recorded& x, const Recorded& y) { return binary(Operation::difference, x, y); }
  friend Recorded operator*(const Recorded& x, const Recorded& y) { return binary(Operation::product, x, y); }
  friend Recorded operator/(const Recorded& x, const Recorded& y) { return binary(Operation::quotient, x, y); }

  friend bool operator==(const Recorded& x, const Recorded& y) {
    if (!x.recording_ && !y.recording_) return x.constant_ == y.constant_;
    const Recorded d = x - y;
    if (!d.recording_) return d.constant_ == 0.0;
    d.recording_->assumptions.push_back({d.node_, 0.0});
    return false;
  }
  friend bool operator!=(const Recorded& x, const Recorded& y) { return !(x == y); }
  friend bool operator<(const Recorded& x, const Recorded& y) { return compared(x, y, "<") < 0; }
  friend bool operator<=(const Recorded& x, const Recorded& y) { return compared(x, y, "<=") <= 0; }
  friend bool operator>(const Recorded& x, const Recorded& y) { return compared(x, y, ">") > 0; }
  friend bool operator>=(const Recorded& x, const Recorded& y) { return compared(x, y, ">=") >= 0; }

  [[gnu::noinline]] static Recorded of(Function f, const Recorded& x) {
    if (!x.recording_) return Recorded(value_of(f, x.constant_));
    return wrapped(*x.recording_, function_in(*x.recording_, f, x.node_));
  }
  static Recorded of(Function f, const Recorded& x, const Recorded& y) { return binary(f == Function::hypot ? Operation::hypot : Operation::atan2, x, y); }

  [[gnu::noinline]] friend Recorded pow(const Recorded& x, double exponent) {
    if (!x.recording_) return Recorded(std::pow(x.constant_, exponent));
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

  friend Recorded abs(const Recorded& x) { return kinked(x, "abs", std::abs(x.constant_)); }
  friend Recorded fabs(const Recorded& x) { return kinked(x, "fabs", std::abs(x.constant_)); }
  friend Recorded floor(const Recorded& x) { return kinked(x, "floor", std::floor(x.constant_)); }
  friend Recorded ceil(const Recorded& x) { return kinked(x, "ceil", std::ceil(x.constant_)); }
  friend Recorded max(const Recorded& x, const Recorded& y) { return compared(x, y, "max") < 0 ? y : x; }
  friend Recorded min(const Recorded& x, const Recorded& y) { return compared(x, y, "min") > 0 ? y : x; }
  friend Recorded copysign(const Recorded& x, const Recorded& y) {
    return kinked(x.recording_ ? x : y, "copysign", std::copysign(x.constant_, y.constant_));
  }
  friend bool isfinite(const Recorded& x) { return asked(x, "isfinite", std::isfinite(x.constant_)); }
  friend bool isnan(const Recorded& x) { return asked(x, "isnan", std::isnan(x.constant_)); }
  friend bool isinf(const Recorded& x) { return asked(x, "isinf", std::isinf(x.constant_)); }
  friend bool signbit(const Recorded& x) { return asked(x, "signbit", std::signbit(x.constant_)); }

 private:
  static Recorded wrapped(Recording& recording, int node) {
    const Node& made = recording.graph[node];
    return made.kind == Kind::constant ? Recorded(made.c) : Recorded(recording, node);
  }

  static double of_constants(Operation operation, double a, double b) {
    switch (operation) {
      case Operation::sum: return a + b;
      case Operation::difference: return a - b;
      case Operation::product: return a * b;
      case Operation::quotient: return a / b;
      case Operation::hypot: return std::hypot(a, b);
      case Operation::atan2: break;
    }
    return std::atan2(a, b);
  }

  // Not inlined, for recording is done once: a loop in T would be unrolled with all of this in it.
  [[gnu::noinline]] static Recorded binary(Operation operation, const Recorded& x, const Recorded& y) {
    if (!x.recording_ && !y.recording_) return Recorded(of_constants(operation, x.constant_, y.constant_));
    Recording& recording = x.recording_ ? *x.recording_ : *y.recording_;
    const int a = x.node_in(recording), b = y.node_in(recording);
    return wrapped(recording, operation_in(recording, operation, a, b));
  }

  [[noreturn, gnu::cold, gnu::noinline]] static void refuse(const Recording& recording, const char* kind, const char* what) {
    throw NotAnalytic(detail::sentence({"a Taylor series needs energies and forces that are one formula everywhere, but ",
                                        recording.source, " uses ", kind, what,
                                        " of its arguments; use Dop853, which takes them as they are"}),
                      recording.source);
  }
  static int compared(const Recorded& x, const Recorded& y, const char* comparison) {
    if (x.recording_ || y.recording_) refuse(x.recording_ ? *x.recording_ : *y.recording_, "the comparison ", comparison);
    return x.constant_ < y.constant_ ? -1 : x.constant_ > y.constant_ ? 1 : 0;
  }
  static bool asked(const Recorded& x, const char* function, bool of_constant) {
    if (x.recording_) refuse(*x.recording_, "the function ", function);
    return of_constant;
  }
  static Recorded kinked(const Recorded& x, const char* function, double of_constant) {
    if (x.recording_) refuse(*x.recording_, "the function ", function);
    return of_constant;
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
