#pragma once
// SPDX-License-Identifier: MIT
//
// When a formula with branches becomes another one.
//
// A functor that compares is a formula as long as no guard changes its sign (ad/formula/branches.hpp). Guards that depend on time alone say when
// this ends: intervals bound them over a whole stretch [a, b], and one that excludes zero there has not switched. The stretch in front is halved until
// that is so, and doubled behind; what a few rounding units of t leave undecided is a switch. Nothing shorter than these is passed over, and
// a pulse of a nanosecond within hours costs some hundred evaluations.
//
// A guard with state and time, q < a sin t, is followed along the straight way on which the state is going, so a switch of it is a forecast.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "qdot/ad/formula/branches.hpp"
#include "qdot/ad/formula/graph.hpp"
#include "qdot/ad/formula/interval.hpp"

namespace qdot::formula {

/// Where something switches: not before `last`, and not behind `first`, in the direction of the search.
struct Switch {
  double last = 0.0;
  double first = 0.0;
};

/// Whether the outputs of two graphs are the same formulas of the same variables.
template <class Coefficient>
bool same_outputs(const BasicGraph<Coefficient>& a, std::span<const int> outputs_a, const BasicGraph<Coefficient>& b, std::span<const int> outputs_b) {
  if (outputs_a.size() != outputs_b.size()) return false;
  std::vector<int> partner(a.nodes().size(), -1);
  std::vector<std::pair<int, int>> left;
  for (std::size_t i = 0; i < outputs_a.size(); ++i) left.emplace_back(outputs_a[i], outputs_b[i]);
  while (!left.empty()) {
    const auto [x, y] = left.back();
    left.pop_back();
    if (x < 0 || y < 0) {
      if (x != y) return false;
      continue;
    }
    int& known = partner[static_cast<std::size_t>(x)];
    if (known == y) continue;
    const auto &m = a[x], &n = b[y];
    if (known >= 0 || m.kind != n.kind || m.function != n.function || m.ca != n.ca || m.cb != n.cb || m.c != n.c) return false;
    known = y;
    if (m.kind == Kind::variable && m.a != n.a) return false;
    if (m.kind == Kind::constant || m.kind == Kind::variable) continue;
    left.emplace_back(m.a, n.a);
    left.emplace_back(m.b, n.b);
  }
  return true;
}

/// The guards of one recording. A template, for programs without functions of time compile nothing of it.
template <class Number = double>
class BasicTimeGuards {
 public:
  enum class Kind { of_time, of_both, of_state };

  BasicTimeGuards() = default;

  /// @param met  what a recording has noted; `places` are the differences from their levels, as nodes
  /// @param t    the time's variable; all others are of the state
  BasicTimeGuards(const BasicGraph<Number>& graph, std::span<const formula::Guard> met, std::span<const int> places, int t) {
    const auto count = graph.nodes().size();
    std::vector<int> others;
    for (std::size_t w = 0; w < count; ++w)
      if (graph.nodes()[w].kind == formula::Kind::variable && static_cast<int>(w) != t) others.push_back(static_cast<int>(w));
    const std::vector<char> needed = graph.needed_for(places);
    const std::vector<char> timed = graph.dependence(static_cast<int>(count) - 1, std::vector<int>{t});
    const std::vector<char> stated = graph.dependence(static_cast<int>(count) - 1, others);
    std::vector<int> place(count, -1);
    for (std::size_t w = 0; w < count; ++w) {
      if (needed[w] == 0) continue;
      Node node = graph.nodes()[w];
      if (node.kind != formula::Kind::constant && node.kind != formula::Kind::variable) {
        node.a = place[static_cast<std::size_t>(node.a)];
        if (node.b >= 0) node.b = place[static_cast<std::size_t>(node.b)];
      }
      place[w] = static_cast<int>(nodes_.size());
      nodes_.push_back(node);
    }
    time_ = t < 0 || static_cast<std::size_t>(t) >= count ? -1 : graph[t].a;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const auto w = static_cast<std::size_t>(places[i]);
      const Kind kind = stated[w] == 0 ? Kind::of_time : timed[w] == 0 ? Kind::of_state : Kind::of_both;
      if (graph.nodes()[w].kind == formula::Kind::constant) continue;
      guards_.push_back({place[w], kind, met[i].sign < 0.0});
      any_[static_cast<int>(kind)] = true;
    }
    bounds_.resize(nodes_.size());
    values_.resize(nodes_.size());
  }

  bool any(Kind kind) const noexcept { return any_[static_cast<int>(kind)]; }
  bool any_of_state() const noexcept { return any(Kind::of_both) || any(Kind::of_state); }
  /// Guards that are zero for longer than rounding explains; they are not followed any more.
  bool gave_up() const noexcept { return gave_up_; }

  /// Whether a guard with state has another side at (t, y) than where it was recorded.
  bool changed(double t, std::span<const double> y) {
    evaluate(t, y);
    return std::any_of(guards_.begin(), guards_.end(), [&](const Guard& g) {
      return g.kind != Kind::of_time && value(g.place) != 0.0 && (value(g.place) < 0.0) != g.negative;
    });
  }

  /// The first switch of guards of a kind on the way from `from` to `to`, as far as `trials` evaluations reach.
  ///
  /// @param y      at `from`, moving with the given rates
  /// @param clear  ← as far as there is none
  std::optional<Switch> first(Kind kind, double from, double to, std::span<const double> y, std::span<const double> rates, int trials, double& clear) {
    const double least = std::ldexp(std::abs(to - from), -30);
    const auto unit = [&](double a, double b) { return 4 * std::numeric_limits<double>::epsilon() * std::max({std::abs(a), std::abs(b), least}); };
    const auto decided = [&](double a, double b) { return this->decided(kind, a, b, from, y, rates); };
    const double sign = to < from ? -1.0 : 1.0;
    double length = std::abs(to - from);
    for (clear = from; clear != to && trials > 0; --trials) {
      const double end = length >= std::abs(to - clear) ? to : clear + sign * length;
      if (decided(clear, end)) {
        clear = end;
        length *= 2.0;
        continue;
      }
      const double shortest = unit(clear, end);
      if (std::abs(end - clear) > 2.0 * shortest) {
        length = std::max(0.5 * std::abs(end - clear), shortest);
        continue;
      }
      return isolated(kind, clear, end, y, decided);
    }
    return std::nullopt;
  }

 private:
  struct Guard {
    int place;
    Kind kind;
    bool negative;
  };

  // The last time in front of a switch and the first one behind it, for a switch between a and b, or at b. At a the guards are clear.
  template <class Decided>
  std::optional<Switch> isolated(Kind kind, double a, double b, std::span<const double> y, const Decided& decided) {
    evaluate(a, y);
    std::vector<int> before;
    for (const Guard& g : guards_) before.push_back(sign_of(g));
    const auto is_as_before = [&](double t) {
      evaluate(t, y);
      return std::equal(guards_.begin(), guards_.end(), before.begin(), [&](const Guard& g, int sign) { return g.kind != kind || sign_of(g) == sign; });
    };
    Switch found{a, b};
    for (double middle = 0.5 * (a + b); kind == Kind::of_time && middle != found.last && middle != found.first; middle = 0.5 * (found.last + found.first))
      (is_as_before(middle) ? found.last : found.first) = middle;
    // Where rounding leaves it open what a functor finds, nothing is asked.
    for (double gap = std::abs(found.first - found.last); found.last != a && !decided(found.last, found.last); gap *= 2.0)
      found.last = std::abs(found.last - a) <= gap ? a : found.last + std::copysign(gap, a - b);
    const double width = 1e3 * std::abs(b - a);
    for (double gap = std::abs(found.first - found.last); !decided(found.first, found.first); gap *= 2.0) {
      if (gap > width) return given_up(kind), std::nullopt;
      found.first += std::copysign(gap, b - a);
    }
    return found;
  }

  int sign_of(const Guard& g) const { return value(g.place) < 0.0 ? -1 : value(g.place) > 0.0 ? 1 : 0; }
  void evaluate(double t, std::span<const double> y) {
    for (std::size_t w = 0; w < nodes_.size(); ++w) {
      const Node& node = nodes_[w];
      if (node.kind == formula::Kind::variable) values_[w] = variable(node.a, t, y);
      else values_[w] = node.kind == formula::Kind::constant ? node.c : result(node, value(node.a), value(node.b));
    }
  }

  static double result(const Node& node, double a, double b) {
    switch (node.kind) {
      case formula::Kind::affine: return node.ca * a + (node.b >= 0 ? node.cb * b : 0.0) + node.c;
      case formula::Kind::product: return a * b;
      case formula::Kind::quotient: return a / b;
      case formula::Kind::power: return std::pow(a, node.c);
      case formula::Kind::function: return value_of(node.function, a, b);
      case formula::Kind::constant:
      case formula::Kind::variable: break;
    }
    return node.c;
  }
  double value(int place) const { return place < 0 ? 0.0 : values_[static_cast<std::size_t>(place)]; }
  double variable(int number, double t, std::span<const double> y) const {
    return number == time_ ? t : y[static_cast<std::size_t>(number < time_ ? number : number - 1)];
  }

  bool decided(Kind kind, double a, double b, double from, std::span<const double> y, std::span<const double> rates) {
    for (std::size_t w = 0; w < nodes_.size(); ++w) {
      const Node& node = nodes_[w];
      Interval& bound = bounds_[w];
      if (node.kind == formula::Kind::constant) bound = node.c;
      else if (node.kind != formula::Kind::variable) bound = over(node);
      else if (node.a == time_) bound = Interval::between(a, b);
      else {
        const double here = variable(node.a, a, y), rate = variable(node.a, a, rates);
        bound = rate == 0.0 ? Interval(here) : Interval::between(here + (a - from) * rate, here + (b - from) * rate);
      }
    }
    return std::none_of(guards_.begin(), guards_.end(), [&](const Guard& g) { return g.kind == kind && is_open(g); });
  }
  bool is_open(const Guard& g) const { return bounds_[static_cast<std::size_t>(g.place)].contains(0.0); }

  void given_up(Kind kind) {
    std::erase_if(guards_, [&](const Guard& g) { return g.kind == kind && is_open(g); });
    gave_up_ = true;
  }

  // Without rounding where there is none: t_off - t is as sharp as t - t_off, also where t counts seconds since 1970.
  static Interval times(double factor, const Interval& x) { return factor == 1.0 ? x : factor == -1.0 ? -x : factor * x; }

  Interval over(const Node& node) const {
    const Interval& a = bounds_[static_cast<std::size_t>(node.a)];
    const Interval& b = bounds_[static_cast<std::size_t>(node.b < 0 ? node.a : node.b)];
    switch (node.kind) {
      case formula::Kind::affine: {
        const Interval first = times(node.ca, a);
        return node.b < 0 ? first + node.c : node.c == 0.0 ? first + times(node.cb, b) : first + times(node.cb, b) + node.c;
      }
      case formula::Kind::product: return a * b;
      case formula::Kind::quotient: return a / b;
      case formula::Kind::power: return pow(a, node.c);
      case formula::Kind::function: return value_of(node.function, a, b);
      case formula::Kind::constant:
      case formula::Kind::variable: break;
    }
    return a;
  }

  std::vector<Node> nodes_;  // their arguments are places in this list; a variable's is its number
  std::vector<Guard> guards_;
  std::vector<Interval> bounds_;
  std::vector<double> values_;
  int time_ = -1;
  bool any_[3] = {}, gave_up_ = false;
};

using TimeGuards = BasicTimeGuards<>;

}  // namespace qdot::formula
