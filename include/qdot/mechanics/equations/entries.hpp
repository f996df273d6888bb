#pragma once
// SPDX-License-Identifier: MIT
//
// Do T and V read entries that q and q̇ do not have?
//
// q[2] of two coordinates is whatever lies behind them in memory, where Eigen's assertions are off (-DNDEBUG), and the motion that follows
// may look well. An index is an argument like any other, so no type can refuse it. But one call of T and V with vectors that check each
// index can, and its cost is negligible in a run. What they hand on as a plain vector, to velocity_of() or to a function of Vector<S, n>,
// is looked at by Eigen only.

#include <utility>

#include "qdot/error.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot::detail {

// A vector whose entries are looked at one by one.
template <int n>
struct WatchedVector : Vector<double, n> {
  using Vector<double, n>::Vector;
  using Vector<double, n>::operator=;

  const double& operator[](Eigen::Index i) const {
    if (i < 0 || i >= this->size())
      throw_invalid_value({"T and V may read entries 0 to ", this->size() - 1, " of q and qdot, but one of them reads entry ", i,
                           "; count from 0, and give mechanical_system the number of coordinates that T and V are made for"});
    return this->coeffRef(i);
  }
  const double& operator()(Eigen::Index i) const { return (*this)[i]; }
  double& operator[](Eigen::Index i) { return const_cast<double&>(std::as_const(*this)[i]); }
  double& operator()(Eigen::Index i) { return (*this)[i]; }
};

// Energies that are made of others, or of positions, say how to get to them.
template <class E>
concept HasInnerEnergies = requires(const E& e) { e.without_terms(); };
template <class E, int n>
concept ReadsEntries = requires(const E& e, const WatchedVector<n>& q) { e.read_entries(q, q, 0.0); };

template <int n, class E>
void read_entries(const E& e, const WatchedVector<n>& q, const WatchedVector<n>& qdot, double t) {
  if constexpr (HasInnerEnergies<E>) {
    read_entries<n>(e.without_terms(), q, qdot, t);
  } else if constexpr (ReadsEntries<E, n>) {
    e.read_entries(q, qdot, t);
  } else {
    (void)returned_by_T<n>(e, q, qdot, t);
    (void)returned_by_V<n>(e, q, t);
  }
}

// Throws where T or V reads an entry that is not there. What else they throw is met again by the run, which has a name for it.
template <class E, int n, Inertia inertia>
void require_existing_entries(const System<E, n, inertia>& system, const double* y, double t) {
  const Eigen::Index dof = system.dof();
  const WatchedVector<n> q(vector_at<n>(y, dof)), qdot(vector_at<n>(y + dof, dof));
  try {
    read_entries<n>(system.energies(), q, qdot, t);
  } catch (const InvalidValue&) {
    throw;
  } catch (...) {
  }
}

}  // namespace qdot::detail
