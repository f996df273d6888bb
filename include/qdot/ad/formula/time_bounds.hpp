#pragma once
// SPDX-License-Identifier: MIT
//
// How fast a formula changes with time, over a whole stretch of time at once.
//
// A push of a thousandth of a second within hours of rest is found by no number of samples. But the nodes of a recorded
// formula (ad/formula/recording.hpp) that depend on time alone are functions u(t), and intervals bound them over [a, b]:
//
//     u ∈ U ,   du/dt ∈ D ,        so that a stretch of      4 width(U) / max |D|      can hide nothing of u .
//
// For sin Ωt that is 4/Ω or more; for a bell of width w the same with w. Where u only rises or only falls it may be four
// times as long, for the end of a step feels it. What is too wide shrinks where [a, b] is halved. Nodes are watched that
// are no sums (of a sum, the summands) and whose value leaves time: not (t − 8)² inside of an exponential, but the
// exponential. A quotient by something of time counts as its inverse. So do functions of state and time together,
// f(q − ct), with q on the straight way that q̇ points to. Reverse differentiation with the largest slopes bounds how
// much u can change what finally depends on it; where that is less than the accuracy asked for, u is left out.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "qdot/ad/formula/graph.hpp"
#include "qdot/ad/formula/interval.hpp"

namespace qdot::formula {

/// f′ over an interval, where f is w there; of atan2 and hypot, along the first argument.
inline Interval slope_bounds(Function f, const Interval& x, const Interval& y, const Interval& w) {
  const auto bell = [&] { return 1.12837916709551257390 * exp(-(x * x)); };
  switch (f) {
    case Function::none: break;
    case Function::sin: return cos(x);
    case Function::cos: return -sin(x);
    case Function::tan: return 1.0 + w * w;
    case Function::asin: return 1.0 / sqrt(1.0 - x * x);
    case Function::acos: return -1.0 / sqrt(1.0 - x * x);
    case Function::atan: return 1.0 / (1.0 + x * x);
    case Function::atan2: return y / (x * x + y * y);
    case Function::hypot: return w.contains(0.0) ? Interval::around(-1.0, 1.0) : x / w;
    case Function::exp: return w;
    case Function::expm1: return w + 1.0;
    case Function::log: return 1.0 / x;
    case Function::log1p: return 1.0 / (1.0 + x);
    case Function::sinh: return cosh(x);
    case Function::cosh: return sinh(x);
    case Function::tanh: return 1.0 - w * w;
    case Function::asinh: return 1.0 / sqrt(1.0 + x * x);
    case Function::acosh: return 1.0 / sqrt(x * x - 1.0);
    case Function::atanh: return 1.0 / (1.0 - x * x);
    case Function::cbrt: return 1.0 / (3.0 * (w * w));
    case Function::erf: return bell();
    case Function::erfc: return -bell();
  }
  return 1.0;
}

/// The functions of time in a formula. A template, for programs without functions of time read this and compile nothing of it.
template <class Number = double>
class BasicTimeBounds {
 public:
  BasicTimeBounds() = default;

  /// @param t      the time's node
  /// @param state  the nodes of the other variables, in the order in which over() is given them
  /// @param roots  all that matters
  BasicTimeBounds(const BasicGraph<Number>& graph, int t, std::span<const int> state, std::span<const int> roots) {
    const std::size_t count = graph.nodes().size();
    const std::vector<char> timed = graph.dependence(static_cast<int>(count) - 1, std::vector<int>{t});
    const std::vector<char> stated = graph.dependence(static_cast<int>(count) - 1, state);
    const std::vector<char> needed = graph.needed_for(roots);
    std::vector<char> shows(count, 0), ends(count, 0), watched(count, 0), inverted(count, 0);
    for (const int w : roots) shows[index(w)] = ends[index(w)] = timed[index(w)] != 0 && stated[index(w)] == 0;
    for (std::size_t w = count; w-- > 0;) {
      const Node& node = graph.nodes()[w];
      if (needed[w] == 0 || timed[w] == 0 || node.kind == Kind::variable) continue;
      const bool curved = node.kind == Kind::function || node.kind == Kind::power;
      for (const int x : {node.a, node.b}) {
        if (x < 0 || timed[index(x)] == 0) continue;
        if (stated[w] != 0 && stated[index(x)] == 0) shows[index(x)] = ends[index(x)] = 1;
        if (stated[w] != 0 && curved) watched[w] = ends[w] = 1;
        if (stated[w] == 0 && shows[w] != 0 && !curved) shows[index(x)] = 1;
      }
      if (stated[w] != 0 && node.kind == Kind::quotient && timed[index(node.b)] != 0) inverted[index(node.b)] = 1;
      if (stated[w] == 0 && shows[w] != 0 && node.kind != Kind::affine) watched[w] = 1;
      mixes_ = mixes_ || (watched[w] != 0 && stated[w] != 0);
    }
    std::vector<char> kept(count, 0);
    for (std::size_t w = count; w-- > 0;) {
      const Node& node = graph.nodes()[w];
      if ((kept[w] | watched[w] | ends[w] | inverted[w]) == 0) continue;
      kept[w] = 1;
      if (node.kind == Kind::constant || node.kind == Kind::variable) continue;
      kept[index(node.a)] = 1;
      if (node.b >= 0) kept[index(node.b)] = 1;
    }
    std::vector<int> place(count, -1);
    for (std::size_t w = 0; w < count; ++w) {
      if (kept[w] == 0) continue;
      const Node& node = graph.nodes()[w];
      const bool is_leaf = node.kind == Kind::constant || node.kind == Kind::variable;
      place[w] = add(node, is_leaf ? -1 : place[index(node.a)], is_leaf || node.b < 0 ? -1 : place[index(node.b)]);
      items_.back().of_state = stated[w] != 0;
      if (node.kind == Kind::product) items_.back().of_square = square_factor(graph, node);
      if (node.kind == Kind::variable) items_.back().variable = variable_number(static_cast<int>(w), t, state);
      if (watched[w] != 0) watched_.push_back(place[w]);
      if (ends[w] != 0) ends_.push_back({place[w]});
      if (inverted[w] == 0) continue;
      watched_.push_back(add({.kind = Kind::power, .c = -1.0}, place[w], -1));
      ends_.push_back({watched_.back()});
    }
  }

  /// True where there is something to be looked at.
  bool is_needed() const noexcept { return !watched_.empty(); }
  /// True where some of it depends on the state as well.
  bool depends_on_state() const noexcept { return mixes_; }

  /// Bounds everything over the times from a to b, with the other variables on the way from y to y + (b − a) rates.
  ///
  /// @return  false where they are not finite
  bool over(double a, double b, std::span<const double> y, std::span<const double> rates) {
    for (Item& item : items_) {
      if (item.variable == time_itself) {
        item.value = Interval::between(a, b);
        item.rate = 1.0;
      } else if (item.variable >= 0) {
        item.rate = rates[index(item.variable)];
        item.value = Interval::between(y[index(item.variable)], y[index(item.variable)] + (b - a) * rates[index(item.variable)]);
      } else if (item.node.kind == Kind::constant) {
        item.value = item.node.c;
      } else {
        evaluate(item);
      }
    }
    return std::all_of(ends_.begin(), ends_.end(), [&](const End& end) { return std::isfinite(items_[index(end.item)].value.width()); });
  }

  /// Forgets the sizes that measure() has found.
  void forget() {
    for (End& end : ends_) end.size = std::numeric_limits<double>::min();
  }

  /// Finds the sizes beside which all is judged: what is attained between a and b, within a factor of four or in 64 trials.
  void measure(double a, double b, std::span<const double> y) {
    const std::vector<double> at_rest(y.size(), 0.0);
    struct Stretch {
      double a, b;
      std::vector<double> most;  // of each end
    };
    const auto see_point = [&](double t) {
      over(t, t, y, at_rest);
      for (End& end : ends_) {
        const Interval& value = items_[index(end.item)].value;
        if (std::isfinite(value.width())) end.size = std::max(end.size, value.smallest());
      }
    };
    const auto bounded = [&](double from, double to) {
      Stretch stretch{from, to, {}};
      over(from, to, y, at_rest);
      for (const End& end : ends_) stretch.most.push_back(items_[index(end.item)].value.largest());
      return stretch;
    };
    for (const double t : {a, 0.5 * (a + b), b}) see_point(t);
    std::vector<Stretch> stretches{bounded(a, b)};
    for (int trial = 0; trial < 64; ++trial) {
      double worst = 4.0, longest = 0.0;
      std::size_t at = stretches.size();
      for (std::size_t s = 0; s < stretches.size(); ++s)
        for (std::size_t e = 0; e < ends_.size(); ++e) {
          const double excess = stretches[s].most[e] / ends_[e].size, length = std::abs(stretches[s].b - stretches[s].a);
          if (!(excess > worst || (excess == worst && at < stretches.size() && length > longest))) continue;
          worst = excess;
          longest = length;
          at = s;
        }
      if (at == stretches.size()) return;
      const double from = stretches[at].a, to = stretches[at].b, middle = 0.5 * (from + to);
      see_point(middle);
      stretches[at] = bounded(from, middle);
      stretches.push_back(bounded(middle, to));
    }
  }

  /// The longest stretch of time that can hide nothing that matters; infinite where nothing does.
  ///
  /// @param accuracy  the part of what depends on it by which a function of time may be wrong
  double longest_step(double accuracy) {
    weigh();
    double longest = std::numeric_limits<double>::infinity();
    for (const int k : watched_) {
      const Item& item = items_[index(k)];
      const double change = item.value.width(), rate = item.rate.largest();
      if (change == 0.0 || rate == 0.0 || item.weight * change <= accuracy) continue;
      const double lengths = item.rate.smallest() > 0.0 && !item.of_state ? of_slope : of_turns;
      longest = std::isfinite(rate) && std::isfinite(change) ? std::min(longest, lengths * change / rate) : 0.0;
    }
    return longest;
  }

 private:
  static constexpr double of_turns = 4.0;   // times width(U)/max |D|; seven could be a whole period of a sine
  static constexpr double of_slope = 16.0;  // the same where u only rises or only falls, so that the end of a step feels all of it
  static constexpr int computed = -1, time_itself = -2;

  struct Item {
    Node node;  // its arguments are items
    int variable = computed;
    bool of_state = false;                     // as well
    double of_square = 0.0;                    // of a product x · cx: c
    Interval value = 0.0, rate = 0.0;          // U and D
    Interval along_a = 0.0, along_b = 0.0;     // partial derivatives
    double weight = 0.0;                       // by how much it can change what depends on it, beside the size of that
  };
  struct End {  // where time leaves for the state
    int item;
    double size = std::numeric_limits<double>::min();
  };

  static std::size_t index(int x) { return static_cast<std::size_t>(x); }

  static int variable_number(int w, int t, std::span<const int> state) {
    if (w == t) return time_itself;
    return static_cast<int>(std::find(state.begin(), state.end(), w) - state.begin());
  }

  // c where b is c·a, for that is a square, which has one sign; otherwise 0.
  static double square_factor(const Graph& graph, const Node& product) {
    if (product.a == product.b) return 1.0;
    struct LineInTime {
      int base;
      double slope, offset;
    };
    const auto line = [&](int x) {
      const Node& node = graph[x];
      return node.kind == Kind::affine && node.b < 0 ? LineInTime{node.a, node.ca, node.c} : LineInTime{x, 1.0, 0.0};
    };
    const LineInTime a = line(product.a), b = line(product.b);
    const double c = b.slope / a.slope;
    return a.base == b.base && std::abs(b.offset - c * a.offset) <= 1e-14 * std::abs(b.offset) ? c : 0.0;
  }

  int add(Node node, int a, int b) {
    node.a = a;
    node.b = b;
    items_.push_back({.node = node});
    return static_cast<int>(items_.size()) - 1;
  }

  void evaluate(Item& item) {
    const Node& node = item.node;
    const Interval& a = items_[index(node.a)].value;
    const Interval& b = items_[index(node.b < 0 ? node.a : node.b)].value;
    switch (node.kind) {
      case Kind::affine:
        item.value = node.ca * a + node.c;
        if (node.b >= 0) item.value += node.cb * b;
        item.along_a = node.ca;
        item.along_b = node.cb;
        break;
      case Kind::product:
        if (item.of_square != 0.0) {
          item.value = item.of_square * (a * a);
          item.along_a = 2.0 * item.of_square * a;
          item.along_b = 0.0;
          break;
        }
        item.value = a * b;
        item.along_a = b;
        item.along_b = a;
        break;
      case Kind::quotient:
        item.value = a / b;
        item.along_a = 1.0 / b;
        item.along_b = -(item.value / b);
        break;
      case Kind::power:
        item.value = pow(a, node.c);
        item.along_a = node.c * pow(a, node.c - 1.0);
        break;
      case Kind::function:
        item.value = value_of(node.function, a, b);
        item.along_a = slope_bounds(node.function, a, b, item.value);
        if (node.b >= 0) item.along_b = node.function == Function::hypot ? slope_bounds(node.function, b, a, item.value) : -(a / (a * a + b * b));
        break;
      case Kind::constant:
      case Kind::variable: break;
    }
    item.rate = times(item.along_a, items_[index(node.a)].rate);
    if (node.b >= 0) item.rate += times(item.along_b, items_[index(node.b)].rate);
  }

  // What does not move has no rate, however steep the slope.
  static Interval times(const Interval& slope, const Interval& rate) { return rate.largest() == 0.0 ? Interval(0.0) : slope * rate; }

  void weigh() {
    for (Item& item : items_) item.weight = 0.0;
    for (const End& end : ends_) items_[index(end.item)].weight += 1.0 / end.size;
    for (std::size_t k = items_.size(); k-- > 0;) {
      const Item& item = items_[k];
      if (item.node.a < 0 || item.weight == 0.0) continue;
      items_[index(item.node.a)].weight += item.weight * item.along_a.largest();
      if (item.node.b >= 0) items_[index(item.node.b)].weight += item.weight * item.along_b.largest();
    }
  }

  std::vector<Item> items_;
  std::vector<int> watched_;
  std::vector<End> ends_;
  bool mixes_ = false;
};

using TimeBounds = BasicTimeBounds<>;

}  // namespace qdot::formula
