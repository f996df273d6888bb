#pragma once
// SPDX-License-Identifier: MIT
//
// A formula carried out line by line: a graph (ad/formula/graph.hpp) as a table of lines,
//
//     x₇ = x₃ x₅,     x₈ = sin x₀, x₉ = cos x₀,     x₁₀ = 2 x₇ − x₈,   …
//
// A line costs one or two nanoseconds beside what it computes, so a product that is asked for in one sum only is part
// of the sum's line: x₁₁ = x₁ x₂ + x₃ x₄.
//
// Many bodies are many equal lines. x₁₀₀ = x₁ − x₀, x₁₀₁ = x₂ − x₁, x₁₀₂ = x₃ − x₂ … is one *run*: an operation, how
// many there are, and where each of its three places begins and how it steps on. A run is a loop over arrays, so a
// lattice of a million masses has as many lines as one mass has operations. Where places do not step on evenly, or
// factors differ, it has a list.
//
// Products are not fused with sums, whatever the compiler may do elsewhere (-mfma, -march=native, AArch64). So results
// are the same to the bit with all options, and by machine code (ad/native/line_evaluator.ipp).

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "qdot/ad/formula/analytic_function.hpp"
#include "qdot/ad/formula/circular_lines.hpp"
#include "qdot/ad/formula/graph.hpp"

namespace qdot::formula {

/// One line: x[to] = …
struct Line {
  enum class Operation : std::uint8_t {
    end, constant, scaled, combination, sum, difference, product, square, quotient, inverse, root, inverse_root, power, sine_and_cosine, function, run,
    product_sum, product_difference, less_product, product_combination,  // a b + d, a b − d, d − a b, ca a b + cb d
    products_sum, products_difference, products_combination              // a b + d e, a b − d e, ca a b + cb d e
  };
  Operation operation = Operation::end;
  Function function = Function::none;
  std::uint32_t to = 0, a = 0, b = 0;  ///< of sine_and_cosine: b is where the cosine goes; of run: a is its number
  double ca = 0.0, cb = 0.0, c = 0.0;
  std::uint32_t d = 0, e = 0;
};

/// After how many evaluations lines become machine code (ad/native/line_evaluator.ipp), of single numbers and of lanes; 0 for never.
struct MachineCodeBegins {
  long alone = 500, in_lanes = 64;
};

/// Most lines that become machine code. Longer code leaves the processor's cache, and the interpreter is as fast.
inline constexpr std::size_t longest_native_lines = 4000;

/// Whether a line has products in a sum, and so four places.
constexpr bool has_products(Line::Operation operation) { return operation >= Line::Operation::product_sum; }

/// Equal lines one behind the other: `first` is the first of them.
struct RunOfLines {
  Line first;
  std::uint32_t count = 0;
  std::int32_t step_a = 0, step_b = 0, step_d = 0, step_e = 0;
  std::int64_t places = -1;   ///< of a and b (and d and e) of each line among LineTable::places; −1 where they step on evenly
  std::int64_t factors = -1;  ///< of ca, cb, c of each line among LineTable::factors; −1 where they are those of the first
};

/// Lines with their runs; the last line of `lines` is an end.
struct LineTable {
  std::vector<Line> lines;
  std::vector<RunOfLines> runs;
  std::vector<std::uint32_t> places;
  std::vector<double> factors;
};

// x^c, by products and a root where c is a few halves: sooner than by std::pow.
[[gnu::noinline]] inline double raised(double x, double c) {
  const double halves = std::abs(2.0 * c);
  if (!(halves <= 9.0) || halves != std::floor(halves)) return std::pow(x, c);
  int left = static_cast<int>(halves);
  double y = left % 2 == 0 ? 1.0 : std::sqrt(x);
  for (; left > 1; left -= 2) y *= x;
  return c < 0.0 ? 1.0 / y : y;
}

// to[k] = f(a[k], b[k], k).
template <class Number, class F>
[[gnu::always_inline]] inline void carry_out_each(const LineTable& table, const RunOfLines& run, Number* x, const F& f) {
  Number* __restrict const to = x + run.first.to;
  const std::size_t count = run.count;
  if (run.places >= 0) {
    const std::uint32_t* const at = table.places.data() + run.places;
    for (std::size_t k = 0; k < count; ++k) to[k] = f(x[at[2 * k]], x[at[2 * k + 1]], k);
    return;
  }
  const Number *const a = x + run.first.a, *const b = x + run.first.b;
  if (run.step_a == 1 && run.step_b == 1) {
    for (std::size_t k = 0; k < count; ++k) to[k] = f(a[k], b[k], k);
  } else {
    const std::ptrdiff_t step_a = run.step_a, step_b = run.step_b;
    for (std::size_t k = 0; k < count; ++k) to[k] = f(a[static_cast<std::ptrdiff_t>(k) * step_a], b[static_cast<std::ptrdiff_t>(k) * step_b], k);
  }
}

// Carries out functions that take longer than finding a and b does: one loop for lists and for steps.
template <bool also_side_by_side, class Number, class F>
[[gnu::always_inline]] inline void carry_out_slow(const LineTable& table, const RunOfLines& run, Number* x, const F& f) {
  Number* __restrict const to = x + run.first.to;
  const std::size_t count = run.count;
  const Number *a = x + run.first.a, *b = x + run.first.b;
  if (also_side_by_side && run.places < 0 && run.step_a == 1 && run.step_b == 1) {
    for (std::size_t k = 0; k < count; ++k) to[k] = f(a[k], b[k], k);
    return;
  }
  const std::uint32_t* at = run.places < 0 ? nullptr : table.places.data() + run.places;
  for (std::size_t k = 0; k < count; ++k, a += run.step_a, b += run.step_b) {
    if (at != nullptr) a = x + at[0], b = x + at[1], at += 2;
    to[k] = f(*a, *b, k);
  }
}

// to[k] = f(a[k], b[k], d[k], e[k], k).
template <class Number, class F>
[[gnu::always_inline]] inline void carry_out_products(const LineTable& table, const RunOfLines& run, Number* x, const F& f) {
  Number* __restrict const to = x + run.first.to;
  const std::size_t count = run.count;
  if (run.places >= 0) {
    const std::uint32_t* at = table.places.data() + run.places;
    for (std::size_t k = 0; k < count; ++k, at += 4) to[k] = f(x[at[0]], x[at[1]], x[at[2]], x[at[3]], k);
    return;
  }
  const Number *a = x + run.first.a, *b = x + run.first.b, *d = x + run.first.d, *e = x + run.first.e;
  for (std::size_t k = 0; k < count; ++k, a += run.step_a, b += run.step_b, d += run.step_d, e += run.step_e) to[k] = f(*a, *b, *d, *e, k);
}

// Sines and cosines, some at a time.
inline void carry_out_circular(const LineTable& table, const RunOfLines& run, double* x) {
  constexpr std::uint32_t most = 32;
  CircularPlaces places[most];
  const auto write = fastest_circular();
  for (std::uint32_t k = 0, some = 0; k < run.count; k += some) {
    for (some = 0; some < most && k + some < run.count; ++some) {
      const std::uint32_t at = k + some, angle = run.places < 0 ? run.first.a + at * static_cast<std::uint32_t>(run.step_a)
                                                                : table.places[static_cast<std::size_t>(run.places) + 2 * at];
      places[some] = {angle, run.first.to + at, run.first.b + at};
    }
    write(x, places, some);
  }
}
// Whether a line is a sine and cosine beside those from `first` on: results have growing numbers, so none of theirs is its angle.
inline bool is_beside(const Line& line, const Line& first) { return line.operation == Line::Operation::sine_and_cosine && line.a < first.to; }
// Those of lines one behind the other; the first line that is none.
inline const Line* carry_out_circular(const Line* line, double* x) {
  constexpr std::size_t most = 8;
  CircularPlaces places[most];
  std::size_t count = 0;
  for (const Line& first = *line; count < most && is_beside(*line, first); ++line) places[count++] = {line->a, line->to, line->b};
  fastest_circular()(x, places, count);
  return line;
}

template <class Number>
#if defined(__GNUC__) && !defined(__clang__)
[[gnu::noinline, gnu::optimize("fp-contract=off")]]
#else
[[gnu::noinline]]
#endif
void carry_out(const LineTable& table, const RunOfLines& run, Number* x) {
#if defined(__clang__)
#pragma clang fp contract(off)
#endif
  using Operation = Line::Operation;
  using std::sqrt;
  const double ca = run.first.ca, cb = run.first.cb, c = run.first.c;
  const double* const factors = run.factors < 0 ? nullptr : table.factors.data() + run.factors;
  const auto each = [&](const auto& f) __attribute__((always_inline)) { carry_out_each(table, run, x, f); };
  const auto roots = [&](const auto& f) __attribute__((always_inline)) { carry_out_slow<true>(table, run, x, f); };
  const auto functions = [&](const auto& f) __attribute__((always_inline)) { carry_out_slow<false>(table, run, x, f); };
  const auto products = [&](const auto& f) __attribute__((always_inline)) { carry_out_products(table, run, x, f); };
  switch (run.first.operation) {
    case Operation::scaled:
      if (factors) return each([=](Number a, Number, std::size_t k) __attribute__((always_inline)) { return factors[3 * k] * a + factors[3 * k + 2]; });
      return each([=](Number a, Number, std::size_t) __attribute__((always_inline)) { return ca * a + c; });
    case Operation::combination:
      if (factors)
        return each([=](Number a, Number b, std::size_t k) __attribute__((always_inline)) {
          return factors[3 * k] * a + factors[3 * k + 1] * b + factors[3 * k + 2];
        });
      return each([=](Number a, Number b, std::size_t) __attribute__((always_inline)) { return ca * a + cb * b + c; });
    case Operation::sum: return each([](Number a, Number b, std::size_t) __attribute__((always_inline)) { return a + b; });
    case Operation::difference: return each([](Number a, Number b, std::size_t) __attribute__((always_inline)) { return a - b; });
    case Operation::product: return each([](Number a, Number b, std::size_t) __attribute__((always_inline)) { return a * b; });
    case Operation::square: return each([](Number a, Number, std::size_t) __attribute__((always_inline)) { return a * a; });
    case Operation::quotient: return each([](Number a, Number b, std::size_t) __attribute__((always_inline)) { return a / b; });
    case Operation::inverse: return each([](Number a, Number, std::size_t) __attribute__((always_inline)) { return 1.0 / a; });
    case Operation::root: return roots([](Number a, Number, std::size_t) __attribute__((always_inline)) { return sqrt(a); });
    case Operation::inverse_root: return roots([](Number a, Number, std::size_t) __attribute__((always_inline)) { return 1.0 / sqrt(a); });
    case Operation::power: return functions([=](Number a, Number, std::size_t) __attribute__((always_inline)) { return raised(a, c); });
    case Operation::sine_and_cosine: return carry_out_circular(table, run, x);
    case Operation::function: {
      const Function f = run.first.function;
      return functions([=](Number a, Number b, std::size_t) __attribute__((always_inline)) { return value_of(f, a, b); });
    }
    case Operation::product_sum: return products([](Number a, Number b, Number d, Number, std::size_t) __attribute__((always_inline)) { return a * b + d; });
    case Operation::product_difference:
      return products([](Number a, Number b, Number d, Number, std::size_t) __attribute__((always_inline)) { return a * b - d; });
    case Operation::less_product: return products([](Number a, Number b, Number d, Number, std::size_t) __attribute__((always_inline)) { return d - a * b; });
    case Operation::product_combination:
      if (factors)
        return products([=](Number a, Number b, Number d, Number, std::size_t k) __attribute__((always_inline)) {
          return factors[3 * k] * (a * b) + factors[3 * k + 1] * d;
        });
      return products([=](Number a, Number b, Number d, Number, std::size_t) __attribute__((always_inline)) { return ca * (a * b) + cb * d; });
    case Operation::products_sum:
      return products([](Number a, Number b, Number d, Number e, std::size_t) __attribute__((always_inline)) { return a * b + d * e; });
    case Operation::products_difference:
      return products([](Number a, Number b, Number d, Number e, std::size_t) __attribute__((always_inline)) { return a * b - d * e; });
    case Operation::products_combination:
      if (factors)
        return products([=](Number a, Number b, Number d, Number e, std::size_t k) __attribute__((always_inline)) {
          return factors[3 * k] * (a * b) + factors[3 * k + 1] * (d * e);
        });
      return products([=](Number a, Number b, Number d, Number e, std::size_t) __attribute__((always_inline)) { return ca * (a * b) + cb * (d * e); });
    case Operation::end:
    case Operation::constant:
    case Operation::run: return;
  }
}

// All lines, on numbers x. Each jumps to the next by itself: a processor predicts several jumps separately. With one jump in a
// loop it predicts worse, and the lines take half as long again.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"  // labels as values, which g++ and clang have
template <class Number>
#if defined(__GNUC__) && !defined(__clang__)
[[gnu::optimize("fp-contract=off")]]
#endif
void carry_out(const LineTable& table, Number* x) {
#if defined(__clang__)
#pragma clang fp contract(off)
#endif
  using std::sqrt;
  static const void* const ways[] = {&&end,     &&constant, &&scaled, &&combination,  &&sum,   &&difference,      &&product,  &&square,
                                     &&quotient, &&inverse,  &&root,   &&inverse_root, &&power, &&sine_and_cosine, &&function, &&run,
                                     &&product_sum, &&product_difference, &&less_product, &&product_combination, &&products_sum,
                                     &&products_difference, &&products_combination};
  const auto way = [](const Line* l) { return static_cast<std::size_t>(l->operation); };
  const Line* line = table.lines.data();
  goto* ways[way(line)];
constant:
  x[line->to] = line->c;
  goto* ways[way(++line)];
scaled:
  x[line->to] = line->ca * x[line->a] + line->c;
  goto* ways[way(++line)];
combination:
  x[line->to] = line->ca * x[line->a] + line->cb * x[line->b] + line->c;
  goto* ways[way(++line)];
sum:
  x[line->to] = x[line->a] + x[line->b];
  goto* ways[way(++line)];
difference:
  x[line->to] = x[line->a] - x[line->b];
  goto* ways[way(++line)];
product:
  x[line->to] = x[line->a] * x[line->b];
  goto* ways[way(++line)];
square:
  x[line->to] = x[line->a] * x[line->a];
  goto* ways[way(++line)];
quotient:
  x[line->to] = x[line->a] / x[line->b];
  goto* ways[way(++line)];
inverse:
  x[line->to] = 1.0 / x[line->a];
  goto* ways[way(++line)];
root:
  x[line->to] = sqrt(x[line->a]);
  goto* ways[way(++line)];
inverse_root:
  x[line->to] = 1.0 / sqrt(x[line->a]);
  goto* ways[way(++line)];
power:
  x[line->to] = raised(x[line->a], line->c);
  goto* ways[way(++line)];
sine_and_cosine:
  line = carry_out_circular(line, x);
  goto* ways[way(line)];
function:
  x[line->to] = value_of(line->function, x[line->a], x[line->b]);
  goto* ways[way(++line)];
run:
  carry_out(table, table.runs[line->a], x);
  goto* ways[way(++line)];
product_sum:
  x[line->to] = x[line->a] * x[line->b] + x[line->d];
  goto* ways[way(++line)];
product_difference:
  x[line->to] = x[line->a] * x[line->b] - x[line->d];
  goto* ways[way(++line)];
less_product:
  x[line->to] = x[line->d] - x[line->a] * x[line->b];
  goto* ways[way(++line)];
product_combination:
  x[line->to] = line->ca * (x[line->a] * x[line->b]) + line->cb * x[line->d];
  goto* ways[way(++line)];
products_sum:
  x[line->to] = x[line->a] * x[line->b] + x[line->d] * x[line->e];
  goto* ways[way(++line)];
products_difference:
  x[line->to] = x[line->a] * x[line->b] - x[line->d] * x[line->e];
  goto* ways[way(++line)];
products_combination:
  x[line->to] = line->ca * (x[line->a] * x[line->b]) + line->cb * (x[line->d] * x[line->e]);
  goto* ways[way(++line)];
end:;
}
#pragma GCC diagnostic pop

#ifdef QDOT_COMPILED
extern template void carry_out<double>(const LineTable&, const RunOfLines&, double*);
extern template void carry_out<double>(const LineTable&, double*);
#endif

}  // namespace qdot::formula
