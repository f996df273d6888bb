#pragma once
// SPDX-License-Identifier: MIT
//
// M, r and ∂q̈/∂(q, q̇) by formulas that the compiler has derived.
//
// The equations of motion in closed form are r(q, q̇) = M(q) q̈, no coordinate eliminated: what forces, constraints and impacts go on with
// (mechanics/mass_and_rhs.hpp). By the implicit function theorem
//
//     ∂q̈/∂(q, q̇) = M⁻¹ ∂(r − M a)/∂(q, q̇)      at fixed a = q̈ .
//
// The compiler has r and M as formulas (mechanics/derive/by_terms.hpp) and differentiates them row by row, each with one walk back. The lines
// that M and r need come first, then q̈ is solved for, then come the lines of the derivatives; M is factored once more, with 2n columns beside it.

#include <type_traits>
#include <vector>

#include "qdot/mechanics/derive/closed_form_evaluation.hpp"
#include "qdot/mechanics/equations/straight_line_jacobian.hpp"

namespace qdot::detail {

struct ClosedJacobianExtent {
  int lines = 0, coefficients = 0;
  int equations = 0;  // lines for M and r
  bool exists = false;
  constexpr bool fits_in(const ClosedJacobianExtent& room) const { return lines <= room.lines && coefficients <= room.coefficients; }
};

/// Lines of code, and which of them are M, r and the derivatives of r − M a.
template <int n, ClosedJacobianExtent extent>
struct ClosedJacobian {
  static constexpr ClosedJacobianExtent size = extent;
  ClosedFormLine line[extent.lines + 1] = {};
  formula::CoefficientStep coefficient[extent.coefficients + 1] = {};
  int mass[n * (n + 1) / 2] = {}, right[n] = {}, slope[n * 2 * n] = {};
};

// Calls `use` with the derivation, what it has derived, the nodes that M and r need, and these and the others.
template <int n, class Energies, class Use>
constexpr void derive_jacobian(const Use& use) {
  WayToDerive<n, Energies>::type::template derive<DerivedJacobian>([&use](const auto& d, const DerivedJacobian& jacobian) {
    std::vector<int> equations = jacobian.mass;
    for (const int node : jacobian.right) equations.push_back(node);
    const std::vector<formula::Domain> domains = domains_to_check(d.graph, equations);
    equations = with_checked(equations, domains);
    std::vector<int> all = equations;
    for (const int slope : jacobian.slopes) all.push_back(slope);
    use(d, jacobian, domains, equations, all);
  });
}

template <int n, class Energies, ClosedJacobianExtent room>
constexpr Draft<ClosedJacobian<n, room>> closed_jacobian_draft() {
  Draft<ClosedJacobian<n, room>> draft;
  derive_jacobian<n, Energies>(
      [&draft](const auto& d, const DerivedJacobian& jacobian, const auto& domains, const std::vector<int>& equations, const std::vector<int>& all) {
        auto& [extent, form] = draft;
        const std::vector<int> line = lines_of(d.graph, all, extent.lines);
        for (const int node : equations)
          if (node >= 0 && line[static_cast<std::size_t>(node)] >= extent.equations) extent.equations = line[static_cast<std::size_t>(node)] + 1;
        extent.coefficients = static_cast<int>(d.book.steps().size());
        extent.exists = true;
        if (!extent.fits_in(room)) return;
        write_form_lines(d, line, form);
        for (std::size_t w = 0; w < domains.size(); ++w)
          if (line[w] >= 0) form.line[line[w]].domain = domains[w];
        const auto copy = [&line](const std::vector<int>& nodes, int* lines) {
          for (std::size_t k = 0; k < nodes.size(); ++k) lines[k] = nodes[k] < 0 ? -1 : line[static_cast<std::size_t>(nodes[k])];
        };
        copy(jacobian.mass, form.mass);
        copy(jacobian.right, form.right);
        copy(jacobian.slopes, form.slope);
      });
  return draft;
}

inline constexpr ClosedJacobianExtent closed_jacobian_room{.lines = 2000, .coefficients = 800};

template <int n>
using JacobianDraft = Draft<ClosedJacobian<n, closed_jacobian_room>>;

template <int n, class Energies, ClosedJacobianExtent extent>
constexpr ClosedJacobian<n, extent> closed_jacobian_of(const JacobianDraft<n>& draft) {
  if constexpr (extent.fits_in(closed_jacobian_room)) {
    ClosedJacobian<n, extent> form;
    copy_front(draft.form.line, form.line);
    copy_front(draft.form.coefficient, form.coefficient);
    copy_front(draft.form.mass, form.mass);
    copy_front(draft.form.right, form.right);
    copy_front(draft.form.slope, form.slope);
    return form;
  } else {
    return closed_jacobian_draft<n, Energies, extent>().form;
  }
}

/// The Jacobian's form of the energies of a closed form; `exists` is false where there is none.
template <int n, class Energies>
class ClosedJacobianOf {
  static constexpr JacobianDraft<n> draft = [] {
    if constexpr (n >= 1 && n <= by_terms_limit) return formula::made_where_possible<&closed_jacobian_draft<n, Energies, closed_jacobian_room>>;
    else return JacobianDraft<n>{};
  }();

 public:
  static constexpr ClosedJacobianExtent extent = draft.extent;
  static constexpr bool exists = extent.exists;
  static constexpr int coefficients = extent.coefficients;
  static constexpr ClosedJacobian<n, extent> form = closed_jacobian_of<n, Energies, extent>(draft);
};

// Entries of M that are not always zero.
template <int n, class Form>
inline constexpr ComponentMask entries_of_mass_matrix = [] {
  ComponentMask mask = 0;
  for (int k = 0; k < n * (n + 1) / 2; ++k)
    if (Form::form.mass[k] >= 0) mask |= ComponentMask(1) << k;
  return mask;
}();

// M, the packed lower triangle, as it stands in the lines x.
template <int n, class Form>
[[gnu::always_inline]] inline void write_mass_matrix(const double* x, double* M) {
  unroll<n*(n + 1) / 2>([&](auto k) __attribute__((always_inline)) {
    constexpr int node = Form::form.mass[k];
    M[k] = node < 0 ? 0.0 : x[node < 0 ? 0 : node];
  });
}

// The derivatives of r − M a, n rows of which the first 2n entries are written.
template <int n, class Form, class Row>
[[gnu::always_inline]] inline void write_slopes(const double* x, Row* rows) {
  unroll<n>([&](auto i) __attribute__((always_inline)) {
    unroll<2 * n>([&](auto j) __attribute__((always_inline)) {
      constexpr int node = Form::form.slope[2 * n * i + j];
      rows[i][j] = node < 0 ? 0.0 : x[node < 0 ? 0 : node];
    });
  });
}

/// Calls `use` with M, r and the entries of M that are not always zero (mass_and_rhs.hpp); false where T or V has no value, and where `use` says so.
template <int n, class Form, class Use>
[[gnu::flatten]] inline bool closed_form_equations(const double* c, const AtState& at, const Use& use) {
  constexpr const auto& form = Form::form;
  double x[form.size.equations + 1], M[n * (n + 1) / 2], r[n];
  write_lines<n, Form, 0, form.size.equations>(c, at.q, at.qdot, at.t, at.q, x);
  if (!have_values<Form, form.size.equations>(x)) return false;
  unroll<n>([&](auto i) __attribute__((always_inline)) { r[i] = x[form.right[i]]; });
  write_mass_matrix<n, Form>(x, M);
  return use.packed(at, M, r, entries_of_mass_matrix<n, Form>);
}

/// M, the packed lower triangle, and the derivatives of r − M a at accelerations a, n rows of which the first 2n entries are written.
template <int n, class Form, class Row>
[[gnu::flatten]] inline void closed_form_slopes(const double* c, const double* q, const double* qdot, double t, const double* a, double* M, Row* rows) {
  double x[Form::form.size.lines + 1];
  write_lines<n, Form, 0, Form::form.size.lines>(c, q, qdot, t, a, x);
  write_mass_matrix<n, Form>(x, M);
  write_slopes<n, Form>(x, rows);
}

/// q̈, and ∂q̈/∂q and ∂q̈/∂q̇ by columns; false when this is not the way. All in one function: the sines of M and r are those of their derivatives.
template <int n, class Form>
[[gnu::flatten, gnu::noinline]] bool closed_form_jacobian(const double* c, const double* q, const double* qdot, double t, double* qddot, double* d_q,
                                                          double* d_qdot) {
  constexpr const auto& form = Form::form;
  constexpr int equations = form.size.equations;
  double x[form.size.lines + 1], M[n * (n + 1) / 2], factors[n * (n + 1) / 2], a[n];
  SlopeRow<2 * n> rows[n];
  write_lines<n, Form, 0, equations>(c, q, qdot, t, q, x);
  bool good = have_values<Form, equations>(x);
  unroll<n>([&](auto i) __attribute__((always_inline)) { a[i] = x[form.right[i]]; });
  write_mass_matrix<n, Form>(x, factors);
  write_mass_matrix<n, Form>(x, M);
  good &= solved_in_place<n>(factors, a, singular_pivot<double>(n), entries_of_mass_matrix<n, Form>);
  write_lines<n, Form, equations, form.size.lines>(c, q, qdot, t, a, x);
  write_slopes<n, Form>(x, rows);
  solved_in_place<n>(M, rows, 0.0, entries_of_mass_matrix<n, Form>);
  unroll<n>([&](auto i) __attribute__((always_inline)) { qddot[i] = a[i]; });
  double sum = -0.0;
  unroll<n>([&](auto i) __attribute__((always_inline)) {
    sum += a[i];
    unroll<n>([&](auto j) __attribute__((always_inline)) {
      d_q[i + n * j] = rows[i][j];
      d_qdot[i + n * j] = rows[i][n + j];
      sum += rows[i][j] + rows[i][n + j];
    });
  });
  return good && is_finite(sum);
}

}  // namespace qdot::detail
