#pragma once
// SPDX-License-Identifier: MIT
//
// Random formulas of q, q̇ and t: the functors that nobody would write.
//
// A formula is a list of operations on earlier results, with letters for its constants. It is grown by dice that work while compiling too,
// so one grammar makes both
//
//     functors that interpret a list at run time     thousands of functions with one type, loops to the compiler;
//     types that hold a list of their own            `nested` as one expression, `unrolled`, or `looped`: what the optimizer and packs see through.
//
// Mostly a function's argument is brought into its domain, as whoever means it would do (log(1 + x²)); one in a dozen takes what comes.
// Constants are drawn anew for each case, and like to be 0, 1, −1, equal, tiny or huge.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "qdot/ad/unroll.hpp"

namespace fuzz {

/// splitmix64: the same numbers everywhere, while compiling as well.
struct Dice {
  std::uint64_t state;
  constexpr std::uint64_t next() {
    std::uint64_t z = (state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  constexpr int below(int n) { return static_cast<int>(next() % static_cast<std::uint64_t>(n)); }
  constexpr bool one_in(int n) { return below(n) == 0; }
  constexpr double between(double low, double high) { return low + (high - low) * static_cast<double>(next() >> 11) * 0x1p-53; }
};

enum class Op : unsigned char {
  input,
  constant,
  add,
  subtract,
  multiply,
  divide,
  power,
  atan2,
  hypot,
  max,
  min,
  negate,
  square,
  cube,
  inverse,
  sqrt,
  cbrt,
  exp,
  exp2,
  expm1,
  log,
  log2,
  log10,
  log1p,
  sin,
  cos,
  tan,
  asin,
  acos,
  atan,
  sinh,
  cosh,
  tanh,
  abs,
  asinh,
  acosh,
  atanh,
  erf,
  erfc
};
constexpr bool takes_two(Op o) { return o >= Op::add && o <= Op::min; }

/// a, b: earlier nodes; the number of the input or of the constant.
struct Node {
  Op op = Op::constant;
  int a = 0, b = 0;
};

/// What a constant may be.
enum class Kind : unsigned char { any,
                                  positive,
                                  fraction,
                                  above_one };

inline constexpr int most_nodes = 128, most_constants = 64;

struct Formula {
  std::array<Node, most_nodes> node{};
  std::array<Kind, most_constants> kind{};
  int count = 0, constants = 0;
};
using Constants = std::array<double, most_constants>;

/// o(x, y) or o(x) on numbers of any kind.
template <Op o, class X, class Y>
constexpr auto applied(const X& x, const Y& y) {
  using std::abs, std::acos, std::acosh, std::asin, std::asinh, std::atan, std::atan2, std::atanh, std::cbrt, std::cos, std::cosh, std::erf, std::erfc,
      std::exp, std::exp2, std::expm1, std::fmax, std::fmin, std::hypot, std::log, std::log10, std::log1p, std::log2, std::pow, std::sin, std::sinh,
      std::sqrt, std::tan, std::tanh;
  if constexpr (o == Op::add) return x + y;
  else if constexpr (o == Op::subtract) return x - y;
  else if constexpr (o == Op::multiply) return x * y;
  else if constexpr (o == Op::divide) return x / y;
  else if constexpr (o == Op::power) return pow(x, y);
  else if constexpr (o == Op::atan2) return atan2(x, y);
  else if constexpr (o == Op::hypot) return hypot(x, y);
  else if constexpr (o == Op::max) return fmax(x, y);
  else if constexpr (o == Op::min) return fmin(x, y);
  else if constexpr (o == Op::negate) return -x;
  else if constexpr (o == Op::square) return pow(x, 2);
  else if constexpr (o == Op::cube) return pow(x, 3);
  else if constexpr (o == Op::inverse) return 1.0 / x;
  else if constexpr (o == Op::sqrt) return sqrt(x);
  else if constexpr (o == Op::cbrt) return cbrt(x);
  else if constexpr (o == Op::exp) return exp(x);
  else if constexpr (o == Op::exp2) return exp2(x);
  else if constexpr (o == Op::expm1) return expm1(x);
  else if constexpr (o == Op::log) return log(x);
  else if constexpr (o == Op::log2) return log2(x);
  else if constexpr (o == Op::log10) return log10(x);
  else if constexpr (o == Op::log1p) return log1p(x);
  else if constexpr (o == Op::sin) return sin(x);
  else if constexpr (o == Op::cos) return cos(x);
  else if constexpr (o == Op::tan) return tan(x);
  else if constexpr (o == Op::asin) return asin(x);
  else if constexpr (o == Op::acos) return acos(x);
  else if constexpr (o == Op::atan) return atan(x);
  else if constexpr (o == Op::sinh) return sinh(x);
  else if constexpr (o == Op::cosh) return cosh(x);
  else if constexpr (o == Op::tanh) return tanh(x);
  else if constexpr (o == Op::abs) return abs(x);
  else if constexpr (o == Op::asinh) return asinh(x);
  else if constexpr (o == Op::acosh) return acosh(x);
  else if constexpr (o == Op::atanh) return atanh(x);
  else if constexpr (o == Op::erf) return erf(x);
  else if constexpr (o == Op::erfc) return erfc(x);
  else static_assert(o != o, "no operation of two");
}

// Not inlined, or each evaluator has all functions in it and takes a minute to compile.
template <class S>
[[gnu::noinline]] constexpr S applied_at_run_time(Op o, const S& x, const S& y) {
  switch (o) {
#define QDOT_FUZZ_CASE(name) \
  case Op::name: return S(applied<Op::name>(x, y));
    QDOT_FUZZ_CASE(add)
    QDOT_FUZZ_CASE(subtract) QDOT_FUZZ_CASE(multiply) QDOT_FUZZ_CASE(divide) QDOT_FUZZ_CASE(power) QDOT_FUZZ_CASE(atan2)
        QDOT_FUZZ_CASE(hypot) QDOT_FUZZ_CASE(max) QDOT_FUZZ_CASE(min) QDOT_FUZZ_CASE(negate) QDOT_FUZZ_CASE(square) QDOT_FUZZ_CASE(cube)
            QDOT_FUZZ_CASE(inverse) QDOT_FUZZ_CASE(sqrt) QDOT_FUZZ_CASE(cbrt) QDOT_FUZZ_CASE(exp) QDOT_FUZZ_CASE(exp2) QDOT_FUZZ_CASE(expm1)
                QDOT_FUZZ_CASE(log) QDOT_FUZZ_CASE(log2) QDOT_FUZZ_CASE(log10) QDOT_FUZZ_CASE(log1p) QDOT_FUZZ_CASE(sin) QDOT_FUZZ_CASE(cos)
                    QDOT_FUZZ_CASE(tan) QDOT_FUZZ_CASE(asin) QDOT_FUZZ_CASE(acos) QDOT_FUZZ_CASE(atan) QDOT_FUZZ_CASE(sinh) QDOT_FUZZ_CASE(cosh)
                        QDOT_FUZZ_CASE(tanh) QDOT_FUZZ_CASE(abs) QDOT_FUZZ_CASE(asinh) QDOT_FUZZ_CASE(acosh) QDOT_FUZZ_CASE(atanh) QDOT_FUZZ_CASE(erf)
                            QDOT_FUZZ_CASE(erfc)
#undef QDOT_FUZZ_CASE
                                default : return x;
  }
}

/// The value of a formula, in a loop; `input(i)` is the input with number i.
template <class S, class Input>
constexpr S looped(const Formula& f, const double* constants, const Input& input) {
  std::vector<S> x;
  x.reserve(static_cast<std::size_t>(f.count));
  for (int i = 0; i < f.count; ++i) {
    const Node node = f.node[static_cast<std::size_t>(i)];
    if (node.op == Op::input) x.push_back(S(input(node.a)));
    else if (node.op == Op::constant) x.push_back(S(constants[node.a]));
    else x.push_back(applied_at_run_time<S>(node.op, x[static_cast<std::size_t>(node.a)], x[static_cast<std::size_t>(node.b)]));
  }
  return x.back();
}

/// The same as one expression, for a formula that the compiler knows.
template <const Formula& f, int i, class Input>
[[gnu::always_inline]] constexpr auto nested(const double* constants, const Input& input) {
  constexpr Node node = f.node[i];
  if constexpr (node.op == Op::input) {
    return input(node.a);
  } else if constexpr (node.op == Op::constant) {
    return constants[node.a];
  } else if constexpr (takes_two(node.op)) {
    return applied<node.op>(nested<f, node.a>(constants, input), nested<f, node.b>(constants, input));
  } else {
    const auto x = nested<f, node.a>(constants, input);
    return applied<node.op>(x, x);
  }
}

/// The same, one operation after the other.
template <const Formula& f, class S, class Input>
[[gnu::always_inline]] constexpr S unrolled(const double* constants, const Input& input) {
  S x[f.count];
  qdot::unroll<f.count>([&](auto i) __attribute__((always_inline)) {
    constexpr Node node = f.node[i];
    if constexpr (node.op == Op::input) x[i] = input(node.a);
    else if constexpr (node.op == Op::constant) x[i] = S(constants[node.a]);
    else if constexpr (takes_two(node.op)) x[i] = applied<node.op>(x[node.a], x[node.b]);
    else x[i] = applied<node.op>(x[node.a], x[node.a]);
  });
  return x[f.count - 1];
}

/// A formula as one may read it, with the numbers that its constants have.
inline std::string in_words(const Formula& f, const double* constants, int n, int i = -1) {
  static constexpr const char* names[] = {
      "", "", " + ", " - ", " * ", " / ", "pow", "atan2", "hypot", "fmax", "fmin", "-", "square", "cube", "1/", "sqrt", "cbrt", "exp", "exp2", "expm1",
      "log", "log2", "log10", "log1p", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "abs", "asinh", "acosh", "atanh", "erf", "erfc"};
  const Node node = f.node[static_cast<std::size_t>(i < 0 ? f.count - 1 : i)];
  const std::string name = names[static_cast<int>(node.op)];
  const auto of = [&](int k) { return in_words(f, constants, n, k); };
  if (node.op == Op::input) return node.a == 2 * n ? "t" : (node.a < n ? "q" : "v") + std::to_string(node.a % n);
  if (node.op == Op::constant) {
    char buffer[40];
    std::snprintf(buffer, sizeof buffer, "%.17g", constants[node.a]);
    return buffer;
  }
  if (node.op <= Op::divide) return "(" + of(node.a) + name + of(node.b) + ")";
  return name + "(" + of(node.a) + (takes_two(node.op) ? ", " + of(node.b) : "") + ")";
}

// ── growing them ───────────────────────────────────────────────────────────────────────────────

/// Which inputs a formula of n coordinates may have: q is 0 … n − 1, q̇ the next n, t the last.
struct Inputs {
  int n = 1;
  bool q = true, qdot = false, t = false;
  constexpr int one(Dice& dice) const {
    const int count = (q ? n : 0) + (qdot ? n : 0) + (t ? 1 : 0);
    int i = dice.below(count);
    if (!q) i += n;
    if (i >= (qdot ? 2 * n : n) && i < 2 * n) i = 2 * n;
    return i;
  }
};

/// Everything, one function in a dozen with an argument that is not brought into its domain; only what is smooth everywhere, for motions;
/// without |x|, max, atan2, hypot and powers with exponents that vary.
enum class Grammar { everything,
                     smooth,
                     without_sides };

struct Grower {
  Dice dice;
  Grammar grammar = Grammar::everything;
  Formula f{};

  constexpr int add(Op op, int a, int b = 0) {
    f.node[static_cast<std::size_t>(f.count)] = {op, a, b};
    return f.count++;
  }
  constexpr int input(int i) { return add(Op::input, i); }
  constexpr int constant(Kind kind = Kind::any) {
    f.kind[static_cast<std::size_t>(f.constants)] = kind;
    return add(Op::constant, f.constants++);
  }
  constexpr int times_constant(int x, Kind kind = Kind::any) {
    const int c = constant(kind);
    return add(Op::multiply, c, x);
  }
  constexpr bool is_full() const { return f.count > most_nodes - 30 || f.constants > most_constants - 8; }

  /// Something between −1.6 and 1.6.
  constexpr int bounded(int depth, const Inputs& inputs) {
    constexpr Op each[] = {Op::sin, Op::cos, Op::tanh, Op::atan};
    const int x = grow(depth, inputs);
    return add(each[dice.below(4)], x);
  }
  /// x² + c, c > 0.
  constexpr int positive(int depth, const Inputs& inputs, Kind kind = Kind::positive) {
    const int x = grow(depth, inputs);
    const int square = add(Op::square, x);
    return add(Op::add, square, constant(kind));
  }

  constexpr int grow(int depth, const Inputs& inputs) {
    if (depth <= 0 || is_full()) {
      const int x = input(inputs.one(dice));
      const int form = dice.below(4);
      if (form == 0) return times_constant(x);
      if (form == 1) return add(Op::add, x, constant());
      return x;
    }
    const int next = depth - 1;
    switch (dice.below(10)) {
      case 0:
      case 1:
      case 2: {
        const int x = grow(next, inputs), y = grow(dice.below(depth), inputs);
        constexpr Op each[] = {Op::add, Op::subtract, Op::multiply, Op::multiply};
        return add(each[dice.below(4)], x, y);
      }
      case 3: {
        const int x = grow(next, inputs);
        return add(Op::divide, x, positive(dice.below(depth), inputs));
      }
      case 4: {
        constexpr Op each[] = {Op::max, Op::min, Op::atan2, Op::atan2, Op::hypot, Op::hypot};
        const Op op = each[dice.below(6)];
        const int x = grow(next, inputs);
        if (grammar == Grammar::without_sides || (op != Op::atan2 && grammar == Grammar::smooth)) return add(Op::divide, x, positive(0, inputs));
        return add(op, x, op == Op::atan2 ? positive(0, inputs) : grow(dice.below(depth), inputs));
      }
      case 5: {
        const int x = positive(next, inputs);
        if (dice.one_in(2) || grammar == Grammar::without_sides) return add(Op::power, x, constant());
        return add(Op::power, x, bounded(0, inputs));
      }
      case 6: return times_constant(grow(next, inputs));
      default: return function(next, inputs);
    }
  }

  /// A function of one argument.
  constexpr int function(int depth, const Inputs& inputs) {
    const Op op = static_cast<Op>(static_cast<int>(Op::negate) + dice.below(static_cast<int>(Op::erfc) - static_cast<int>(Op::negate) + 1));
    if (grammar != Grammar::everything && op == Op::abs) return add(Op::square, grow(depth, inputs));
    if (grammar == Grammar::smooth && op == Op::cbrt) return add(op, positive(depth, inputs));
    if (grammar != Grammar::smooth && dice.one_in(12)) return add(op, grow(depth, inputs));
    switch (op) {
      case Op::sqrt:
      case Op::log:
      case Op::log2:
      case Op::log10:
      case Op::inverse: return add(op, positive(depth, inputs));
      case Op::log1p: return add(op, add(Op::square, grow(depth, inputs)));
      case Op::exp:
      case Op::exp2:
      case Op::expm1:
      case Op::sinh:
      case Op::cosh:
      case Op::tan: return add(op, bounded(depth, inputs));
      case Op::asin:
      case Op::acos:
      case Op::atanh: return add(op, times_constant(add(Op::sin, grow(depth, inputs)), Kind::fraction));
      case Op::acosh: return add(op, positive(depth, inputs, Kind::above_one));
      case Op::cube: return add(op, bounded(depth, inputs));
      default: return add(op, grow(depth, inputs));
    }
  }
};

/// A formula of some depth.
constexpr Formula random_formula(std::uint64_t seed, Inputs inputs, int depth, Grammar grammar = Grammar::everything) {
  Grower g{Dice{seed}, grammar};
  g.grow(depth, inputs);
  return g.f;
}

/// T = ½ Σ c q̇ᵢ² + ½ Σ c (Σ Jₖᵢ q̇ᵢ + dₖ)², J and d formulas of what `positions` allows; and, one in four, a small term of everything.
constexpr Formula random_kinetic_energy(std::uint64_t seed, Inputs positions, int depth, Grammar grammar = Grammar::everything) {
  Grower g{Dice{seed}, grammar};
  const int n = positions.n;
  const bool constant_inertia = !positions.q && !positions.t;
  int sum = -1;
  const auto plus = [&](int term) { sum = sum < 0 ? term : g.add(Op::add, sum, term); };
  for (int i = 0; i < n; ++i) plus(g.times_constant(g.add(Op::square, g.input(n + i)), Kind::positive));
  for (int k = 0; k < (n < 2 ? 1 : 2) && !g.is_full(); ++k) {
    int u = -1;
    for (int i = 0; i < n; ++i) {
      if (n > 2 && g.dice.one_in(3)) continue;
      const int v = g.input(n + i);
      const int term = constant_inertia ? g.times_constant(v) : g.add(Op::multiply, g.grow(depth, positions), v);
      u = u < 0 ? term : g.add(Op::add, u, term);
    }
    if (u < 0) continue;
    if (positions.t && g.dice.one_in(2)) u = g.add(Op::add, u, g.grow(1, positions));
    plus(g.times_constant(g.add(Op::square, u), Kind::positive));
  }
  if (grammar == Grammar::everything && g.dice.one_in(4)) {
    Inputs all = positions;
    all.qdot = true;
    plus(g.times_constant(g.grow(2, all), Kind::fraction));
  }
  return g.f;
}

/// V = ½ Σ c qᵢ² + something, which holds a motion together.
constexpr Formula random_potential(std::uint64_t seed, Inputs positions, int depth) {
  Grower g{Dice{seed}, Grammar::smooth};
  int sum = g.grow(depth, positions);
  for (int i = 0; i < positions.n; ++i) {
    const int square = g.add(Op::square, g.input(i));
    sum = g.add(Op::add, sum, g.times_constant(square, Kind::positive));
  }
  return g.f;
}

/// Linear in q̇: Σ eᵢ(q, t) q̇ᵢ + f(q, t).
constexpr Formula random_rolling(std::uint64_t seed, Inputs positions, int depth) {
  Grower g{Dice{seed}, Grammar::smooth};
  int sum = -1;
  for (int i = 0; i < positions.n; ++i) {
    const int e = g.grow(depth, positions);
    const int term = g.add(Op::multiply, e, g.input(positions.n + i));
    sum = sum < 0 ? term : g.add(Op::add, sum, term);
  }
  if (g.dice.one_in(2)) g.add(Op::add, sum, g.grow(1, positions));
  return g.f;
}

/// Constants for a formula; `tame`: zero, equal or of order one.
inline Constants random_constants(const Formula& f, Dice& dice, bool tame = false) {
  Constants c{};
  for (int i = 0; i < f.constants; ++i) {
    double& x = c[static_cast<std::size_t>(i)];
    const int own = dice.below(20), special = tame && own != 0 && own != 6 ? 8 : own;
    if (tame && f.kind[static_cast<std::size_t>(i)] == Kind::positive) {
      x = dice.between(0.3, 3.0);
      continue;
    }
    switch (f.kind[static_cast<std::size_t>(i)]) {
      case Kind::any:
        x = special == 0 ? 0.0 : special == 1 ? 1.0
                             : special == 2   ? -1.0
                             : special == 3   ? 2.0
                             : special == 4   ? 1e-9
                             : special == 5   ? -1e6
                                              : dice.between(-2.0, 2.0);
        if (special == 6 && i > 0) x = c[static_cast<std::size_t>(i - 1)];
        break;
      case Kind::positive:
        x = special == 0 ? 1.0 : special == 1 ? 1e-4
                             : special == 2   ? 1e4
                             : special == 3   ? 0.5
                                              : dice.between(0.2, 3.0);
        if (special == 4 && dice.one_in(3)) x = 0.0;
        break;
      case Kind::fraction: x = special == 0 ? 0.0 : special == 1 ? 0.5
                                                                 : dice.between(0.05, 0.95);
        break;
      case Kind::above_one: x = special == 0 ? 2.0 : dice.between(1.1, 3.0); break;
    }
  }
  return c;
}

}  // namespace fuzz
