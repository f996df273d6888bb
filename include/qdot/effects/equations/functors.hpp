#pragma once
// SPDX-License-Identifier: MIT
//
// How the functors of effects are called: positions, poses and constraints of q or (q, t), forces and laws of (q, q̇) or (q, q̇, t). Each of
// them may also be constant.

#include <cmath>
#include <type_traits>

#include "qdot/ad/formula/hashed.hpp"
#include "qdot/ad/formula/recording.hpp"
#include "qdot/ad/forward/functor_result.hpp"
#include "qdot/ad/unroll.hpp"
#include "qdot/effects/effect.hpp"
#include "qdot/error.hpp"

namespace qdot::formula {
class Recorded;  // ad/formula/recording.hpp
}

namespace qdot::detail {

struct SlopeOfEffect {};  // the tag of the perturbations by which generalized forces are found

// The functors of effects are asked for their longest form: f(q, qdot, t) before f(q, qdot). It is asked of every scalar; a time that
// is a double would be there for numbers and not for their derivatives.
template <class F, class... Before>
consteval bool require_time_of_scalar() {
  static_assert(!detail::is_callable<const F&, const Before&..., double>,
                "qdot: the functor of an effect takes the time as a double, but the time carries derivatives as q does: take `const auto& t`, "
                "or `S t = S(0)` in a template <class S>; a parameter that is a double is a member or a capture");
  return true;
}

// Whether a functor is a template, or takes what can become its arguments' type. A call operator that is no template takes the numbers that it names and
// nothing else, though Eigen lets any vector look convertible to theirs.
template <class F>
inline constexpr bool is_generic = std::is_class_v<F> && !requires { &F::operator(); };
// A functor of plain numbers is not shown those that record.
template <class F, class S>
inline constexpr bool may_take = !(std::is_same_v<S, formula::Recorded> || std::is_same_v<S, formula::Hashed>) || is_generic<F> || std::is_arithmetic_v<F> ||
                                 requires { F::RowsAtCompileTime; };

#if defined(__clang__) && defined(__OPTIMIZE__)  // ad/forward/functor_result.hpp says why
#pragma clang attribute push(__attribute__((always_inline)), apply_to = function)
#endif

// f(q, qdot, t) or f(q, qdot), whichever the user wrote.
template <class F, class Q, class Qdot, class S>
auto of_state(const F& f, const Q& q, const Qdot& qdot, const S& t) {
  if constexpr (detail::is_callable<const F&, const Q&, const Qdot&, const S&>) {
    return result_of(f, q, qdot, t);
  } else {
    static_assert(require_time_of_scalar<F, Q, Qdot>());
    static_assert(detail::is_callable<const F&, const Q&, const Qdot&>,
                  "qdot: the functor of an effect must be callable as f(q, qdot, t) or f(q, qdot) for every scalar: take `const auto&`, and say "
                  "`using std::cos;` before `cos(q[0])`");
    return result_of(f, q, qdot);
  }
}

// f(q, t) or f(q), or a vector that does not depend on either: a fixed point.
template <class F, class Q, class S>
auto of_position(const F& f, const Q& q, const S& t) {
  if constexpr (requires { F::RowsAtCompileTime; }) {
    return Vector<S, F::RowsAtCompileTime>(f.template cast<S>());
  } else if constexpr (detail::is_callable<const F&, const Q&, const S&>) {
    return result_of(f, q, t);
  } else {
    static_assert(require_time_of_scalar<F, Q>());
    static_assert(detail::is_callable<const F&, const Q&>,
                  "qdot: a position, pose or constraint must be callable as f(q, t) or f(q) for every scalar: take `const auto& q`, and say "
                  "`using std::cos;` before `cos(q[0])`");
    return result_of(f, q);
  }
}

// f(t), or a vector that does not depend on it.
template <class F, class S>
auto of_time(const F& f, const S& t) {
  if constexpr (requires { F::RowsAtCompileTime; }) {
    return Vector<S, F::RowsAtCompileTime>(f.template cast<S>());
  } else {
    static_assert(detail::is_callable<const F&, const S&>,
                  "qdot: what depends on time must be callable as f(t) for every scalar: take `const auto& t`");
    return result_of(f, t);
  }
}

// Distance of two points.
template <class First, class Second, class Q, class S>
S distance_of(const First& first, const Second& second, const Q& q, const S& t) {
  using std::sqrt;
  const auto a = of_position(first, q, t);
  const auto b = of_position(second, q, t);
  S sum(-0.0);  // the zero that adds nothing
  const auto add = [&](auto i) __attribute__((always_inline)) {
    const S d = S(a[i]) - S(b[i]);
    sum = sum + d * d;
  };
  constexpr int axes = decltype(a)::SizeAtCompileTime, others = decltype(b)::SizeAtCompileTime;
  static_assert(axes == others || axes == Dynamic || others == Dynamic,
                "qdot: both ends of a spring, a damper, a rope or a tension must have as many coordinates: between a point in a plane and one in space "
                "there is no distance");
  if constexpr (axes == Dynamic) {
    for (Eigen::Index i = 0; i < a.size(); ++i) add(i);
  } else {
    unroll<axes>(add);
  }
  return sqrt(sum);
}

// A functor of (q, t) with t held at a number: what duals of q alone are sent through.
template <class F, class S>
auto at_time(const F& f, const S& t) {
  return [&f, t](const auto& q) {
    using D = typename std::remove_cvref_t<decltype(q)>::Scalar;
    return of_position(f, q, D(t));
  };
}

// The vector of `entries` scalars S, whatever scalar or vector the user's functor returned as `what`.
template <class S, int n, class Result>
Vector<S, n> force_vector(const Result& result, [[maybe_unused]] Eigen::Index entries, [[maybe_unused]] const char* what) {
  if constexpr (requires { Result::RowsAtCompileTime; }) {
    constexpr int known = Result::RowsAtCompileTime;
    static_assert(Result::ColsAtCompileTime == 1 && (known == n || known == Dynamic || n == Dynamic),
                  "qdot: a generalized force must have an entry for each coordinate, a force at a point one for each of the point's, "
                  "a controller's rate one for each of its states");
    if constexpr (known != n || n == Dynamic) {
      if (result.rows() != entries)
        throw DimensionError(what, static_cast<long>(entries), static_cast<long>(result.rows()),
                             "return as many entries as there are coordinates (of the point, for a force at a point)");
    }
    return result.template cast<S>();
  } else {
    static_assert(n == 1, "qdot: a force on more than one coordinate must be returned as a vector");
    return Vector<S, n>(S(result));
  }
}

#if defined(__clang__) && defined(__OPTIMIZE__)
#pragma clang attribute pop
#endif

}  // namespace qdot::detail
