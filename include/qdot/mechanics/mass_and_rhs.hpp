#pragma once
// SPDX-License-Identifier: MIT
//
// M and r of Lagrange's equations M q̈ = r at a state: what everything else is made of.
//
//     q̈ = M⁻¹ (r + Q)                     accelerations, with applied forces Q
//     M q̈ − Jᵀλ = r + Q ,  J q̈ = γ        with constraints (effects/rows/constrained_solve.hpp)
//
// M alone serves impacts, projections and momenta. M and r come by lines that are derived once
// (mechanics/derive/kept_lines.hpp), or as a band, of more than 32 coordinates whose number is known at run time
// (mechanics/equations/banded_equations.hpp). A caller passes an object `use` to with_mass_and_rhs(), which calls it
// with what it has found; `use` may overwrite that:
//     use.full(at, M, r)               lower triangle and r
//     use.rows<blocks>(at, n, M, r)    rows of 4·blocks numbers, lower triangle of blocks, and r
//     use.banded(at, M, r)             the band of a BandedMatrix, and r; where n is known at run time only
// `use` returns false for a pivot that is not positive, or a number that is not finite. Then, and where there is no
// such way, nested duals (mechanics/equations/lagrange_terms.hpp) evaluate M and r again and name what is wrong.

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>
#include <utility>

#include "qdot/ad/forward/where_broken.hpp"
#include "qdot/mechanics/derive/kept_lines.hpp"
#include "qdot/mechanics/equations/banded_equations.hpp"
#include "qdot/mechanics/equations/block_solve.hpp"
#include "qdot/mechanics/equations/solve.hpp"

namespace qdot {

namespace detail {

// Some uses want M within its band, however few coordinates there are.
template <class Use>
inline constexpr bool wants_band = requires { Use::wants_band; };

// Others read M alone.
template <class Use>
inline constexpr bool is_of_mass = requires { Use::is_of_mass; };

// Calls `use` with M and r at a state; false where there is no way but the general one. `kept`: the lines of these energies, if they are kept.
template <int n, class E, class Use>
bool with_mass_and_rhs(const E& e, const Vector<double, n>& q, const Vector<double, n>& qdot, double t, const Use& use, KeptLines* kept = nullptr) {
  if constexpr (may_keep_lines<E, n> && !wants_band<Use>) {
    const auto evaluated = [&](const DerivedLines& lines) { return lines.template with_mass_and_rhs<n>(q.data(), qdot.data(), t, use); };
    if (with_lines<n, is_of_mass<Use>>(kept, e, AtState{q.data(), qdot.data(), t, static_cast<int>(q.size())}, evaluated)) return true;
  }
  if constexpr (n == Dynamic) {
    if (wants_band<Use> || q.size() > block_limit<n>) {
      BandedEquations found = banded_equations(e, q, qdot, t);
      return use.banded(AtState{q.data(), qdot.data(), t}, found.M, found.r);
    }
  }
  return false;
}

// A use: q̈ = M⁻¹ (r + Q), written to `qddot`. Q is read where `forced`.
template <int n, bool forced = false>
struct AccelerationTo {
  double* qddot;
  double threshold;  // pivots below this fraction of their diagonal entry are none
  const double* Q = nullptr;

  bool full(const AtState&, double* M, double* r) const {
    if constexpr (forced) unroll<n>([&](auto i) __attribute__((always_inline)) { r[i] += Q[i]; });
    if (!solved_in_place<n>(M, r, threshold)) return false;
    double sum = -0.0;
    unroll<n>([&](auto i) __attribute__((always_inline)) { sum += qddot[i] = r[i]; });
    return is_finite(sum);
  }
  template <int blocks>
  bool rows(const AtState&, int size, double* M, double* r) const {
    if constexpr (forced)
      for (int i = 0; i < size; ++i) r[i] += Q[i];
    if (!solved_by_blocks<blocks>(size, M, r, threshold)) return false;
    double zero = 0.0;
    for (int i = 0; i < size; ++i) {
      zero += r[i] - r[i];
      qddot[i] = r[i];
    }
    return zero == 0.0;
  }
  bool banded(const AtState&, BandedMatrix& M, Eigen::VectorXd& r) const {
    if constexpr (forced)
      for (Eigen::Index i = 0; i < r.size(); ++i) r[i] += Q[i];
    if (!M.factor(threshold)) return false;
    M.solve(r);
    std::copy_n(r.data(), r.size(), qddot);
    return all_finite(r.data(), r.size());
  }
};

// A use: a copy of M, whole.
template <int n>
struct MassTo {
  static constexpr bool is_of_mass = true;
  Matrix<double, n>& M_out;

  bool full(const AtState&, const double* M, const double*) const {
    double zero = 0.0;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j <= i; ++j) {
        const double m = M[triangle_index(i, j)];
        zero += m - m;
        M_out(i, j) = M_out(j, i) = m;
      }
    return zero == 0.0;
  }
  template <int blocks>
  bool rows(const AtState&, int size, const double* M, const double*) const {
    double zero = 0.0;
    for (int i = 0; i < size; ++i)
      for (int j = 0; j <= i; ++j) {
        const double m = M[4 * blocks * i + j];
        zero += m - m;
        M_out(i, j) = M_out(j, i) = m;
      }
    return zero == 0.0;
  }
  bool banded(const AtState&, const BandedMatrix& M, const Eigen::VectorXd&) const {
    M_out = M.dense();
    return all_finite(M_out.data(), M_out.size());
  }
};

// A use: a copy of M, whole, and of r.
template <int n>
struct CopyTo {
  Matrix<double, n>& M_out;
  Vector<double, n>& r_out;

  bool full(const AtState& at, const double* M, const double* r) const { return has_copied(n, r) && MassTo<n>{M_out}.full(at, M, r); }
  template <int blocks>
  bool rows(const AtState& at, int size, const double* M, const double* r) const {
    return has_copied(size, r) && MassTo<n>{M_out}.template rows<blocks>(at, size, M, r);
  }
  bool banded(const AtState& at, const BandedMatrix& M, const Eigen::VectorXd& r) const {
    r_out = r;
    return all_finite(r.data(), r.size()) && MassTo<n>{M_out}.banded(at, M, r);
  }

 private:
  bool has_copied(int size, const double* r) const {
    double zero = 0.0;
    for (int i = 0; i < size; ++i) {
      zero += r[i] - r[i];
      r_out[i] = r[i];
    }
    return zero == 0.0;
  }
};

// A use: M within its band, and r.
struct BandTo {
  static constexpr bool wants_band = true;
  BandedMatrix& M_out;
  Eigen::VectorXd& r_out;

  bool banded(const AtState&, BandedMatrix& M, Eigen::VectorXd& r) const {
    M_out = std::move(M);
    r_out = std::move(r);
    return true;
  }
};

#ifdef QDOT_COMPILED
extern template bool DerivedLines::with_mass_and_rhs<1>(const double*, const double*, double, const AccelerationTo<1>&) const;
extern template bool DerivedLines::with_mass_and_rhs<1>(const double*, const double*, double, const AccelerationTo<1, true>&) const;
extern template bool DerivedLines::with_mass_and_rhs<1>(const double*, const double*, double, const CopyTo<1>&) const;
extern template bool DerivedLines::with_mass_and_rhs<1>(const double*, const double*, double, const MassTo<1>&) const;
extern template bool DerivedLines::with_mass_and_rhs<2>(const double*, const double*, double, const AccelerationTo<2>&) const;
extern template bool DerivedLines::with_mass_and_rhs<2>(const double*, const double*, double, const AccelerationTo<2, true>&) const;
extern template bool DerivedLines::with_mass_and_rhs<2>(const double*, const double*, double, const CopyTo<2>&) const;
extern template bool DerivedLines::with_mass_and_rhs<2>(const double*, const double*, double, const MassTo<2>&) const;
extern template bool DerivedLines::with_mass_and_rhs<3>(const double*, const double*, double, const AccelerationTo<3>&) const;
extern template bool DerivedLines::with_mass_and_rhs<3>(const double*, const double*, double, const AccelerationTo<3, true>&) const;
extern template bool DerivedLines::with_mass_and_rhs<3>(const double*, const double*, double, const CopyTo<3>&) const;
extern template bool DerivedLines::with_mass_and_rhs<3>(const double*, const double*, double, const MassTo<3>&) const;
extern template bool DerivedLines::with_mass_and_rhs<4>(const double*, const double*, double, const AccelerationTo<4>&) const;
extern template bool DerivedLines::with_mass_and_rhs<4>(const double*, const double*, double, const AccelerationTo<4, true>&) const;
extern template bool DerivedLines::with_mass_and_rhs<4>(const double*, const double*, double, const CopyTo<4>&) const;
extern template bool DerivedLines::with_mass_and_rhs<4>(const double*, const double*, double, const MassTo<4>&) const;
extern template bool DerivedLines::with_mass_and_rhs<5>(const double*, const double*, double, const AccelerationTo<5>&) const;
extern template bool DerivedLines::with_mass_and_rhs<5>(const double*, const double*, double, const AccelerationTo<5, true>&) const;
extern template bool DerivedLines::with_mass_and_rhs<6>(const double*, const double*, double, const AccelerationTo<6>&) const;
extern template bool DerivedLines::with_mass_and_rhs<6>(const double*, const double*, double, const AccelerationTo<6, true>&) const;
extern template bool DerivedLines::with_mass_and_rhs<7>(const double*, const double*, double, const AccelerationTo<7>&) const;
extern template bool DerivedLines::with_mass_and_rhs<7>(const double*, const double*, double, const AccelerationTo<7, true>&) const;
extern template bool DerivedLines::with_mass_and_rhs<8>(const double*, const double*, double, const AccelerationTo<8>&) const;
extern template bool DerivedLines::with_mass_and_rhs<8>(const double*, const double*, double, const AccelerationTo<8, true>&) const;
#endif

}  // namespace detail

/// M and r of M q̈ = r.
template <class S, int n>
struct MassAndRhs {
  Matrix<S, n> M;  ///< n×n, symmetric
  Vector<S, n> r;  ///< n
};

namespace detail {

template <class = void>
[[gnu::cold]] std::string reason(const OutsideOfDomain& it) {
  return sentence({", because ", it.function, "(x) has no value at x = ", {it.argument, 17}, " (it needs ", it.domain, ")"});
}
// Which function of an energy has no value, in words; empty where that is not known.
template <class Energy>
[[gnu::cold]] std::string outside_of_domain(const Energy& energy) {
  try {
    energy();
  } catch (const OutsideOfDomain& it) {
    return reason(it);
  }
  return {};
}

template <class = void>
[[noreturn, gnu::cold]] void throw_energy_not_finite(const char* name, double energy, double t, const std::string& why) {
  throw NonFinite(name, t, sentence({"the energies must be finite, but ", name, " is ", energy, " at t = ", {t, 6}, why,
                                     "; check it there for a division by zero, a root or logarithm outside its domain, or overflow"}));
}
#ifdef QDOT_COMPILED
extern template std::string reason<void>(const OutsideOfDomain&);
extern template void throw_energy_not_finite<void>(const char*, double, double, const std::string&);
#endif

// T and V have values at a state. Asked of duals, for which every functor compiles that has derivatives.
template <class E, int n>
[[gnu::cold, gnu::noinline]] void require_finite_energies(const E& e, const Vector<double, n>& q, const Vector<double, n>& qdot, double t) {
  using D = Dual<double, 1>;
  using A = AskedNumber;
  const Vector<D, n> x = constants<D>(q);
  const double T = kinetic<n>(e, x, constants<D>(qdot), D(t)).value;
  const bool is_T = !std::isfinite(T);
  const double V = is_T ? 0.0 : potential<n>(e, x, D(t)).value;
  if (!is_T && std::isfinite(V)) return;
  throw_energy_not_finite(is_T ? "T" : "V", is_T ? T : V, t, outside_of_domain([&] {
    if constexpr (T_may_throw<E, A, n>)
      if (is_T) kinetic<n>(e, constants<A>(q), constants<A>(qdot), A(t));
    if constexpr (V_may_throw<E, A, n>)
      if (!is_T) potential<n>(e, constants<A>(q), A(t));
  }));
}

// M and r by the way that holds for everything: nested duals, and within the band where there are many coordinates for these and the band has
// numbers. Where it has none though the energies have, it is for nested duals to know that a constant has no derivative.
// `often`: of systems that have no other way.
template <int n, bool often = false, class S, class E>
[[gnu::noinline]] MassAndRhs<S, n> general_mass_and_rhs(const E& e, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) {
  if constexpr (n == Dynamic && std::is_same_v<S, double>) {
    if (q.size() > block_limit<n>) {
      const BandedEquations found = banded_equations(e, q, qdot, t);
      MassAndRhs<double, n> both{found.M.dense(), found.r};
      if (all_finite(both.M) && all_finite(both.r)) return both;
      require_finite_energies(e, q, qdot, t);
    }
  }
  if constexpr (std::is_same_v<S, double> && !often) return {general_mass_matrix<n>(e, q, qdot, t), general_rhs<n>(e, q, qdot, t)};
  else return {kinetic_hessian<n>(e, q, qdot, t), lagrange_rhs<n>(e, q, qdot, t)};
}

}  // namespace detail

/// Mass matrix and right-hand side of Lagrange's equations at a state.
///
/// Exact to rounding. Of numbers by the shortest way that the energies allow; of other scalars by nested duals.
///
/// @param q, qdot  state, n each
/// @return         M, r with M q̈ = r   [r: energy per unit of q]
template <class E, int n, Inertia inertia, class S>
MassAndRhs<S, n> mass_and_rhs(const System<E, n, inertia>& system, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) {
  detail::require_sizes(system, q, qdot);
  if constexpr (std::is_same_v<S, double>) {
    MassAndRhs<double, n> found{detail::zeros<Matrix<double, n>>(q.size(), q.size()), detail::zeros<Vector<double, n>>(q.size())};
    if (detail::with_mass_and_rhs<n>(system.energies(), q, qdot, t, detail::CopyTo<n>{found.M, found.r}, system.kept_lines())) return found;
  }
  return detail::general_mass_and_rhs<n>(system.energies(), q, qdot, t);
}

}  // namespace qdot
