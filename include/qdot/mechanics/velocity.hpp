#pragma once
// SPDX-License-Identifier: MIT
//
// Velocity from position: ẋ is not written by hand
// ================================================
//
//     ṙ = Σ_i (∂r/∂q_i) q̇_i + ∂r/∂t = J(q, t) q̇ + ∂r/∂t        is the ε part of r at        q_i + q̇_i ε,   t + 1 ε .
//
// One evaluation of r(q, t), no Jacobian, no approximation, and no derivation on paper, where errors are made. What r
// returns comes back: a number, a vector, a rotation matrix.
//     const auto T = [](const auto& q, const auto& qdot) {
//       const auto position = [](const auto& x) { return vector(x[0] * cos(x[1]), x[0] * sin(x[1])); };
//       return 0.5 * velocity_of(position, q, qdot).squaredNorm();         // ½ (ṙ² + r²φ̇²)
//     };
// It works inside T because duals nest. Where T is evaluated on a scalar S with derivatives, r is evaluated on
// Dual<S, 1>, and ṙ comes back as S with all of them. The inner ε has a tag of its own, so that it cannot be taken for
// an outer one. Once more around gives the acceleration, r̈ = J q̈ + J̇ q̇ + …, from (q + q̇ ε₁) + (q̇ + q̈ ε₁) ε₂.

#include <type_traits>
#include <utility>

#include <Eigen/Core>

#include "qdot/ad/dual.hpp"
#include "qdot/ad/dual_eigen.hpp"
#include "qdot/ad/dual_math.hpp"
#include "qdot/ad/forward/functor_result.hpp"
#include "qdot/ad/unroll.hpp"
#include "qdot/ad/vector.hpp"

namespace qdot {

#if defined(__clang__) && defined(__OPTIMIZE__)  // ad/forward/functor_result.hpp says why
#pragma clang attribute push(__attribute__((always_inline)), apply_to = function)
#endif

namespace detail {

template <class S, class... Numbers>
auto column_of(const Numbers&... numbers) {
  Vector<S, static_cast<int>(sizeof...(Numbers))> column;
  Eigen::Index i = 0;
  ((column[i++] = S(numbers)), ...);
  return column;
}

}  // namespace detail

/// The column (x₁, …, x_k) of scalars that may differ in type, such as duals beside plain numbers; integers become doubles.
template <class First, class... Rest>
constexpr auto vector(const First& first, const Rest&... rest) {
  using Sum = std::decay_t<decltype((first + ... + rest))>;
  using S = std::conditional_t<std::is_integral_v<Sum>, double, Sum>;
  return detail::column_of<S>(first, rest...);
}

/// A quantity and its rate of change.
template <class Value>
struct ValueAndRate {
  Value value;  ///< x
  Value rate;   ///< ẋ
};

namespace detail {

struct RateTag {};

/// A number with one derivative: the one along the motion.
template <class S>
using AlongMotion = Dual<S, 1, RateTag>;

template <class S>
constexpr AlongMotion<S> moving_number(const S& value, const S& rate) {
  AlongMotion<S> x(value);
  x.tangent[0] = rate;
  return x;
}

// The scalar that holds both a coordinate and a velocity; they differ when only one of them is differentiated.
template <class Q, class Qdot, class... Time>
using MotionScalar = std::decay_t<decltype(((std::declval<typename Q::Scalar>() + std::declval<typename Qdot::Scalar>()) + ... + std::declval<const Time&>()))>;

// How a scalar follows a position along the motion without duals around it: hashes do (mechanics/derive/fingerprint.hpp).
template <class S>
struct MovingPositions {
  static constexpr bool known = false;
};

// Vectors of values and rates → one vector of duals.
template <class S, class Q, class Qdot>
auto moving_vector(const Eigen::MatrixBase<Q>& q, const Eigen::MatrixBase<Qdot>& qdot) {
  static_assert(require_real<S>());
  constexpr int n = Q::SizeAtCompileTime;
  eigen_assert(q.size() == qdot.size());
  Vector<AlongMotion<S>, n> moving(q.size());
  const auto set = [&](Eigen::Index i) __attribute__((always_inline)) {
    moving.data()[i] = moving_number<S>(S(q.derived().coeff(i)), S(qdot.derived().coeff(i)));
  };
  for (Eigen::Index i = 0; i < q.size(); ++i) set(i);
  return moving;
}

template <class Result>
concept IsMatrix = requires { Result::RowsAtCompileTime; };

template <class S, class Result>
using PlainOf = Eigen::Matrix<S, Result::RowsAtCompileTime, Result::ColsAtCompileTime>;

// Follows the entries of what a function of positions returned.
template <class Positions>
struct FollowBy {
  const Positions& positions;
  template <class Entry>
  [[gnu::always_inline]] auto operator()(const Entry& entry) const { return positions.both(typename Positions::Position(entry)); }
};

// Calls visit(entry, k) for the entries of a matrix, column by column, whichever way it is stored; without a loop where that counts.
template <bool is_unrolled, class Result, class Visit>
void over_entries(const Result& matrix, const Visit& visit) {
  constexpr int size = Result::SizeAtCompileTime, rows = Result::RowsAtCompileTime, columns = Result::ColsAtCompileTime;
  if constexpr (is_unrolled && size != Dynamic) {
    const auto* const entry = matrix.data();
    unroll<size>([&](auto k) __attribute__((always_inline)) { visit(entry[Result::IsRowMajor ? k % rows * columns + k / rows : k], k); });
  } else {
    for (Eigen::Index j = 0, k = 0; j < matrix.cols(); ++j)
      for (Eigen::Index i = 0; i < matrix.rows(); ++i, ++k) visit(matrix.coeff(i, j), k);
  }
}

// Value and rate of all that a function returned, entry by entry.
template <class S, class Result, class Follow>
auto followed(const Result& result, const Follow& follow) {
  return follow(result);
}
template <class S, class Result, class Follow>
  requires IsMatrix<Result>
auto followed(const Result& result, const Follow& follow) {
  const auto& matrix = result.eval();
  ValueAndRate<PlainOf<S, Result>> both;
  both.value.resize(matrix.rows(), matrix.cols());
  both.rate.resize(matrix.rows(), matrix.cols());
  S *const values = both.value.data(), *const rates = both.rate.data();
  over_entries<is_hash<S>>(matrix, [&](const auto& entry, auto k) __attribute__((always_inline)) {
    const ValueAndRate<S> found = follow(entry);
    values[k] = found.value;
    rates[k] = found.rate;
  });
  return both;
}

// Rates alone. A matrix of large scalars is made where it is wanted: compilers do not see through a copy of it, and GCC copies what is
// returned from an inner block.
template <class S, class Result, class Follow>
S followed_rates(const Result& result, const Follow& follow) {
  return follow(result).rate;
}
template <class S, class Result, class Follow>
  requires IsMatrix<Result>
PlainOf<S, Result> followed_rates(const Result& result, const Follow& follow) {
  const auto& matrix = result.eval();
  PlainOf<S, Result> rate;
  rate.resize(matrix.rows(), matrix.cols());
  S* const rates = rate.data();
  over_entries<is_hash<S>>(matrix, [&](const auto& entry, auto k) __attribute__((always_inline)) { rates[k] = follow(entry).rate; });
  return rate;
}

// What the user's function returned → value and rate: a dual, a matrix of duals, or a constant.
template <class S, class Result>
auto split(const Result& result) {
  if constexpr (std::is_same_v<Result, AlongMotion<S>>) {
    return ValueAndRate<S>{result.value, result.tangent[0]};
  } else if constexpr (std::is_convertible_v<Result, S>) {
    return ValueAndRate<S>{S(result), S(0)};
  } else {
    return followed<S>(result, [](const auto& entry) { return split<S>(entry); });
  }
}

// Calls use(follow, x, t) with coordinates and a time that move; t only if it is given. follow(entry) is the value and the rate of an entry made of them.
template <class S, class Q, class Qdot, class Use, class... Time>
auto with_moving(const Eigen::MatrixBase<Q>& q, const Eigen::MatrixBase<Qdot>& qdot, const Use& use, const Time&... t) {
  using Positions = MovingPositions<S>;
  if constexpr (Positions::known) {
    using Position = typename Positions::Position;
    constexpr int n = Q::SizeAtCompileTime;
    Positions positions;
    Vector<Position, n> at(q.size());
    Position* const to = at.data();
    if constexpr (n != Dynamic) unroll<n>([&](auto i) __attribute__((always_inline)) { positions.read(S(q[i]), S(qdot[i]), to[i]); });
    else for (Eigen::Index i = 0; i < q.size(); ++i) positions.read(S(q[i]), S(qdot[i]), to[i]);
    const auto time = [&](const S& s) __attribute__((always_inline)) {
      Position position(0.0);
      positions.read_time(s, position);
      return position;
    };
    const FollowBy<Positions> follow{positions};
    return use(follow, at, time(S(t))...);
  } else {
    return use([](const auto& entry) { return split<S>(entry); }, moving_vector<S>(q, qdot), moving_number<S>(S(t), S(1))...);
  }
}

// finish(x, follow) of what x returned along the motion.
template <class S, class Function, class Q, class Qdot, class Finish, class... Time>
auto along_motion(const Function& x, const Eigen::MatrixBase<Q>& q, const Eigen::MatrixBase<Qdot>& qdot, const Finish& finish,
                  const Time&... t) {
  return with_moving<S>(q, qdot, [&](const auto& follow, const auto&... at) {
    return finish(result_of(x, at...), follow);
  }, t...);
}

}  // namespace detail

/// x(q) and ẋ = (∂x/∂q) q̇ in one evaluation of x; of a moving suspension or a driven joint x(q, t) and ẋ = (∂x/∂q) q̇ + ∂x/∂t.
///
/// @param x     function of the coordinates, and of the time if that is given: generic, returns a scalar, vector or matrix of its argument's scalar
/// @param q     coordinates, n
/// @param qdot  velocities, n; of any scalar, nested duals included
/// @return      value and rate, each of the shape that x returns
template <class Function, class Q, class Qdot, class... Time>
auto value_and_velocity_of(const Function& x, const Eigen::MatrixBase<Q>& q, const Eigen::MatrixBase<Qdot>& qdot, const Time&... t) {
  static_assert(sizeof...(Time) <= 1, "qdot: a position is a function of q, or of q and t");
  using S = detail::MotionScalar<Q, Qdot, Time...>;
  return detail::along_motion<S>(x, q, qdot, [](const auto& r, const auto& follow) { return detail::followed<S>(r, follow); }, t...);
}

/// The velocity ẋ = (∂x/∂q) q̇ of x(q), or ẋ = (∂x/∂q) q̇ + ∂x/∂t of x(q, t).
template <class Function, class Q, class Qdot, class... Time>
auto velocity_of(const Function& x, const Eigen::MatrixBase<Q>& q, const Eigen::MatrixBase<Qdot>& qdot, const Time&... t) {
  static_assert(sizeof...(Time) <= 1, "qdot: a position is a function of q, or of q and t");
  using S = detail::MotionScalar<Q, Qdot, Time...>;
  return detail::along_motion<S>(x, q, qdot, [](const auto& r, const auto& follow) { return detail::followed_rates<S>(r, follow); }, t...);
}

/// The acceleration ẍ = J q̈ + J̇ q̇ of x(q), by a dual number in a dual number.
///
/// With q̈ from Lagrange's equations, m ẍ − (applied force) is the reaction on the point.
template <class Function, class Q, class Qdot, class Qddot>
auto acceleration_of(const Function& x, const Eigen::MatrixBase<Q>& q, const Eigen::MatrixBase<Qdot>& qdot,
                     const Eigen::MatrixBase<Qddot>& qddot) {
  const auto velocity = [&x](const auto& both) {
    const Eigen::Index n = both.size() / 2;
    return velocity_of(x, both.head(n), both.tail(n));
  };
  using S = std::decay_t<decltype(std::declval<detail::MotionScalar<Q, Qdot>>() + qddot[0])>;
  Vector<S, Dynamic> state(2 * q.size()), rate(2 * q.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    state[i] = q[i];
    state[q.size() + i] = qdot[i];
    rate[i] = qdot[i];
    rate[q.size() + i] = qddot[i];
  }
  return velocity_of(velocity, state, rate);
}

#if defined(__clang__) && defined(__OPTIMIZE__)
#pragma clang attribute pop
#endif

}  // namespace qdot
