#pragma once
// SPDX-License-Identifier: MIT
//
// From a graph to lines, equal ones together.
//
// An operation can be carried out as soon as its arguments are there, so nodes have levels: one more than the higher of their arguments'. On a level
// the order is free. Nodes with the same operation are put behind each other in the order of their arguments' places, and get consecutive places
// themselves. Where the user's loop went from neighbour to neighbour, so do the places, and the level becomes a few runs (ad/formula/lines.hpp).
//
// A product with one sum or difference as its only user is part of that one's line.
//
// Arrays of a million numbers do not fit into the memory that a processor has near, and reading them once for each level costs more than
// the arithmetic. So the outputs are taken a tile at a time, and what a tile needs is made while its numbers are near.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "qdot/ad/formula/graph.hpp"
#include "qdot/ad/formula/in_order.hpp"
#include "qdot/ad/formula/lines.hpp"

namespace qdot::formula {

/// Writes lines for nodes of a graph. The first numbers are the variables, as they are numbered; at least `shortest_run` equal lines make a run.
template <class Coefficient>
class LineWriter {
 public:
  LineWriter(const BasicGraph<Coefficient>& graph, std::size_t inputs, std::size_t shortest_run = 4)
      : graph_(graph), shortest_run_(shortest_run), count_(static_cast<std::uint32_t>(inputs)) {
    see_new_nodes();
  }

  /// Appends what `outputs` (node numbers, −1 for none) need and is not there yet, some `tile` of them at a time. The table has no end yet.
  void write(const std::vector<int>& outputs, LineTable& table, std::size_t tile = 4096) {
    see_new_nodes();
    for (std::size_t first = 0; first < outputs.size(); first += tile) {
      find_needed(outputs, first, std::min(outputs.size(), first + tile));
      find_parts(outputs, first, std::min(outputs.size(), first + tile));
      write_levels(table);
    }
  }

  /// Goes on behind numbers that come of others' lines.
  void go_on_from(std::size_t count) { count_ = static_cast<std::uint32_t>(count); }
  /// Where the value of a variable is for all that is written from now on.
  void place(int variable, int number) {
    see_new_nodes();
    place_[static_cast<std::size_t>(variable)] = number;
  }
  /// How many numbers there are by now.
  std::size_t count() const { return count_; }
  /// Where a node's value is; −1 for node −1.
  int number(int node) const { return node < 0 ? -1 : place_[static_cast<std::size_t>(node)]; }
  std::vector<int> numbers(const std::vector<int>& nodes) const {
    std::vector<int> all = nodes;
    for (int& node : all) node = number(node);
    return all;
  }

 private:
  using Operation = Line::Operation;

  static constexpr int none = -1;

  // A node on its level; of a sine and a cosine of one angle, both, of which one may be missing.
  struct Element {
    Line line;
    int node, sine = none, cosine = none;
  };

  void see_new_nodes() {
    const std::size_t seen = place_.size();
    for (auto* const list : {&place_, &level_, &users_}) list->resize(graph_.nodes().size());
    for (std::size_t w = seen; w < place_.size(); ++w) place_[w] = graph_.nodes()[w].kind == Kind::variable ? graph_.nodes()[w].a : -1;
  }

  bool is_missing(int node) const { return node >= 0 && place_[static_cast<std::size_t>(node)] < 0; }

  // needed_ ← missing nodes below some of the outputs, in the graph's order.
  [[gnu::cold]] void find_needed(const std::vector<int>& outputs, std::size_t first, std::size_t last) {
    constexpr int on_the_way = -2;
    needed_.clear();
    const auto meet = [&](int node) {
      if (node < 0 || place_[static_cast<std::size_t>(node)] != -1) return;
      place_[static_cast<std::size_t>(node)] = on_the_way;
      needed_.push_back(node);
    };
    for (std::size_t i = first; i < last; ++i) meet(outputs[i]);
    for (std::size_t k = 0; k < needed_.size(); ++k) {
      const auto& node = graph_[needed_[k]];
      if (node.kind == Kind::constant || node.kind == Kind::variable) continue;
      meet(node.a);
      meet(node.b);
    }
    put_in_order(needed_, [](int x, int y) { return x < y; });
  }

  // Leaves those products out of needed_ that are part of another node's line, and marks them.
  [[gnu::cold]] void find_parts(const std::vector<int>& outputs, std::size_t first, std::size_t last) {
    for (const int w : needed_) users_[static_cast<std::size_t>(w)] = 0;
    const auto count = [&](int x) {
      if (is_missing(x)) ++users_[static_cast<std::size_t>(x)];
    };
    for (const int w : needed_) {
      const auto& node = graph_[w];
      if (node.kind == Kind::constant) continue;
      count(node.a);
      count(node.b);
      if (node.kind != Kind::affine || node.b < 0 || decisive(node.c) != 0.0)  // a node that is no sum needs its argument as it is
        for (const int x : {node.a, node.b}) count(x);
    }
    for (std::size_t i = first; i < last; ++i)
      for (int again = 0; again < 2; ++again) count(outputs[i]);
    std::erase_if(needed_, [&](int w) {
      const bool part = is_part(w);
      if (part) place_[static_cast<std::size_t>(w)] = -1;  // a later call may need it
      return part;
    });
  }
  bool is_part(int w) const { return is_missing(w) && graph_[w].kind == Kind::product && users_[static_cast<std::size_t>(w)] == 1; }

  // needed_ level by level. Nodes that were there before are on level 0.
  [[gnu::cold]] void write_levels(LineTable& table) {
    int highest = 0;
    for (const int w : needed_) {
      const auto& node = graph_[w];
      int level = 0;
      const auto comes_after = [&](int x) {
        if (is_missing(x)) level = std::max(level, level_[static_cast<std::size_t>(x)]);
      };
      if (node.kind != Kind::constant) {
        for (const int x : {node.a, node.b})
          if (x >= 0 && node.kind == Kind::affine && is_part(x)) comes_after(graph_[x].a), comes_after(graph_[x].b);
          else comes_after(x);
      }
      level_[static_cast<std::size_t>(w)] = level + 1;
      highest = std::max(highest, level + 1);
    }
    std::vector<std::size_t> begin(static_cast<std::size_t>(highest) + 2, 0);
    for (const int w : needed_) ++begin[static_cast<std::size_t>(level_[static_cast<std::size_t>(w)]) + 1];
    for (std::size_t l = 1; l < begin.size(); ++l) begin[l] += begin[l - 1];
    by_level_.resize(needed_.size());
    std::vector<std::size_t> next = begin;
    for (const int w : needed_) by_level_[next[static_cast<std::size_t>(level_[static_cast<std::size_t>(w)])]++] = w;
    for (std::size_t l = 1; l + 1 < begin.size(); ++l) write_level(begin[l], begin[l + 1], table);
  }

  [[gnu::cold]] void write_level(std::size_t first, std::size_t last, LineTable& table) {
    elements_.clear();
    for (std::size_t k = first; k < last; ++k) elements_.push_back({line_of(by_level_[k]), by_level_[k]});
    sort_elements();
    if (pair_sines_and_cosines()) sort_elements();
    for (std::size_t k = 0; k < elements_.size();) {
      std::size_t end = k + 1;
      while (end < elements_.size() && are_of_one_kind(elements_[end].line, elements_[k].line)) ++end;
      place_elements(k, end);
      write_elements(k, end, table);
      k = end;
    }
  }

  Line line_of(int w) const {
    const auto& node = graph_[w];
    const auto place = [&](int x) { return x < 0 ? std::uint32_t(0) : static_cast<std::uint32_t>(place_[static_cast<std::size_t>(x)]); };
    Line l{Operation::constant, node.function, 0, 0, 0, decisive(node.ca), decisive(node.cb), decisive(node.c)};
    if (node.kind == Kind::constant) return l;
    l.a = place(node.a);
    l.b = node.b < 0 ? l.a : place(node.b);
    switch (node.kind) {
      case Kind::constant:
      case Kind::variable: break;
      case Kind::affine:
        if (node.b >= 0 && (is_part(node.a) || is_part(node.b))) return line_with_products(w);
        if (node.b < 0) l.operation = Operation::scaled;
        else if (l.ca == 1.0 && l.c == 0.0 && l.cb == 1.0) l.operation = Operation::sum;
        else if (l.ca == 1.0 && l.c == 0.0 && l.cb == -1.0) l.operation = Operation::difference;
        else if (l.ca == -1.0 && l.c == 0.0 && l.cb == 1.0) {
          l.operation = Operation::difference;
          std::swap(l.a, l.b);
        } else l.operation = Operation::combination;
        break;
      case Kind::product: l.operation = l.a == l.b ? Operation::square : Operation::product; break;
      case Kind::quotient: l.operation = Operation::quotient; break;
      case Kind::power:
        l.operation = l.c == -1.0 ? Operation::inverse : l.c == 0.5 ? Operation::root : l.c == -0.5 ? Operation::inverse_root : Operation::power;
        break;
      case Kind::function: l.operation = Operation::function; break;
    }
    return l;
  }

  // A sum of two terms of which one or both are products that no other node uses; a product comes first.
  Line line_with_products(int w) const {
    const auto& node = graph_[w];
    const bool turned = !is_part(node.a);
    const int product = turned ? node.b : node.a, other = turned ? node.a : node.b;
    const auto place = [&](int x) { return static_cast<std::uint32_t>(place_[static_cast<std::size_t>(x)]); };
    Line l;
    l.ca = decisive(turned ? node.cb : node.ca);
    l.cb = decisive(turned ? node.ca : node.cb);
    l.a = place(graph_[product].a);
    l.b = place(graph_[product].b);
    const bool two = is_part(other);
    l.d = place(two ? graph_[other].a : other);
    l.e = place(two ? graph_[other].b : other);
    if (two && l.ca == -1.0 && l.cb == 1.0) {
      std::swap(l.a, l.d);
      std::swap(l.b, l.e);
      std::swap(l.ca, l.cb);
    }
    const bool plus = l.ca == 1.0 && l.cb == 1.0, minus = l.ca == 1.0 && l.cb == -1.0, less = l.ca == -1.0 && l.cb == 1.0;
    if (two) l.operation = plus ? Operation::products_sum : minus ? Operation::products_difference : Operation::products_combination;
    else l.operation = plus ? Operation::product_sum : minus ? Operation::product_difference : less ? Operation::less_product : Operation::product_combination;
    return l;
  }

  static int kind_of(const Line& l) { return static_cast<int>(l.operation) * 256 + static_cast<int>(l.function); }
  static bool are_of_one_kind(const Line& x, const Line& y) { return kind_of(x) == kind_of(y) && (x.operation != Operation::power || x.c == y.c); }

  // Alike behind each other, in the order of their arguments' places.
  [[gnu::cold]] void sort_elements() {
    put_in_order(elements_, [](const Element& x, const Element& y) {
      if (const int kx = kind_of(x.line), ky = kind_of(y.line); kx != ky) return kx < ky;
      if (x.line.operation == Operation::power && x.line.c != y.line.c) return x.line.c < y.line.c;
      if (x.line.a != y.line.a) return x.line.a < y.line.a;
      if (x.line.b != y.line.b) return x.line.b < y.line.b;
      if (x.line.d != y.line.d) return x.line.d < y.line.d;
      return x.node < y.node;
    });
  }

  // A sine and a cosine of one angle become one element; one without the other, too, for both cost what one costs. Whether there are any.
  [[gnu::cold]] bool pair_sines_and_cosines() {
    const auto is = [](const Element& e, Function f) { return e.line.operation == Operation::function && e.line.function == f; };
    const auto begin_of = [&](Function f) { return std::find_if(elements_.begin(), elements_.end(), [&](const Element& e) { return is(e, f); }); };
    auto s = begin_of(Function::sin), c = begin_of(Function::cos);
    bool any = false;
    while (true) {
      const bool more_sines = s != elements_.end() && is(*s, Function::sin), more_cosines = c != elements_.end() && is(*c, Function::cos);
      if (!more_sines && !more_cosines) break;
      any = true;
      const bool both = more_sines && more_cosines && s->line.a == c->line.a;
      Element& pair = more_sines && (both || !more_cosines || s->line.a < c->line.a) ? *s++ : *c;
      pair.sine = is(pair, Function::sin) ? pair.node : none;
      pair.cosine = both ? c->node : pair.sine == none ? pair.node : none;
      if (both) c->line.operation = Operation::end;
      if (both || pair.sine == none) ++c;
      pair.line.operation = Operation::sine_and_cosine;
      pair.line.function = Function::none;
    }
    if (any) std::erase_if(elements_, [](const Element& e) { return e.line.operation == Operation::end; });
    return any;
  }

  [[gnu::cold]] void place_elements(std::size_t first, std::size_t last) {
    const auto placed = [&](int node) {
      if (node != none) place_[static_cast<std::size_t>(node)] = static_cast<int>(count_);
      return count_++;
    };
    const bool circular = elements_[first].line.operation == Operation::sine_and_cosine;
    for (std::size_t k = first; k < last; ++k) elements_[k].line.to = placed(circular ? elements_[k].sine : elements_[k].node);
    if (!circular) return;
    for (std::size_t k = first; k < last; ++k) elements_[k].line.b = placed(elements_[k].cosine);
  }

  // Elements of one kind: runs where they are long enough, or one run with lists, or lines.
  [[gnu::cold]] void write_elements(std::size_t first, std::size_t last, LineTable& table) {
    if (elements_[first].line.operation == Operation::constant || last - first < shortest_run_) {
      for (std::size_t k = first; k < last; ++k) table.lines.push_back(elements_[k].line);
      return;
    }
    std::vector<RunOfLines> runs;
    bool short_ones = false;
    for (std::size_t k = first; k < last;) {
      RunOfLines run{elements_[k].line};
      const auto step = [&](std::size_t i, auto place) {
        return static_cast<std::int32_t>(elements_[i].line.*place) - static_cast<std::int32_t>(elements_[i - 1].line.*place);
      };
      std::size_t end = k + 1;
      if (end < last) {
        run.step_a = step(end, &Line::a);
        run.step_b = step(end, &Line::b);
        run.step_d = step(end, &Line::d);
        run.step_e = step(end, &Line::e);
        while (end < last && step(end, &Line::a) == run.step_a && step(end, &Line::b) == run.step_b && step(end, &Line::d) == run.step_d &&
               step(end, &Line::e) == run.step_e)
          ++end;
      }
      run.count = static_cast<std::uint32_t>(end - k);
      short_ones = short_ones || run.count < shortest_run_;
      runs.push_back(run);
      k = end;
    }
    // Short runs cost what runs cost; one list costs two places a line.
    if (short_ones && runs.size() * 2 * shortest_run_ > last - first) {
      runs.clear();
      runs.push_back(RunOfLines{elements_[first].line});
      runs[0].count = static_cast<std::uint32_t>(last - first);
      runs[0].places = static_cast<std::int64_t>(table.places.size());
      for (std::size_t k = first; k < last; ++k) {
        const Line& l = elements_[k].line;
        const auto add = [&](std::uint32_t place) { table.places.push_back(place); };
        add(l.a), add(l.operation == Operation::sine_and_cosine ? l.a : l.b);
        if (has_products(l.operation)) add(l.d), add(l.e);
      }
    }
    std::size_t k = first;
    for (RunOfLines& run : runs) {
      add_factors(k, run, table);
      table.lines.push_back({Operation::run, Function::none, 0, static_cast<std::uint32_t>(table.runs.size()), 0});
      table.runs.push_back(run);
      k += run.count;
    }
  }

  [[gnu::cold]] void add_factors(std::size_t first, RunOfLines& run, LineTable& table) {
    const Operation o = run.first.operation;
    if (o != Operation::scaled && o != Operation::combination && o != Operation::product_combination && o != Operation::products_combination) return;
    bool alike = true;
    for (std::size_t k = first; k < first + run.count; ++k) {
      const Line &l = elements_[k].line, &other = run.first;
      alike = alike && l.ca == other.ca && l.cb == other.cb && l.c == other.c;
    }
    if (alike) return;
    run.factors = static_cast<std::int64_t>(table.factors.size());
    for (std::size_t k = first; k < first + run.count; ++k) {
      const Line& l = elements_[k].line;
      for (const double factor : {l.ca, l.cb, l.c}) table.factors.push_back(factor);
    }
  }

  const BasicGraph<Coefficient>& graph_;
  std::size_t shortest_run_;
  std::vector<int> place_;  // of each node; −1 where it has none
  std::vector<int> level_, needed_, by_level_;
  std::vector<int> users_;  // of each needed node: how many sums have it, and two for each other user
  std::vector<Element> elements_;
  std::uint32_t count_;
};

}  // namespace qdot::formula
