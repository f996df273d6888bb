#pragma once
// SPDX-License-Identifier: MIT
//
// J of many constraints, each of which touches few coordinates.
//
// The constraints of a scene are evaluated once, on a tape (ad/records/reverse.hpp). From the result of each row a sweep goes back through the operations
// that made it, and through no others. So the cost of a row does not depend on how many coordinates and other rows there are: a chain of a thousand rods
// costs a thousand times one rod. γ comes from numbers that move, as everywhere (effects/rows/constraint_rows.hpp).
//
// Nothing is kept from one evaluation to the next; a functor may take another branch and touch other coordinates.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "qdot/ad/records/reverse.hpp"
#include "qdot/effects/rows/constraint_rows.hpp"

namespace qdot::detail {

// The sweep back from one number after another: visit(variable, share) for each way from it to a variable, through the operations that it depends on.
class SweepOfRows {
 public:
  explicit SweepOfRows(const Tape<double>& tape) : tape_(tape) {}

  template <class Visit>
  void operator()(const Reverse<double>& x, Visit&& visit) {
    if (adjoint_.size() < tape_.operations.size()) adjoint_.resize(tape_.operations.size());
    if (!x.tape) return;
    near_ = 0;
    k_ = x.node;
    pass(x.node, x.slope, visit);
    while (near_ != 0 || !far_.empty()) {
      int back = std::countl_zero(near_);  // 64 where there is none
      if (!far_.empty() && (near_ == 0 || far_.back() > k_ - back)) {
        back = k_ - far_.back();
        far_.pop_back();
      }
      near_ = near_ == 0 ? 0 : (near_ << back) & ~here;
      k_ -= back;
      const auto& made = tape_.operation(k_);
      const double share = so_far(k_);
      pass(made.a, share * made.along_a, visit);
      pass(made.b, share * made.along_b, visit);
    }
  }

 private:
  static constexpr std::uint64_t here = std::uint64_t(1) << 63;

  template <class Visit>
  [[gnu::always_inline]] void pass(int node, double share, Visit&& visit) {
    if (node < tape_.variables) return visit(node, share);
    double& sum = so_far(node);
    const std::uint64_t bit = k_ - node < 64 ? here >> (k_ - node) : 0;
    if ((near_ & bit) != 0) {
      sum += share;
    } else if (bit != 0 && far_.empty()) {
      sum = share;
      near_ |= bit;
    } else {
      pass_far(node, bit, sum, share);
    }
  }
  [[gnu::noinline]] void pass_far(int node, std::uint64_t bit, double& sum, double share) {
    std::size_t at = far_.size();
    while (at > 0 && far_[at - 1] > node) --at;
    if (at > 0 && far_[at - 1] == node) {
      sum += share;
      return;
    }
    sum = share;
    near_ |= bit;
    if (bit == 0) far_.insert(far_.begin() + static_cast<std::ptrdiff_t>(at), node);
  }

  double& so_far(int node) { return adjoint_[static_cast<std::size_t>(node - tape_.variables)]; }

  const Tape<double>& tape_;
  // Operations still to be seen: a bit each where they are near, the highest of the one that is seen, and in their order where they are not.
  int k_ = 0;
  std::uint64_t near_ = 0;
  std::vector<int> far_;
  std::vector<double> adjoint_;  // what those have got so far
};

// The entries of a matrix that may be other than zero, row by row.
struct SparseRows {
  struct Entry {
    int column;
    double value;
  };
  std::vector<Entry> entries;
  std::vector<std::size_t> starts{0};  // of the rows among the entries, and the end

  std::size_t size() const { return starts.size() - 1; }
  const Entry* begin(std::size_t row) const { return entries.data() + starts[row]; }
  const Entry* end(std::size_t row) const { return entries.data() + starts[row + 1]; }
};

// J of a scene's constraints, with empty rows for those that are not active. False when a number of rows is not what the scene has counted,
// or a derivative is not finite.
template <class Sc, class Phases, class Number = double>  // a type that depends on nothing would be compiled in each program
bool write_sparse_rows(const Sc& scene, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, double t, const Phases& z, SparseRows& J) {
  using S = Reverse<Number>;
  const Eigen::Index n = q.size();
  Tape<Number> tape(n);  // of q or q̇
  SweepOfRows sweep(tape);
  Vector<S, Dynamic> x(n), v(0);
  J.entries.clear();
  J.entries.reserve(static_cast<std::size_t>(4 * n));
  J.starts.reserve(static_cast<std::size_t>(n) + 1);
  J.starts.assign(1, 0);
  std::vector<int> place(static_cast<std::size_t>(n), -1);  // of a column's latest entry
  double zero = 0.0;
  bool counted_right = true;
  std::size_t k = 0;
  for_each_constraint(scene, z, [&](const auto& e, bool active) {
    using E = std::remove_cvref_t<decltype(e)>;
    const Eigen::Index counted = rows_of_constraint<E>(scene, k++);
    if (!active) {
      J.starts.resize(J.starts.size() + static_cast<std::size_t>(counted), J.entries.size());
      return;
    }
    const auto rows = [&] {
      if constexpr (HolonomicEffect<E, Dynamic>) {
        for (Eigen::Index i = 0; i < n; ++i) x[i] = tape.variable(i, q[i]);
        return as_rows(e.phi(x, S(t)));
      } else {
        v.resize(n);
        for (Eigen::Index i = 0; i < n; ++i) {
          x[i] = S(q[i]);
          v[i] = tape.variable(i, qdot[i]);
        }
        return as_rows(e.velocity_constraint(x, v, S(t)));
      }
    }();
    counted_right = counted_right && rows.size() == counted;
    for (Eigen::Index i = 0; i < rows.size(); ++i) {
      const int first = static_cast<int>(J.entries.size());
      sweep(rows[i], [&](int column, double share) {
        zero += share - share;
        int& at = place[static_cast<std::size_t>(column)];
        if (at >= first) {
          J.entries[static_cast<std::size_t>(at)].value += share;
        } else {
          at = static_cast<int>(J.entries.size());
          J.entries.push_back({column, share});
        }
      });
      J.starts.push_back(J.entries.size());
    }
  });
  return counted_right && zero == 0.0;
}

}  // namespace qdot::detail
