// SPDX-License-Identifier: MIT
//
// Lists of operations against the formulas that they come from.
#include "catch2_bridge.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "qdot/ad/formula/trace_list.hpp"

using namespace qdot::trace;

namespace {

// Runs f(x, y) on two inputs; what it did, in order.
template <class F>
constexpr void run_of(const F& f, Recording& ordered) {
  Recording run;
  run.inputs = 2;
  const Traced result = f(Traced(run, 0), Traced(run, 1));
  run.result = result.operand_in(run);
  run.put_in_order(ordered);
}

// The list of f, whose constants are all literals: another run agrees everywhere.
template <class F>
constexpr auto list_of(const F&) {
  constexpr auto extent = [] {
    Recording run;
    run_of(F(), run);
    return std::pair(run.steps, run.constants);
  }();
  Recording run;
  run_of(F(), run);
  return List<extent.first, extent.second>(run, &run);
}

// The worst difference of f from its list gone through on plain numbers.
template <class F>
double difference_from_list(const F& f) {
  static constexpr auto list = list_of(F());
  double worst = 0.0;
  for (const double x : {0.2, 0.7})
    for (const double y : {0.3, 0.9}) {
      double value[2 + list.count] = {x, y};
      const auto operand = [&](int i) { return i < 0 ? list.value[-1 - i] : value[i]; };
      [&]<int... i>(std::integer_sequence<int, i...>) {
        ((value[2 + i] = applied<list.step[i].operation>(operand(list.step[i].a), operand(list.step[i].b))), ...);
      }(std::make_integer_sequence<int, list.count>());
      worst = std::max(worst, std::abs(operand(list.result) - f(x, y)));
    }
  return worst;
}

// The compiler may contract a product and a sum.
constexpr double rounded = 1e-14;

constexpr auto looped = [](const auto& x, const auto& y) {
  auto sum = 0.0 * x;
  for (int k = 0; k < 2; ++k) sum += x * y;
  return sum;
};
constexpr auto straight = [](const auto& x, const auto& y) { return 0.0 * x + x * y + x * y; };

template <class F, class G>
bool same_run(const F& f, const G& g) {
  const auto a = std::make_unique<Recording>(), b = std::make_unique<Recording>();
  run_of(f, *a);
  run_of(g, *b);
  if (a->steps != b->steps || a->constants != b->constants || a->result != b->result) return false;
  for (int i = 0; i < a->steps; ++i)
    if (!(a->step[i] == b->step[i])) return false;
  return true;
}

}  // namespace

TEST_CASE("a loop leaves the list of the same formula without a loop") { CHECK(same_run(looped, straight)); }

TEST_CASE("a list does not depend on which operand was evaluated first") {
  CHECK(same_run([](const auto& x, const auto& y) { const auto a = sin(x), b = 2.0 * cos(y); return a + b; },
                 [](const auto& x, const auto& y) { const auto b = 2.0 * cos(y), a = sin(x); return a + b; }));
  CHECK(!same_run([](const auto& x, const auto& y) { return sin(x) + cos(y); }, [](const auto& x, const auto& y) { return cos(y) + sin(x); }));
}

TEST_CASE("a list is a constant of the program") {
  constexpr auto list = [] {
    Recording run;
    run_of([](const auto& x, const auto& y) { return x * y + 3.0; }, run);
    return List<2, 1>(run, nullptr);
  }();
  static_assert(list.count == 2 && list.step[0] == Step{Operation::multiply, 0, 1} && list.step[1] == Step{Operation::add, 2, -1});
  CHECK(list.value[0] == 3.0);
}

TEST_CASE("what is added to zero or multiplied by one is not in the list, and equal steps are one") {
  const auto added = list_of([](const auto& x, const auto& y) { return (0.0 + x * y) + (x * y - 0.0) * 1.0; });
  CHECK(added.count == 2);
  CHECK(added.step[0] == Step{Operation::multiply, 0, 1});
  CHECK(added.step[1] == Step{Operation::add, 2, 2});
}

TEST_CASE("a list gone through on numbers gives the values of its formula") {
  CHECK(difference_from_list([](const auto& x, const auto& y) { return x / y - 2.0 / x + x / 3.0 - (-y); }) < rounded);
  CHECK(difference_from_list([](const auto& x, const auto& y) { return sqrt(x) * cbrt(y) + pow(x, 1.5) + pow(x, y) + pow(x, 2) + pow(x, 5); }) < rounded);
  CHECK(difference_from_list([](const auto& x, const auto& y) { return exp(x) + exp2(y) + expm1(x) + log(x) + log2(y) + log10(x) + log1p(y); }) < rounded);
  CHECK(difference_from_list([](const auto& x, const auto& y) { return sin(x) + cos(y) + tan(x) + asin(y) + acos(x) + atan(y); }) < rounded);
  CHECK(difference_from_list([](const auto& x, const auto& y) { return sinh(x) + cosh(y) + tanh(x) + asinh(y) + acosh(1.0 + x) + atanh(y); }) < rounded);
  CHECK(difference_from_list([](const auto& x, const auto& y) { return erf(x) + erfc(y) + atan2(x, y) + hypot(x, y) + fma(x, y, x); }) < rounded);
  CHECK(difference_from_list([](const auto& x, const auto& y) { return floor(3.0 * x) + ceil(3.0 * y) + copysign(x, -y) + fabs(x - y) + x * (+y); }) < rounded);
}

TEST_CASE("what the result does not need is not in the list") {
  const auto run = std::make_unique<Recording>();
  run_of([](const auto& x, const auto& y) { const auto unused = exp(y); (void)unused; return x * x; }, *run);
  CHECK(run->steps == 1);
}

TEST_CASE("constants that differ between two runs are parameters, and two runs decide which of them are equal") {
  const auto made = [](double a, double b) { return [=](const auto& x, const auto& y) { return a * x + b * y + a * y + 2.0; }; };
  const auto first = std::make_unique<Recording>(), second = std::make_unique<Recording>(), third = std::make_unique<Recording>();
  run_of(made(1.0, 1.0), *first);
  run_of(made(0.3, 0.7), *second);
  run_of(made(5.0, 6.0), *third);
  const List<6, 4> list(*first, second.get());
  CHECK(list.literal[3]);
  CHECK(!list.literal[0]);
  CHECK(list.same_as[1] == 1);  // equal to the first one in one run only
  CHECK(list.same_as[2] == 0);
  CHECK(list.describes(*third));
  third->constant[2] = 7.0;  // the third parameter is no longer the first one
  CHECK(!list.describes(*third));
  run_of([](const auto& x, const auto& y) { return 5.0 * x + 6.0 * y + 5.0 * y + 3.0; }, *second);
  CHECK(!list.describes(*second));
}

TEST_CASE("a comparison of traced numbers is noted as a branch, one of constants is not") {
  const auto run = std::make_unique<Recording>();
  run_of([](const auto& x, const auto& y) { return x < y ? x : y; }, *run);
  CHECK(run->branches);
  const auto other = std::make_unique<Recording>();
  run_of([](const auto& x, const auto&) { return Traced(1.0) < Traced(2.0) ? 2.0 * x : x; }, *other);
  CHECK(!other->branches);
  CHECK(other->steps == 1);
}

TEST_CASE("functions of constants are constants") {
  const auto run = std::make_unique<Recording>();
  run_of([](const auto& x, const auto&) { return pow(max(Traced(2.0), Traced(1.0)), Traced(0.5)) * sin(Traced(1.0)) * x; }, *run);
  REQUIRE(run->constants == 1);
  CHECK(run->constant[0] == std::pow(2.0, 0.5) * std::sin(1.0));
}

TEST_CASE("a run of more operations than fit is noted") {
  const auto run = std::make_unique<Recording>();
  run_of([](const auto& x, const auto& y) { auto s = x; for (int k = 0; k < longest + 1; ++k) s += y; return s; }, *run);
  CHECK(run->too_long);
}
