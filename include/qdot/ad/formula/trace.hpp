#pragma once
// SPDX-License-Identifier: MIT
//
// A scalar that runs while the program is compiled, and lists what is done to it.
//
// A loop in T or V that the compiler keeps as a loop hides from it which derivatives are zero (ad/lagrange/euler_lagrange.hpp). But T and V that
// are constexpr can be run by the compiler itself. On the scalar Traced such a run gives the list of operations,
//
//     for (k = 0; k < 2; ++k) sum += m * qdot[k] * qdot[k];      →      c₀ = m,  c₁ = m
//                                                                        s₀ = c₀ q̇₀,  s₁ = s₀ q̇₀,  s₂ = c₁ q̇₁,  s₃ = s₂ q̇₁,  s₄ = s₁ + s₃
//
// a constant of the program, and the list can be gone through without a loop (mechanics/written_out.hpp). The numbers c in it are
// parameters and literals. Their values belong to one object, so the same run is made once more for each object when it is
// made, and gives its own c. That run also tells whether the list is the object's at all: a functor may branch on its parameters.

#include <bit>
#include <cmath>
#include <cstddef>
#include <type_traits>

#include "qdot/ad/formula/analytic_function.hpp"
#include "qdot/ad/formula/formula_number.hpp"
#include "qdot/error.hpp"

namespace qdot::trace {

using formula::Function;

// Behind the last one, the functions that have power series (ad/formula/analytic_function.hpp).
enum class Operation : unsigned char {
  add, subtract, multiply, divide, pow, max, min, copysign,  // of two numbers
  negate, sqrt, exp2, log2, log10, abs, floor, ceil
};
inline constexpr int operations = static_cast<int>(Operation::ceil);
constexpr Operation operation_of(Function f) { return static_cast<Operation>(operations + static_cast<int>(f)); }
// The function that an operation is; none if it is something else.
constexpr Function function_of(Operation o) {
  return static_cast<int>(o) > operations ? static_cast<Function>(static_cast<int>(o) - operations) : Function::none;
}
constexpr bool has_two_operands(Operation o) {
  return o <= Operation::copysign || o == operation_of(Function::atan2) || o == operation_of(Function::hypot);
}

// Operands: inputs and then earlier steps, counted from 0; −1 − k is constant k.
struct Step {
  Operation operation;
  int a, b;
  friend constexpr bool operator==(const Step&, const Step&) = default;
};

// Largest number of operations in one energy, and of constants.
inline constexpr int longest = 2000;

struct Recording {
  int inputs = 0;
  int steps = 0;
  int constants = 0;
  int result = 0;
  bool branches = false;  // compared a traced number with another
  bool too_long = false;
  Step step[longest];
  double constant[longest];
  bool exact[longest];  // false: the compiler does not know this constant's value

  constexpr int new_constant(double value, bool is_exact) {
    if (constants == longest) {
      too_long = true;
      return -1;
    }
    constant[constants] = value;
    exact[constants] = is_exact;
    return -++constants;
  }
  constexpr int new_step(Step s) {
    if (steps == longest) {
      too_long = true;
      return 0;
    }
    step[steps] = s;
    return inputs + steps++;
  }

  // The same steps in an order that depends on the formula alone: in f(x) + g(x) the compiler that runs code and the code that it
  // writes may begin at different ends. What the result does not need is gone.
  [[gnu::noinline]] constexpr void put_in_order(Recording& to) const {
    to.inputs = inputs;
    to.branches = branches;
    to.too_long = too_long;
    to.result = result;
    if (too_long || result < inputs) {
      if (result < 0) to.result = to.new_constant(constant[-1 - result], exact[-1 - result]);
      return;
    }
    int now[longest], waiting[longest], depth = 0;
    for (int i = 0; i < steps; ++i) now[i] = -1;
    waiting[depth++] = result - inputs;
    const auto is_ready = [&](int operand) { return operand < inputs || now[operand - inputs] >= 0; };
    const auto renamed = [&](int operand) {
      if (operand < 0) return to.new_constant(constant[-1 - operand], exact[-1 - operand]);
      return operand < inputs ? operand : now[operand - inputs];
    };
    while (depth > 0) {
      const int i = waiting[depth - 1];
      const Step s = step[i];
      if (!is_ready(s.a)) {
        waiting[depth++] = s.a - inputs;
      } else if (!is_ready(s.b)) {
        waiting[depth++] = s.b - inputs;
      } else {
        const int a = renamed(s.a), b = renamed(s.b);
        now[i] = to.new_step({s.operation, a, b});
        --depth;
      }
    }
    to.result = now[result - inputs];
  }
};

/// A number of a formula whose operations are being listed; a plain number as long as it has met none of the inputs.
///
/// For it qdot::vector() makes vectors that the compiler can run.
class Traced : public formula::FormulaNumber<Traced> {
 public:
  static constexpr bool is_formula = true;

  constexpr Traced() = default;
  template <class Number>
    requires std::is_arithmetic_v<Number>
  constexpr Traced(Number constant) : constant_(static_cast<double>(constant)) {}
  constexpr Traced(Recording& recording, int node) : recording_(&recording), node_(node) {}

  constexpr int operand_in(Recording& recording) const {
    if (recording_ != nullptr) return node_;
    return recording.new_constant(constant_, exact_);
  }

  friend constexpr Traced operator-(const Traced& x) { return of_one(Operation::negate, x); }
  friend constexpr Traced operator+(const Traced& x, const Traced& y) { return of_two(Operation::add, x, y); }
  friend constexpr Traced operator-(const Traced& x, const Traced& y) { return of_two(Operation::subtract, x, y); }
  friend constexpr Traced operator*(const Traced& x, const Traced& y) { return of_two(Operation::multiply, x, y); }
  friend constexpr Traced operator/(const Traced& x, const Traced& y) { return of_two(Operation::divide, x, y); }

  static constexpr Traced of(Function f, const Traced& x) { return of_one(operation_of(f), x); }
  static constexpr Traced of(Function f, const Traced& x, const Traced& y) { return of_two(operation_of(f), x, y); }

  // A branch on a coordinate: the list holds for one side of it only.
  friend constexpr bool operator==(const Traced& x, const Traced& y) { return compared(x, y, x.constant_ == y.constant_); }
  friend constexpr bool operator!=(const Traced& x, const Traced& y) { return compared(x, y, x.constant_ != y.constant_); }
  friend constexpr bool operator<(const Traced& x, const Traced& y) { return compared(x, y, x.constant_ < y.constant_); }
  friend constexpr bool operator<=(const Traced& x, const Traced& y) { return compared(x, y, x.constant_ <= y.constant_); }
  friend constexpr bool operator>(const Traced& x, const Traced& y) { return compared(x, y, x.constant_ > y.constant_); }
  friend constexpr bool operator>=(const Traced& x, const Traced& y) { return compared(x, y, x.constant_ >= y.constant_); }

  // A power that is a small whole number by its type is products, as one writes them by hand.
  template <class Number>
    requires std::is_integral_v<Number>
  friend constexpr Traced pow(const Traced& x, Number exponent) {
    if (exponent == 1) return x;
    if (exponent == 2) return x * x;
    if (exponent == 3) return x * x * x;
    if (exponent == 4) return (x * x) * (x * x);
    return of_two(Operation::pow, x, exponent);
  }
  friend constexpr Traced pow(const Traced& x, const Traced& y) { return of_two(Operation::pow, x, y); }
  // A constant comes last, for at a tie the first one counts.
  friend constexpr Traced max(const Traced& x, const Traced& y) { return x.recording_ ? of_two(Operation::max, x, y) : of_two(Operation::max, y, x); }
  friend constexpr Traced min(const Traced& x, const Traced& y) { return x.recording_ ? of_two(Operation::min, x, y) : of_two(Operation::min, y, x); }
  friend constexpr Traced copysign(const Traced& x, const Traced& y) { return of_two(Operation::copysign, x, y); }

  friend constexpr Traced sqrt(const Traced& x) { return of_one(Operation::sqrt, x); }
  friend constexpr Traced exp2(const Traced& x) { return of_one(Operation::exp2, x); }
  friend constexpr Traced log2(const Traced& x) { return of_one(Operation::log2, x); }
  friend constexpr Traced log10(const Traced& x) { return of_one(Operation::log10, x); }
  friend constexpr Traced abs(const Traced& x) { return of_one(Operation::abs, x); }
  friend constexpr Traced fabs(const Traced& x) { return abs(x); }
  friend constexpr Traced floor(const Traced& x) { return of_one(Operation::floor, x); }
  friend constexpr Traced ceil(const Traced& x) { return of_one(Operation::ceil, x); }
  friend constexpr bool isnan(const Traced& x) { return compared(x, x, x.constant_ != x.constant_); }
  friend constexpr bool isfinite(const Traced& x) { return compared(x, x, x.constant_ - x.constant_ == 0.0); }
  friend constexpr bool isinf(const Traced& x) { return !isnan(x) && compared(x, x, x.constant_ - x.constant_ != 0.0); }
  friend constexpr bool signbit(const Traced& x) { return compared(x, x, (std::bit_cast<unsigned long long>(x.constant_) >> 63) != 0); }

 private:
  // Not inlined: what is not run by the compiler runs once for each object.
  [[gnu::noinline]] static constexpr Traced of_two(Operation o, const Traced& x, const Traced& y) {
    if (x.recording_ == nullptr && y.recording_ == nullptr) return of_constants(o, x, y);
    Recording* r = x.recording_;
    if (r == nullptr) r = y.recording_;
    const int a = x.operand_in(*r), b = y.operand_in(*r);
    return Traced(*r, r->new_step({o, a, b}));
  }
  [[gnu::noinline]] static constexpr Traced of_one(Operation o, const Traced& x) {
    if (x.recording_ == nullptr) return of_constants(o, x, x);
    return Traced(*x.recording_, x.recording_->new_step({o, x.node_, x.node_}));
  }
  // Functions of <cmath> do not run while compiling: the constant then has a value that the compiler does not know.
  [[gnu::noinline]] static constexpr Traced of_constants(Operation o, const Traced& x, const Traced& y) {
    Traced z;
    z.exact_ = x.exact_ && y.exact_;
    const double a = x.constant_, b = y.constant_;
    if (o == Operation::add) z.constant_ = a + b;
    else if (o == Operation::subtract) z.constant_ = a - b;
    else if (o == Operation::multiply) z.constant_ = a * b;
    else if (o == Operation::negate) z.constant_ = -a;
    else if (o == Operation::divide && b != 0.0) z.constant_ = a / b;
    else if (!std::is_constant_evaluated()) z.constant_ = value_of(o, a, b);
    else z.exact_ = false;
    return z;
  }
  static double value_of(Operation o, double a, double b);
  static constexpr bool compared(const Traced& x, const Traced& y, bool of_constants) {
    if (x.recording_ != nullptr) x.recording_->branches = true;
    if (y.recording_ != nullptr) y.recording_->branches = true;
    return x.recording_ == nullptr && y.recording_ == nullptr && of_constants;
  }

  Recording* recording_ = nullptr;  // of a constant: none
  int node_ = -1;
  double constant_ = 0.0;
  bool exact_ = true;
};

// o(a, b), or o(a), on numbers of any kind that has the function.
template <Operation o, class A, class B>
[[gnu::always_inline]] inline auto applied(const A& a, const B& b) {
  using std::abs, std::ceil, std::copysign, std::exp2, std::floor, std::log10, std::log2, std::pow, std::sqrt;
  if constexpr (o == Operation::add) return a + b;
  else if constexpr (o == Operation::subtract) return a - b;
  else if constexpr (o == Operation::multiply) return a * b;
  else if constexpr (o == Operation::divide) return a / b;
  else if constexpr (o == Operation::pow) return pow(a, b);
  else if constexpr (o == Operation::copysign) return copysign(a, b);
  else if constexpr (o == Operation::negate) return -a;
  else if constexpr (o == Operation::sqrt) return sqrt(a);
  else if constexpr (o == Operation::exp2) return exp2(a);
  else if constexpr (o == Operation::log2) return log2(a);
  else if constexpr (o == Operation::log10) return log10(a);
  else if constexpr (o == Operation::abs) return abs(a);
  else if constexpr (o == Operation::floor) return floor(a);
  else if constexpr (o == Operation::ceil) return ceil(a);
  else return formula::applied<function_of(o)>(a, b);
}

template <int first = 0>
double value_of_constants(Operation o, double a, double b) {
  constexpr Operation here = static_cast<Operation>(first);
  if constexpr (here == Operation::max || here == Operation::min) {
    if (o == here) return ((a < b) == (here == Operation::max)) ? b : a;
  } else {
    if (o == here) return applied<here>(a, b);
  }
  if constexpr (here != operation_of(Function::erfc)) return value_of_constants<first + 1>(o, a, b);
  return 0.0;
}
[[gnu::cold]] inline double Traced::value_of(Operation o, double a, double b) { return value_of_constants(o, a, b); }

/// A vector for functors that are run while compiling: what they may ask of q, of q̇ and of positions.
template <class S, int n>
struct FormulaVector {
  using Scalar = S;
  static constexpr int RowsAtCompileTime = n, ColsAtCompileTime = 1, SizeAtCompileTime = n;

  S entries[n];

  constexpr const S& operator[](std::ptrdiff_t i) const { return entries[i]; }
  constexpr const S& operator()(std::ptrdiff_t i) const { return entries[i]; }
  constexpr S& operator[](std::ptrdiff_t i) { return entries[i]; }
  constexpr std::ptrdiff_t size() const { return n; }
  constexpr std::ptrdiff_t rows() const { return n; }
  constexpr const S& x() const { return entries[0]; }
  constexpr const S& y() const requires(n > 1) { return entries[1]; }
  constexpr const S& z() const requires(n > 2) { return entries[2]; }
  constexpr const S& w() const requires(n > 3) { return entries[3]; }
  constexpr S sum() const {
    S s = entries[0];
    for (int i = 1; i < n; ++i) s += entries[i];
    return s;
  }
  constexpr S dot(const FormulaVector& other) const {
    S s = entries[0] * other.entries[0];
    for (int i = 1; i < n; ++i) s += entries[i] * other.entries[i];
    return s;
  }
  constexpr S squaredNorm() const { return dot(*this); }
  constexpr S norm() const { return sqrt(squaredNorm()); }

  constexpr FormulaVector& operator+=(const FormulaVector& other) {
    for (int i = 0; i < n; ++i) entries[i] += other.entries[i];
    return *this;
  }
  constexpr FormulaVector& operator-=(const FormulaVector& other) {
    for (int i = 0; i < n; ++i) entries[i] -= other.entries[i];
    return *this;
  }
  friend constexpr FormulaVector operator+(FormulaVector a, const FormulaVector& b) { return a += b; }
  friend constexpr FormulaVector operator-(FormulaVector a, const FormulaVector& b) { return a -= b; }
  friend constexpr FormulaVector operator*(const S& factor, FormulaVector a) {
    for (S& entry : a.entries) entry = factor * entry;
    return a;
  }
  friend constexpr FormulaVector operator*(const FormulaVector& a, const S& factor) { return factor * a; }
};

template <int n>
using TracedVector = FormulaVector<Traced, n>;

}  // namespace qdot::trace
