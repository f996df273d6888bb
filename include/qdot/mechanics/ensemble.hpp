#pragma once
// SPDX-License-Identifier: MIT
//
// Ensembles: the accelerations of many members of one system at once.
//
// Members differ in their states: initial conditions on a grid, a cloud of perturbed ones, the particles of a filter. A
// processor evaluates T and V for 2, 4 or 8 of them at the price of one (ad/pack.hpp), and that needs nothing from the
// user but functors that do not branch on their numbers (select() instead of `if`).
//
// Lanes must not spoil each other, and no lane may fail in silence. So every lane is looked at: where the mass matrix has a bad
// pivot or the result is not finite, that member alone is evaluated as acceleration() would, and either its accelerations are good
// after all (an argument of sine beyond 10⁵, say) or the error that says what is wrong with it is handed back.
//
// In which order the numbers lie in memory is up to the matrix: with Eigen::RowMajor the members stand side by side, as a pack wants
// them; otherwise each member's coordinates do.

#include <algorithm>
#include <exception>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "qdot/ad/lagrange/pack_euler_lagrange.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"

namespace qdot {

/// Accelerations of the members in a pack, and which of them are good.
template <int n, int lanes>
struct PackAccelerations {
  Vector<Pack<lanes>, n> qddot;  ///< q̈, n packs
  PackMask<lanes> good;          ///< false: no acceleration stands in this lane
};

/// A member of an ensemble that has no acceleration, and why.
struct MemberFailure {
  Eigen::Index member;       ///< its column
  std::exception_ptr error;  ///< what acceleration() throws for it: SingularMassMatrix, NonFinite, …
  std::string message;       ///< its text
};

namespace detail {

template <class Mask>
struct StraightLine {
  bool is_straight;  // known when compiled: no loop or branch is left in T or V
  Mask good;
};

// q̈ of the lanes of a register as in mechanics/equations/straight_line.hpp; forces(q, q̇, Q) writes what is added to r.
template <int n, class E, class P, class Forces>
[[gnu::noinline, gnu::flatten]] inline StraightLine<typename P::Mask> straight_line_accelerations(const E& e, const P* q, const P* qdot,
                                                                                                  const P& t, double threshold,
                                                                                                  const Forces& forces, P* qddot) {
  if (!may_go_straight(e)) return {false, false};
  const EulerLagrange<n, P> L = euler_lagrange_of<n>(e, q, qdot, t);
  if (straight_line_pays && !__builtin_constant_p(L.g_mask | L.h_mask)) {
    unroll<n>([&](auto i) __attribute__((always_inline)) { qddot[i] = 0.0; });
    return {false, false};
  }
  P M[n * (n + 1) / 2];
  P r[n];
  unroll<n>([&](auto i) __attribute__((always_inline)) { r[i] = L.template x<i>(); });
  unroll<n*(n + 1) / 2>([&](auto k) __attribute__((always_inline)) { M[k] = L.template h<k>(); });
  if constexpr (!std::is_same_v<Forces, NoForces>) {
    P Q[n];
    forces(q, qdot, Q);
    unroll<n>([&](auto i) __attribute__((always_inline)) { r[i] += Q[i]; });
  }
  typename P::Mask good = solved_in_place<n>(M, r, threshold, L.h_mask);
  P zero = 0.0;
  unroll<n>([&](auto i) __attribute__((always_inline)) {
    zero += r[i] - r[i];
    qddot[i] = r[i];
  });
  good &= zero == P(0.0);
  return {true, good};
}

// The same by derived formulas.
template <int n, class E, class P, class Forces>
[[gnu::noinline, gnu::flatten]] inline typename P::Mask closed_form_accelerations(const E& e, const P* q, const P* qdot, const P& t,
                                                                                  const Forces& forces, P* qddot) {
  return e.accelerations_in_closed_form(q, qdot, t, qddot, forces);
}

// By one or the other; lanes that are not `good` hold anything.
template <int n, class E, class P, class Forces>
typename P::Mask register_accelerations(const E& e, const P* q, const P* qdot, const P& t, const Forces& forces, P* qddot) {
  if constexpr (HasClosedForm<E>) {
    if (!e.has_closed_form()) return false;
    return closed_form_accelerations<n>(e, q, qdot, t, forces, qddot);
  } else {
    const auto line = straight_line_accelerations<n>(e, q, qdot, t, singular_pivot<double>(n), forces, qddot);
    return line.good & typename P::Mask(line.is_straight);
  }
}

// Largest n that goes in packs: there are fewer registers for wide numbers, and compile time grows with n⁴ or so.
inline constexpr int pack_limit = 6;

// Whether the packs of a system have a way of their own.
template <class Sys>
inline constexpr bool goes_in_packs = straight_line_pays && Sys::inertia == Inertia::positive_definite &&
                                      Sys::dof_at_compile_time >= 1 && Sys::dof_at_compile_time <= pack_limit;

// q̈ of all lanes, a register at a time; lanes that are not `good` hold anything.
template <class E, int n, Inertia inertia, class P>
typename P::Mask unchecked_accelerations(const System<E, n, inertia>& system, const P* q, const P* qdot, const P& t, P* qddot) {
  if constexpr (!goes_in_packs<System<E, n, inertia>>) {
    for (int i = 0; i < n; ++i) qddot[i] = 0.0;
    return false;
  } else if constexpr (P::is_register) {
    return register_accelerations<n>(system.energies(), q, qdot, t, NoForces(), qddot);
  } else {
    using Half = typename P::Half;
    Half x[2][n], v[2][n], a[2][n];
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      x[0][i] = q[i].low;
      x[1][i] = q[i].high;
      v[0][i] = qdot[i].low;
      v[1][i] = qdot[i].high;
    });
    const typename P::Mask good(unchecked_accelerations(system, x[0], v[0], t.low, a[0]), unchecked_accelerations(system, x[1], v[1], t.high, a[1]));
    unroll<n>([&](auto i) __attribute__((always_inline)) { qddot[i] = P(a[0][i], a[1][i]); });
    return good;
  }
}

// q̈ of one member: false, NaN and the error where it has none.
template <class E, int n, Inertia inertia>
[[gnu::noinline]] bool member_acceleration(const System<E, n, inertia>& system, const Vector<double, n>& q,
                                           const Vector<double, n>& qdot, double t, Vector<double, n>& qddot,
                                           std::vector<MemberFailure>* failures, Eigen::Index member) {
  try {
    qddot = acceleration(system, q, qdot, t);
    return true;
  } catch (const Error& error) {
    qddot.setConstant(q.size(), std::numeric_limits<double>::quiet_NaN());
    if (failures) failures->push_back({member, std::current_exception(), error.what()});
    return false;
  }
}

// `lanes` numbers of row i of a matrix, from column `first` on; past its end the last one again.
template <int lanes, class M>
[[gnu::always_inline]] inline Pack<lanes> members(const M& matrix, Eigen::Index i, Eigen::Index first) {
  if (first + lanes <= matrix.cols()) {
    if constexpr (M::IsRowMajor && M::InnerStrideAtCompileTime == 1) {
      return Pack<lanes>::load(matrix.data() + i * matrix.outerStride() + first);
    } else {
      return Pack<lanes>::of([&](int lane) { return matrix.coeff(i, first + lane); });
    }
  }
  return Pack<lanes>::of([&](int lane) { return matrix.coeff(i, std::min<Eigen::Index>(first + lane, matrix.cols() - 1)); });
}

}  // namespace detail

/// q̈ of `lanes` members of a system, one in each lane; NaN in the lanes that are not good.
///
/// No allocation. Where T and V are straight-line code, all lanes at once; one after the other, as acceleration() goes, with a plain
/// loop in T or V, for more than 6 coordinates, for an indefinite mass matrix, and in code compiled without optimization.
///
/// @param q, qdot  states, n packs each
/// @param t        the members' times
template <class E, int n, Inertia inertia, int lanes>
  requires(n != Dynamic)
PackAccelerations<n, lanes> accelerations(const System<E, n, inertia>& system, const Vector<Pack<lanes>, n>& q,
                                          const Vector<Pack<lanes>, n>& qdot, const Pack<lanes>& t = 0.0) {
  PackAccelerations<n, lanes> result;
  result.good = detail::unchecked_accelerations(system, q.data(), qdot.data(), t, result.qddot.data());
  if (result.good.all()) return result;
  double out[n][lanes];
  double good[lanes];
  for (int i = 0; i < n; ++i) result.qddot[i].store(out[i]);
  for (int lane = 0; lane < lanes; ++lane) {
    good[lane] = 1.0;
    if (result.good[lane]) continue;
    Vector<double, n> x, v, a;
    for (int i = 0; i < n; ++i) {
      x[i] = q[i][lane];
      v[i] = qdot[i][lane];
    }
    good[lane] = detail::member_acceleration(system, x, v, t[lane], a, nullptr, lane) ? 1.0 : 0.0;
    for (int i = 0; i < n; ++i) out[i][lane] = a[i];
  }
  for (int i = 0; i < n; ++i) result.qddot[i] = Pack<lanes>::load(out[i]);
  result.good = Pack<lanes>::load(good) > 0.5;
  return result;
}

/// q̈ of the K members of an ensemble into `qddot`, one in each column.
///
/// Allocates nothing unless a member fails. Faster than K calls of acceleration() under the conditions of the function above.
///
/// @param q, qdot  states, n×K each, one member in each column
/// @param t        the time of all members
/// @param qddot    n×K; the columns of failed members are NaN
/// @return         the members without accelerations, in order; empty when all is well
/// @throws         DimensionError  when a size disagrees
template <class E, int n, Inertia inertia, class Q, class Qdot, class Qddot>
[[nodiscard]] std::vector<MemberFailure> accelerations(const System<E, n, inertia>& system, const Eigen::PlainObjectBase<Q>& q,
                                                       const Eigen::PlainObjectBase<Qdot>& qdot, double t,
                                                       Eigen::PlainObjectBase<Qddot>& qddot) {
  static_assert(std::is_same_v<typename Q::Scalar, double> && std::is_same_v<typename Qdot::Scalar, double> && std::is_same_v<typename Qddot::Scalar, double>,
                "qdot: the states and accelerations of an ensemble are matrices of double");
  constexpr int lanes = detail::register_lanes;
  const auto require = [](const char* subject, Eigen::Index expected, Eigen::Index actual, const char* remedy) {
    if (actual != expected) throw DimensionError(subject, static_cast<long>(expected), static_cast<long>(actual), remedy);
  };
  require("each column of q", system.dof(), q.rows(), "give one row for each coordinate");
  require("each column of qdot", system.dof(), qdot.rows(), "give one row for each coordinate");
  require("each row of qdot", q.cols(), qdot.cols(), "give one column for each member, as in q");
  require("each column of qddot", system.dof(), qddot.rows(), "give one row for each coordinate");
  require("each row of qddot", q.cols(), qddot.cols(), "give one column for each member, as in q");
  std::vector<MemberFailure> failures;
  const auto evaluate_alone = [&](Eigen::Index member) {
    Vector<double, n> a;
    detail::member_acceleration(system, Vector<double, n>(q.col(member)), Vector<double, n>(qdot.col(member)), t, a, &failures, member);
    qddot.col(member) = a;
  };
  if constexpr (detail::goes_in_packs<System<E, n, inertia>>) {
    Pack<lanes> x[n], v[n], a[n];
    for (Eigen::Index first = 0; first < q.cols(); first += lanes) {
      unroll<n>([&](auto i) __attribute__((always_inline)) {
        x[i] = detail::members<lanes>(q.derived(), i, first);
        v[i] = detail::members<lanes>(qdot.derived(), i, first);
      });
      const PackMask<lanes> good = detail::unchecked_accelerations(system, x, v, Pack<lanes>(t), a);
      const int count = static_cast<int>(std::min<Eigen::Index>(lanes, q.cols() - first));
      if (good.all() && count == lanes) {
        unroll<n>([&](auto i) __attribute__((always_inline)) {
          if constexpr (Qddot::IsRowMajor) {
            a[i].store(qddot.data() + i * qddot.outerStride() + first);
          } else {
            // From memory, where the accelerations lie already: cheaper than taking registers apart.
            const char* const from = reinterpret_cast<const char*>(&a[i]);
            unroll<lanes>([&](auto lane) __attribute__((always_inline)) {
              __builtin_memcpy(&qddot.coeffRef(i, first + lane), from + sizeof(double) * lane, sizeof(double));
            });
          }
        });
        continue;
      }
      for (int lane = 0; lane < count; ++lane) {
        if (good[lane]) {
          for (int i = 0; i < n; ++i) qddot(i, first + lane) = a[i][lane];
        } else {
          evaluate_alone(first + lane);
        }
      }
    }
  } else {
    for (Eigen::Index member = 0; member < q.cols(); ++member) evaluate_alone(member);
  }
  return failures;
}

/// Accelerations of an ensemble, and the members that have none.
template <class M>
struct EnsembleAccelerations {
  M qddot;                              ///< n×K, NaN in the columns of failed members
  std::vector<MemberFailure> failures;  ///< empty when all is well
};

/// q̈ of the K members of an ensemble, n×K like the states.
template <class E, int n, Inertia inertia, class Q, class Qdot>
[[nodiscard]] EnsembleAccelerations<Q> accelerations(const System<E, n, inertia>& system, const Eigen::PlainObjectBase<Q>& q,
                                                     const Eigen::PlainObjectBase<Qdot>& qdot, double t = 0.0) {
  EnsembleAccelerations<Q> result{Q(q.rows(), q.cols()), {}};
  result.failures = accelerations(system, q, qdot, t, result.qddot);
  return result;
}

}  // namespace qdot
