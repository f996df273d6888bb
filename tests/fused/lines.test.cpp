// SPDX-License-Identifier: MIT
//
// Lines where the compiler fuses products with sums (-mfma, as by -march=native).
#include <bit>
#include <cstdint>

#include "bench/chain_energies.hpp"
#include "catch2_bridge.hpp"
#include "qdot/ad/formula/lines.hpp"
#include "qdot/ad/native/line_evaluator.ipp"
#include "qdot/mechanics/first_order_form.hpp"

using namespace qdot;

namespace {

bool processor_fuses() {
#if defined(__FMA__)
  return __builtin_cpu_supports("fma") != 0;
#else
  return true;  // this file is not compiled for it
#endif
}

}  // namespace

TEST_CASE("no line has a fused product: 0.1 times 10, less 1, is 0") {
  if (!processor_fuses()) return;
  using Operation = formula::Line::Operation;
  formula::Line line{Operation::product_difference, formula::Function::none, 3, 0, 1};
  line.d = 2;
  formula::LineTable table;
  table.lines = {line, formula::Line{}};
  double x[] = {0.1, 10.0, 1.0, 7.0};
  formula::carry_out(table, x);
  CHECK(x[3] == 0.0);  // 2⁻⁵⁴ with one rounding
  formula::LineTable by_run;
  formula::Line run;
  run.operation = Operation::run;
  line.to = 9;
  line.b = 3, line.d = 6;
  by_run.lines = {run, formula::Line{}};
  by_run.runs = {{line, 3, 1, 1, 1, 0}};
  double y[] = {0.1, 0.1, 0.1, 10.0, 10.0, 10.0, 1.0, 1.0, 1.0, 7.0, 7.0, 7.0};
  formula::carry_out(by_run, y);
  CHECK((y[9] == 0.0 && y[10] == 0.0 && y[11] == 0.0));
}

TEST_CASE("where products are fused elsewhere, accelerations have the same bits before and after there is machine code") {
  if (!processor_fuses()) return;
  const auto form = first_order_form(mechanical_system<4>(bench::LoopedChain{}));
  const double y[] = {0.3, 0.1, -0.4, 1.0, 0.1, 0.2, 0.3, 0.4};
  double first[8], later[8];
  form.write_derivative(0.0, y, first);
  for (long k = 0; k < 2 * formula::LineEvaluator::begin_after; ++k) form.write_derivative(0.0, y, later);
  for (int i = 0; i < 8; ++i) CHECK(std::bit_cast<std::uint64_t>(first[i]) == std::bit_cast<std::uint64_t>(later[i]));
}
