#pragma once
// SPDX-License-Identifier: MIT
//
// J and γ of many constraints, each of which touches few coordinates.
//
// The constraints of a scene are evaluated once, on a tape (ad/reverse.hpp), on numbers with a derivative along the motion. From the result of
// each row a sweep goes back through the operations that made it, and through no others, so that a row costs what it is made of, however many
// coordinates and other rows there are: a chain of a thousand rods costs a thousand times one rod. The sweep brings ∂φ/∂q, ∂φ/∂t and their rates
// along (q̇, 1), hence
//
//     γ = −(J̇ q̇ + d/dt ∂φ/∂t) .
//
// Nothing is kept from one evaluation to the next; a functor may take another branch and touch other coordinates.

#include <cstddef>
#include <type_traits>
#include <vector>

#include "qdot/ad/reverse.hpp"
#include "qdot/effects/constraint_rows.hpp"

namespace qdot::detail {

struct OfRows {};  // marks numbers on the tape of constraints
template <>
inline constexpr bool tape_sees_meetings<Dual<double, 1, OfRows>> = false;

// The entries of a matrix that may be other than zero, row by row.
struct SparseRows {
  struct Entry {
    int column;
    double value;
  };
  std::vector<Entry> entries;
  std::vector<std::size_t> ends;  // of the rows, among the entries

  std::size_t size() const { return ends.size(); }
  const Entry* begin(std::size_t row) const { return entries.data() + (row == 0 ? 0 : ends[row - 1]); }
  const Entry* end(std::size_t row) const { return entries.data() + ends[row]; }
};

// J and γ of a scene's constraints, empty rows and zeros for those that are not active; false when a number of rows is not what the scene has
// counted, or a derivative is not finite.
template <class Sc, class Phases>
bool write_sparse_rows(const Sc& scene, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, double t, const Phases& z, SparseRows& J,
                       Eigen::VectorXd& gamma) {
  using N = Dual<double, 1, OfRows>;
  using S = Reverse<N>;
  const Eigen::Index n = q.size();
  Tape<N> tape;
  tape.nodes.reserve(static_cast<std::size_t>(8 * n));
  for (Eigen::Index i = 0; i <= n; ++i) tape.variable(static_cast<int>(i));  // q or q̇, and t
  const N time = N::variable(t, 0);
  Vector<S, Dynamic> x(n), v(0);
  J.entries.clear();
  J.ends.clear();
  std::vector<double> right;
  std::vector<int> waiting;
  std::vector<N> adjoint;
  std::vector<std::size_t> place(static_cast<std::size_t>(n));  // of a column's latest entry, to be believed when there it is
  double zero = 0.0;
  bool counted_right = true;
  std::size_t k = 0;
  for_each_constraint(scene, z, [&](const auto& e, bool active) {
    using E = std::remove_cvref_t<decltype(e)>;
    constexpr bool holonomic = HolonomicEffect<E, Dynamic>;
    const Eigen::Index counted = rows_of_constraint<E>(scene, k++);
    if (!active) {
      J.ends.resize(J.ends.size() + static_cast<std::size_t>(counted), J.entries.size());
      right.resize(J.ends.size(), 0.0);
      return;
    }
    for (Eigen::Index i = 0; i < n; ++i) {
      x[i].value.value = q[i];
      x[i].value.tangent[0] = qdot[i];
      x[i].node = holonomic ? static_cast<int>(i) : -1;
      x[i].tape = &tape;
    }
    const auto rows = [&] {
      if constexpr (holonomic) {
        return as_rows(e.phi(x, S(time, static_cast<int>(n), &tape)));
      } else {
        v.resize(n);
        for (Eigen::Index i = 0; i < n; ++i) v[i] = S(N(qdot[i]), static_cast<int>(i), &tape);
        return as_rows(e.velocity_constraint(x, v, S(time)));
      }
    }();
    counted_right = counted_right && rows.size() == counted;
    for (Eigen::Index i = 0; i < rows.size(); ++i) {
      double rate = holonomic ? 0.0 : rows[i].value.tangent[0];
      const std::size_t first = J.entries.size();
      tape.for_each_derivative(rows[i].node, static_cast<int>(n) + 1, waiting, adjoint, [&](int column, const N& share) {
        if (holonomic) rate += column < n ? share.tangent[0] * qdot[column] : share.tangent[0];
        zero += share.value - share.value;
        if (column == n) return;
        std::size_t& at = place[static_cast<std::size_t>(column)];
        if (at >= first && at < J.entries.size() && J.entries[at].column == column) {
          J.entries[at].value += share.value;
        } else {
          at = J.entries.size();
          J.entries.push_back({column, share.value});
        }
      });
      J.ends.push_back(J.entries.size());
      right.push_back(-rate);
    }
  });
  gamma = Eigen::Map<const Eigen::VectorXd>(right.data(), static_cast<Eigen::Index>(right.size()));
  return counted_right && zero == 0.0;
}

}  // namespace qdot::detail
