#pragma once
// SPDX-License-Identifier: MIT
//
// Accelerations of many members of one system at once, an ensemble of states.
//
// Members differ in their states: initial conditions on a grid, a cloud of perturbed ones, the particles of a filter. Their equations are the same
// lines (mechanics/derive/kept_lines.hpp), which are carried out for eight members at once (mechanics/derive/lane_equations.hpp).
//
// Lanes must not spoil each other, and no lane may fail in silence. So every lane is checked. A member is evaluated alone, as acceleration() would,
// where its mass matrix has a bad pivot or its result is not finite. So is a member whose functors branch otherwise than for the first one. Either
// its accelerations are good after all or the error that says what is wrong with it is handed back.
//
// In which order the numbers lie in memory is up to the matrix. With Eigen::RowMajor the members stand side by side, which is a little faster.

#include <algorithm>
#include <exception>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "qdot/ad/pack_math.hpp"
#include "qdot/mechanics/derive/lane_equations.hpp"
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

// Calls found(equations) with the equations of a system in lanes of packs P, on the branch of a state; nothing where it has none.
template <class P, class Sys, class Found>
[[gnu::noinline]] void with_lane_equations(const Sys& system, const double* q, const double* qdot, double t, const Found& found) {
  if constexpr (may_have_lane_lines<Sys>) {
    constexpr int n = Sys::dof_at_compile_time;
    constexpr std::size_t most = n <= 4 ? 256 : 768;  // numbers on the stack, 16 or 48 kB
    Derivations::Held held;
    const DerivedLines* const lines = lane_lines_at(system, AtState{q, qdot, t, n}, held);
    if (!lines || !lanes_pay(*lines)) return;
    if (lane_numbers(*lines) > most) {
      std::vector<formula::LaneNumber> x(lane_numbers(*lines));
      return found(LaneEquations<n, P>(*lines, x.data()));
    }
    formula::LaneNumber x[most];
    found(LaneEquations<n, P>(*lines, x));
  }
}

// q̈ of `count` members in packs of eight. member(i, k) gives coordinate i of member k in q and q̇; put(i, k, a) takes q̈, and alone(k) members that
// have none in a pack.
template <class Sys, class Position, class Velocity, class Time, class Put, class Alone>
void accelerate_members(const Sys& system, Eigen::Index count, const Position& position, const Velocity& velocity, const Time& time, const Put& put,
                        const Alone& alone) {
  constexpr int n = Sys::dof_at_compile_time;
  using P = Pack<static_cast<int>(formula::lanes_stored)>;
  Eigen::Index done = 0;
  if constexpr (may_have_lane_lines<Sys>) {
    Vector<double, n> q, qdot;
    for (int i = 0; i < n && count > 0; ++i) {
      q[i] = position(i, 0);
      qdot[i] = velocity(i, 0);
    }
    const auto in_lanes = [&](LaneEquations<n, P> equations) {
      P x[n], v[n], a[n];
      for (; done < count; done += P::size) {
        const auto member = [&](int lane) { return std::min<Eigen::Index>(done + lane, count - 1); };  // past the end the last one again
        for (int i = 0; i < n; ++i) {
          x[i] = P::of([&](int lane) { return position(i, member(lane)); });
          v[i] = P::of([&](int lane) { return velocity(i, member(lane)); });
        }
        const auto good = equations(x, v, P::of([&](int lane) { return time(member(lane)); }), a);
        for (int lane = 0; lane < P::size && done + lane < count; ++lane) {
          if (!good[lane]) alone(done + lane);
          for (int i = 0; i < n && good[lane]; ++i) put(i, done + lane, a[i][lane]);
        }
      }
    };
    if (count > 0) with_lane_equations<P>(system, q.data(), qdot.data(), time(0), in_lanes);
  }
  for (; done < count; ++done) alone(done);
}

}  // namespace detail

/// q̈ of `lanes` members of a system, one in each lane; NaN in the lanes that are not good.
///
/// No allocation up to some eight coordinates, once the equations have been derived. All lanes at once where T and V are formulas of up to 16 coordinates.
/// One after the other, as acceleration() does, for an indefinite mass matrix and for functors that ask for plain values.
///
/// @param q, qdot  states, n packs each
/// @param t        the members' times
template <class E, int n, Inertia inertia, int lanes>
  requires(n != Dynamic)
PackAccelerations<n, lanes> accelerations(const System<E, n, inertia>& system, const Vector<Pack<lanes>, n>& q,
                                          const Vector<Pack<lanes>, n>& qdot, const Pack<lanes>& t = 0.0) {
  double out[n][lanes], good[lanes];
  std::fill_n(good, lanes, 1.0);
  const auto alone = [&](Eigen::Index lane) {
    Vector<double, n> x, v, a;
    const int k = static_cast<int>(lane);
    for (int i = 0; i < n; ++i) {
      x[i] = q[i][k];
      v[i] = qdot[i][k];
    }
    good[k] = detail::member_acceleration(system, x, v, t[k], a, nullptr, lane) ? 1.0 : 0.0;
    for (int i = 0; i < n; ++i) out[i][k] = a[i];
  };
  detail::accelerate_members(
      system, lanes, [&](int i, Eigen::Index k) { return q[i][static_cast<int>(k)]; },
      [&](int i, Eigen::Index k) { return qdot[i][static_cast<int>(k)]; },
      [&](Eigen::Index k) { return t[static_cast<int>(k)]; }, [&](int i, Eigen::Index k, double a) { out[i][k] = a; }, alone);
  PackAccelerations<n, lanes> result;
  for (int i = 0; i < n; ++i) result.qddot[i] = Pack<lanes>::load(out[i]);
  result.good = Pack<lanes>::load(good) > 0.5;
  return result;
}

/// q̈ of the K members of an ensemble into `qddot`, one in each column.
///
/// Allocates nothing up to some eight coordinates unless a member fails, once the equations have been derived. Faster than K calls of acceleration()
/// under the conditions of the function above.
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
  const auto require = [](const char* subject, Eigen::Index expected, Eigen::Index actual, const char* remedy) {
    if (actual != expected) throw DimensionError(subject, static_cast<long>(expected), static_cast<long>(actual), remedy);
  };
  require("each column of q", system.dof(), q.rows(), "give one row for each coordinate");
  require("each column of qdot", system.dof(), qdot.rows(), "give one row for each coordinate");
  require("each row of qdot", q.cols(), qdot.cols(), "give one column for each member, as in q");
  require("each column of qddot", system.dof(), qddot.rows(), "give one row for each coordinate");
  require("each row of qddot", q.cols(), qddot.cols(), "give one column for each member, as in q");
  std::vector<MemberFailure> failures;
  const auto alone = [&](Eigen::Index member) {
    Vector<double, n> a;
    detail::member_acceleration(system, Vector<double, n>(q.col(member)), Vector<double, n>(qdot.col(member)), t, a, &failures, member);
    qddot.col(member) = a;
  };
  detail::accelerate_members(
      system, q.cols(), [&](int i, Eigen::Index k) { return q.coeff(i, k); }, [&](int i, Eigen::Index k) { return qdot.coeff(i, k); },
      [t](Eigen::Index) { return t; }, [&](int i, Eigen::Index k, double a) { qddot.coeffRef(i, k) = a; }, alone);
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
