#pragma once
// SPDX-License-Identifier: MIT
//
// q̈ by formulas that the compiler has derived.
//
// A derivation (mechanics/derive/derived_equations.hpp) ends with nodes of a graph. Those that q̈ needs are numbered here, and become a
// constant of the program: a list of lines x_i = x_a x_b, x_i = α x_a + β x_b + γ, x_i = sin x_a, …, in which letters are places of a table.
// mechanics/derive/closed_form_evaluation.hpp makes code of it.

#include <cstddef>
#include <type_traits>
#include <vector>

#include "qdot/ad/formula/constant_where_possible.hpp"
#include "qdot/ad/formula/list_graph.hpp"
#include "qdot/mechanics/derive/by_graph.hpp"
#include "qdot/mechanics/derive/by_terms.hpp"

namespace qdot::detail {

/// A coefficient of a line of code: a literal, or a place in the object's table.
struct CoefficientUse {
  double literal = 0.0;
  int line = -1;

  constexpr CoefficientUse() = default;
  constexpr CoefficientUse(const formula::Coefficient& c) : literal(c.is_literal() ? c.shadow : 0.0), line(c.line) {}
  constexpr bool is(double number) const { return line < 0 && literal == number; }
  friend constexpr bool operator==(const CoefficientUse&, const CoefficientUse&) = default;
};

/// One line of code. Arguments are earlier lines.
struct ClosedFormLine {
  formula::Kind kind = formula::Kind::constant;
  formula::Function function = formula::Function::none;
  int a = -1, b = -1;
  CoefficientUse ca, cb, c;
  formula::Domain domain = formula::Domain::everything;  // outside of which T or V has no value
};

struct ClosedFormExtent {
  int lines = 0, coefficients = 0, eliminated = 0, factors = 0, kept = 0;
  bool exists = false;
  friend constexpr bool operator==(const ClosedFormExtent&, const ClosedFormExtent&) = default;
  constexpr bool fits_in(const ClosedFormExtent& room) const {
    return lines <= room.lines && coefficients <= room.coefficients && eliminated <= room.eliminated && factors <= room.factors && kept <= room.kept;
  }
};

/// A coordinate whose acceleration is eliminated: numbers of lines, and factors first … last − 1.
struct EliminatedCoordinate {
  int coordinate = 0, pivot = 0, acceleration = 0, first = 0, last = 0;
  CoefficientUse pivot_factor;  // the pivot is this, or this times functions of the position
  bool has_constant_pivot = false;
};

/// All of it, with room for what the extent says.
template <ClosedFormExtent extent>
struct ClosedForm {
  static constexpr ClosedFormExtent size = extent;

  ClosedFormLine line[extent.lines + 1] = {};
  formula::CoefficientStep coefficient[extent.coefficients + 1] = {};
  EliminatedCoordinate eliminated[extent.eliminated + 1] = {};
  int factor[extent.factors + 1] = {}, coordinate[extent.factors + 1] = {};
  int kept[extent.kept + 1] = {}, right[extent.kept + 1] = {}, diagonal[extent.kept + 1] = {};
  int mass[extent.kept * (extent.kept + 1) / 2 + 1] = {};
};

/// The energies of a written-out class as nodes. Parameters of V are counted after those of T.
template <int n, const auto& list_T, const auto& list_V>
struct ListedEnergies {
  static constexpr int parameters_of_T = static_cast<int>(sizeof(list_T.value) / sizeof(double));

  static constexpr int node_of_T(DerivedEquations::Graph& graph, formula::CoefficientBook& book, bool& is_known) {
    return node_of(list_T, 0, graph, book, is_known);
  }
  static constexpr int node_of_V(DerivedEquations::Graph& graph, formula::CoefficientBook& book, bool& is_known) {
    return node_of(list_V, parameters_of_T, graph, book, is_known);
  }

 private:
  template <class List>
  static constexpr int node_of(const List& list, int first, DerivedEquations::Graph& graph, formula::CoefficientBook& book, bool& is_known) {
    return formula::node_of_list(graph, list, 2 * n + 1, is_known, [&](int k) -> formula::Coefficient {
      if (list.literal[k]) return list.value[k];
      return book.parameter(first + list.same_as[k], formula::shadow_of(first + list.same_as[k]));
    });
  }
};

// Two ways to derive: `use` is called with the derivation and what is wanted of it, DerivedEquations or DerivedJacobian.
template <int n, class Energies>
struct ByTerms {
  template <class Wanted, class Use>
  static constexpr void derive(const Use& use) {
    DerivationByTerms d(n);
    const int T = Energies::node_of_T(d.graph, d.book, d.is_possible);
    const int V = Energies::node_of_V(d.graph, d.book, d.is_possible);
    const Wanted wanted = [&] {
      if constexpr (std::is_same_v<Wanted, DerivedJacobian>) return d.jacobian_by_terms(T, V);
      else return d.equations_by_terms(T, V);
    }();
    if (d.is_possible) use(d, wanted);
  }
};
template <int n, class Energies>
struct ByGraph {
  template <class Wanted, class Use>
  static constexpr void derive(const Use& use) {
    constexpr const auto& stage = last_graph_stage<n, Energies>();
    if constexpr (stage.is_possible) {
      DerivationByGraph<n> d(stage);
      const Wanted wanted = [&] {
        if constexpr (std::is_same_v<Wanted, DerivedJacobian>) return d.jacobian(stage);
        else return d.equations(stage);
      }();
      use(d, wanted);
    }
  }
};

// Numbers of the nodes that `outputs` need, −1 for the others.
constexpr std::vector<int> lines_of(const DerivedEquations::Graph& graph, const std::vector<int>& outputs, int& count) {
  const std::vector<char> needed = graph.needed_for(outputs);
  std::vector<int> line(needed.size(), -1);
  count = 0;
  for (std::size_t w = 0; w < needed.size(); ++w)
    if (needed[w] != 0) line[w] = count++;
  return line;
}

// All that q̈ is made of.
constexpr std::vector<int> outputs_of(const DerivedEquations& e) {
  std::vector<int> outputs;
  for (const auto& step : e.eliminated) {
    outputs.push_back(step.pivot);
    outputs.push_back(step.acceleration);
    for (const int factor : step.factors) outputs.push_back(factor);
  }
  for (const int node : e.mass) outputs.push_back(node);
  for (const int node : e.right) outputs.push_back(node);
  for (const int node : e.diagonal) outputs.push_back(node);
  return outputs;
}

// Lines and coefficients of a form.
template <class Derivation, class Form>
constexpr void write_form_lines(const Derivation& d, const std::vector<int>& line, Form& form) {
  const auto& nodes = d.graph.nodes();
  const auto line_of = [&line](int node) { return node < 0 ? -1 : line[static_cast<std::size_t>(node)]; };
  for (std::size_t w = 0; w < nodes.size(); ++w) {
    if (line[w] < 0) continue;
    const auto& node = nodes[w];
    const bool is_input = node.kind == formula::Kind::variable;
    form.line[line[w]] = {node.kind, node.function, is_input ? node.a : line_of(node.a), is_input ? -1 : line_of(node.b), node.ca, node.cb, node.c};
  }
  for (std::size_t k = 0; k < d.book.steps().size(); ++k) form.coefficient[k] = d.book.steps()[k];
}

/// A form as it was derived, in a table with room to spare, and how much of it there is. What does not fit is left out.
template <class Form>
struct Draft {
  std::remove_cvref_t<decltype(Form::size)> extent{};
  Form form{};
};

template <class Way, ClosedFormExtent room>
constexpr Draft<ClosedForm<room>> closed_form_draft() {
  Draft<ClosedForm<room>> draft;
  Way::template derive<DerivedEquations>([&draft](const auto& d, const DerivedEquations& e) {
    auto& [extent, form] = draft;
    const std::vector<int> outputs = outputs_of(e);
    const std::vector<formula::Domain> domains = domains_to_check(d.graph, outputs);
    const std::vector<int> line = lines_of(d.graph, with_checked(outputs, domains), extent.lines);
    extent.coefficients = static_cast<int>(d.book.steps().size());
    extent.eliminated = static_cast<int>(e.eliminated.size());
    for (const auto& step : e.eliminated) extent.factors += static_cast<int>(step.factors.size());
    extent.kept = static_cast<int>(e.kept.size());
    extent.exists = true;
    if (!extent.fits_in(room)) return;
    const auto line_of = [&](int node) { return node < 0 ? -1 : line[static_cast<std::size_t>(node)]; };
    write_form_lines(d, line, form);
    for (std::size_t w = 0; w < domains.size(); ++w)
      if (line[w] >= 0) form.line[line[w]].domain = domains[w];
    const auto& nodes = d.graph.nodes();
    int factors = 0, steps = 0;
    for (const auto& step : e.eliminated) {
      auto& to = form.eliminated[steps++];
      const auto& pivot = nodes[static_cast<std::size_t>(step.pivot)];
      to = {step.coordinate, line_of(step.pivot), line_of(step.acceleration), factors, factors + static_cast<int>(step.factors.size()), {}, false};
      to.has_constant_pivot = pivot.kind == formula::Kind::constant;
      to.pivot_factor = to.has_constant_pivot ? pivot.c : pivot.kind == formula::Kind::affine && pivot.b < 0 ? pivot.ca : formula::Coefficient(1.0);
      for (std::size_t i = 0; i < step.factors.size(); ++i) {
        form.factor[factors] = line_of(step.factors[i]);
        form.coordinate[factors++] = step.coordinates[i];
      }
    }
    for (std::size_t i = 0; i < e.kept.size(); ++i) {
      form.kept[i] = e.kept[i];
      form.right[i] = line_of(e.right[i]);
      form.diagonal[i] = line_of(e.diagonal[i]);
    }
    for (std::size_t i = 0; i < e.mass.size(); ++i) form.mass[i] = line_of(e.mass[i]);
  });
  return draft;
}

// A compiler that derives first to count and then to write works twice: it writes into a table that has room for almost every form.
inline constexpr ClosedFormExtent closed_form_room{.lines = 800, .coefficients = 400, .eliminated = 32, .factors = 400, .kept = 32};

// A compiler stops after a number of operations, and may not be able to derive at all.
template <class Way>
inline constexpr auto& draft_of_way = formula::made_where_possible<&closed_form_draft<Way, closed_form_room>>;

template <class T, std::size_t room, std::size_t count>
constexpr void copy_front(const T (&from)[room], T (&to)[count]) {
  for (std::size_t i = 0; i < count; ++i) to[i] = from[i];
}

template <class Way, ClosedFormExtent extent>
constexpr ClosedForm<extent> closed_form_of() {
  if constexpr (extent.fits_in(closed_form_room)) {
    constexpr const auto& draft = draft_of_way<Way>.form;
    ClosedForm<extent> form;
    copy_front(draft.line, form.line);
    copy_front(draft.coefficient, form.coefficient);
    copy_front(draft.eliminated, form.eliminated);
    copy_front(draft.factor, form.factor);
    copy_front(draft.coordinate, form.coordinate);
    copy_front(draft.kept, form.kept);
    copy_front(draft.right, form.right);
    copy_front(draft.diagonal, form.diagonal);
    copy_front(draft.mass, form.mass);
    return form;
  } else {
    return closed_form_draft<Way, extent>().form;
  }
}

// Whether T is nothing but products of rates (mechanics/derive/coriolis_terms.hpp).
template <int n, class Energies>
constexpr bool is_all_rates() {
  DerivedEquations::Graph graph;
  formula::CoefficientBook book;
  bool is_known = true;
  for (int i = 0; i < 2 * n + 1; ++i) graph.variable(i);
  const int T = Energies::node_of_T(graph, book, is_known);
  RatesOfNodes<DerivedEquations::Graph> rates(graph, n);
  return is_known && CoriolisTerms<DerivedEquations::Graph>(rates, n).is_all(T);
}

// T is multiplied out where that leaves less, which is so of up to three coordinates, and of velocities in polar and spherical coordinates. Of
// chains of four links and more the graph has as few operations, and takes half as long to derive.
template <int n, class Energies>
struct WayToDerive {
  static constexpr auto chosen() {
    if constexpr (n <= 3 || (n <= by_terms_limit && !formula::made_where_possible<&is_all_rates<n, Energies>>)) {
      if constexpr (draft_of_way<ByTerms<n, Energies>>.extent.exists) {
        return std::type_identity<ByTerms<n, Energies>>{};
      } else {
        return std::type_identity<ByGraph<n, Energies>>{};
      }
    } else {
      return std::type_identity<ByGraph<n, Energies>>{};
    }
  }
  using type = typename decltype(chosen())::type;
};

/// The closed form of the energies that two lists are.
template <int n, const auto& list_T, const auto& list_V>
struct ClosedFormOfLists {
  using Energies = ListedEnergies<n, list_T, list_V>;
  using Way = typename WayToDerive<n, Energies>::type;
  static constexpr ClosedFormExtent extent = draft_of_way<Way>.extent;
  static constexpr bool exists = extent.exists;
  static constexpr int coefficients = extent.coefficients;
  static constexpr ClosedForm<extent> form = closed_form_of<Way, extent>();
};

}  // namespace qdot::detail
