#pragma once
// SPDX-License-Identifier: MIT
//
// ∂q̈/∂(q, q̇) by formulas that the compiler has derived.
//
// The equations of motion in closed form are r(q, q̇) = M(q) q̈, and by the implicit function theorem
//
//     ∂q̈/∂(q, q̇) = M⁻¹ ∂(r − M a)/∂(q, q̇)      at fixed a = q̈ .
//
// The compiler has r and M as formulas (mechanics/derivation_by_terms.hpp) and differentiates them row by row, each with one walk back. M is factored
// once more, with 2n columns beside it.

#include <type_traits>
#include <vector>

#include "qdot/mechanics/closed_form_evaluation.hpp"
#include "qdot/mechanics/straight_line_jacobian.hpp"

namespace qdot::detail {

struct ClosedJacobianExtent {
  int lines = 0, coefficients = 0;
  bool exists = false;
};

/// Lines of code, and which of them are M and the derivatives of r − M a.
template <int n, ClosedJacobianExtent extent>
struct ClosedJacobian {
  static constexpr ClosedJacobianExtent size = extent;
  ClosedFormLine line[extent.lines + 1] = {};
  taylor::CoefficientStep coefficient[extent.coefficients + 1] = {};
  int mass[n * (n + 1) / 2] = {}, slope[n * 2 * n] = {};
};

template <int n, class Energies, class Use>
constexpr void derive_jacobian(const Use& use) {
  DerivationByTerms d(n);
  const int T = Energies::node_of_T(d.graph, d.book, d.is_possible);
  const int V = Energies::node_of_V(d.graph, d.book, d.is_possible);
  const DerivedJacobian jacobian = d.jacobian_by_terms(T, V);
  if (!d.is_possible) return;
  std::vector<int> outputs = jacobian.mass;
  for (const int slope : jacobian.slopes) outputs.push_back(slope);
  use(d, jacobian, outputs);
}

template <int n, class Energies>
constexpr ClosedJacobianExtent closed_jacobian_extent() {
  ClosedJacobianExtent extent;
  derive_jacobian<n, Energies>([&extent](const auto& d, const DerivedJacobian&, const std::vector<int>& outputs) {
    lines_of(d.graph, outputs, extent.lines);
    extent.coefficients = static_cast<int>(d.book.steps().size());
    extent.exists = true;
  });
  return extent;
}

template <int n, class Energies, ClosedJacobianExtent extent>
constexpr ClosedJacobian<n, extent> closed_jacobian_of() {
  ClosedJacobian<n, extent> form;
  if (!extent.exists) return form;
  derive_jacobian<n, Energies>([&form](const auto& d, const DerivedJacobian& jacobian, const std::vector<int>& outputs) {
    int count = 0;
    const std::vector<int> line = lines_of(d.graph, outputs, count);
    write_form_lines(d, line, form);
    for (std::size_t k = 0; k < jacobian.mass.size(); ++k) form.mass[k] = jacobian.mass[k] < 0 ? -1 : line[static_cast<std::size_t>(jacobian.mass[k])];
    for (std::size_t k = 0; k < jacobian.slopes.size(); ++k) form.slope[k] = jacobian.slopes[k] < 0 ? -1 : line[static_cast<std::size_t>(jacobian.slopes[k])];
  });
  return form;
}

template <int n, class Energies>
concept JacobianDerivable = requires { typename std::bool_constant<closed_jacobian_extent<n, Energies>().exists>; };


/// The Jacobian's form of the energies of a closed form; `exists` is false where there is none.
template <int n, class Energies>
struct ClosedJacobianOf {
  static constexpr ClosedJacobianExtent extent = [] {
    if constexpr (n >= 1 && n <= by_terms_limit) {
      if constexpr (JacobianDerivable<n, Energies>) return closed_jacobian_extent<n, Energies>();
    }
    return ClosedJacobianExtent{};
  }();
  static constexpr bool exists = extent.exists;
  static constexpr int coefficients = extent.coefficients;
  static constexpr ClosedJacobian<n, extent> form = closed_jacobian_of<n, Energies, extent>();
};

/// M, the packed lower triangle, and the derivatives of r − M a at accelerations a, n rows of which the first 2n entries are written.
template <int n, class Form, class Row>
[[gnu::flatten]] inline void closed_form_slopes(const double* c, const double* q, const double* qdot, double t, const double* a, double* M, Row* rows) {
  constexpr const auto& form = Form::form;
  double x[form.size.lines + 1];
  write_lines<n, Form>(c, q, qdot, t, a, x);
  unroll<n*(n + 1) / 2>([&](auto k) __attribute__((always_inline)) {
    constexpr int node = form.mass[k];
    M[k] = node < 0 ? 0.0 : x[node < 0 ? 0 : node];
  });
  unroll<n>([&](auto i) __attribute__((always_inline)) {
    unroll<2 * n>([&](auto j) __attribute__((always_inline)) {
      constexpr int node = form.slope[2 * n * i + j];
      rows[i][j] = node < 0 ? 0.0 : x[node < 0 ? 0 : node];
    });
  });
}

/// ∂q̈/∂q and ∂q̈/∂q̇ by columns, at accelerations a that are known; false when this is not the way.
template <int n, class Form>
[[gnu::flatten, gnu::noinline]] bool closed_form_jacobian(const double* c, const double* q, const double* qdot, double t, const double* a, double* d_q,
                                                          double* d_qdot) {
  double M[n * (n + 1) / 2];
  SlopeRow<2 * n> rows[n];
  closed_form_slopes<n, Form>(c, q, qdot, t, a, M, rows);
  return solved_in_place<n>(M, rows, singular_pivot<double>(n)) & columns_written<n>(rows, d_q, d_qdot);
}

}  // namespace qdot::detail
