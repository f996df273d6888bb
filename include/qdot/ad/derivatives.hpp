#pragma once
// SPDX-License-Identifier: MIT
//
// Derivatives of a function, without writing the word dual.
//
//     gradient(f, x)   ∇f          f: ℝⁿ → ℝ        n entries
//     jacobian(f, x)   ∂f/∂x       f: ℝⁿ → ℝᵐ       m × n
//     hessian(f, x)    ∂²f/∂x∂x    f: ℝⁿ → ℝ        n × n, symmetric
//     derivative(f, s) df/ds       f: ℝ → anything that is linear in duals
//
// f is generic: it is called with a vector of duals in place of x and must return the scalar (or a
// vector of the scalar) that it was given. The seeds e₁, …, e_n go through f together when n is
// known at compile time; a vector of run-time length goes through in passes of `chunk` directions,
// so that no dual ever allocates.
//
// x may itself hold duals: the result is then a dual, differentiated once more. Each call marks its
// duals by the type of f, so that an ε of one call cannot be taken for the ε of another.

#include <algorithm>
#include <type_traits>
#include <utility>

#include "qdot/ad/dual_eigen.hpp"
#include "qdot/ad/forward/functor_result.hpp"
#include "qdot/ad/unroll.hpp"
#include "qdot/ad/vector.hpp"

namespace qdot {

/// Directions carried per pass when the number of variables is known only at run time.
inline constexpr int chunk = 8;

namespace detail {

template <class F>
struct DerivativeOf {};  // the tag of one function's perturbations
template <class Tag>
struct SecondSlope {};   // and of those of its gradient

// A function of the library's own whose perturbations bear the tag of its kind. So there are as many types of duals as there are kinds, and
// not as many as users' functors, for which the compiler would generate the same arithmetic again. What is differentiated inside is nested
// deeper, which is a type of its own.
template <class Tag, class F>
struct Marked : F {};
template <class Tag, class F>
Marked<Tag, F> marked(F f) {
  return {std::move(f)};
}
template <class F>
struct tag_of {
  using type = DerivativeOf<F>;
};
template <class Tag, class F>
struct tag_of<Marked<Tag, F>> {
  using type = Tag;
};

template <int n>
inline constexpr int directions_for = n == Dynamic || n > 2 * chunk ? chunk : n;

// x + Σ ε_k e_{first+k}: a copy of x as duals with `D::directions` seeds from `first` on.
template <class D, class S, int n>
Vector<D, n> seeded(const Vector<S, n>& x, Eigen::Index first) {
  Vector<D, n> seeds(x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    seeds[i] = D(x[i]);
    const Eigen::Index k = i - first;
    if (k >= 0 && k < D::directions) seeds[i].tangent[static_cast<std::size_t>(k)] = typename D::Scalar(1);
  }
  return seeds;
}

template <int n, class Visit>
[[gnu::always_inline]] inline void for_each_entry(Eigen::Index size, const Visit& visit) {
  if constexpr (n == Dynamic)
    for (int i = 0; i < size; ++i) visit(i);
  else
    detail::unroll<n>(visit);
}
// Arguments of a function whose derivatives are hashes.
template <class S, int n>
Vector<S, n> marked_arguments(const Vector<S, n>& x) {
  Vector<S, n> marked(x.size());
  for_each_entry<n>(x.size(), [&](int i) __attribute__((always_inline)) { marked.data()[i] = S::argument(x.data()[i], i); });
  return marked;
}

}  // namespace detail

/// f(x) and ∇f(x) of a scalar function.
template <class S, int n>
struct ValueAndGradient {
  S value;                ///< f(x)
  Vector<S, n> gradient;  ///< ∂f/∂x, n
};

/// f(x) and ∇f(x); one evaluation of f for fixed n, ⌈n/chunk⌉ for run-time n.
///
/// @param f  generic scalar function of a vector
/// @param x  the point, n
template <class F, class Derived>
auto value_and_gradient(F&& f, const Eigen::MatrixBase<Derived>& x) {
  using S = typename Derived::Scalar;
  constexpr int n = Derived::RowsAtCompileTime;
  using D = Dual<S, detail::directions_for<n>, typename detail::tag_of<std::remove_cvref_t<F>>::type>;
  static_assert(Derived::ColsAtCompileTime == 1, "qdot: the point of a gradient must be a column vector");
  const Vector<S, n> at = x;
  static_assert(detail::require_real<S>());
  ValueAndGradient<S, n> result{S(0), Vector<S, n>(at.size())};
  if (at.size() == 0) return result;
  if constexpr (detail::is_hash<S>) {
    const S y = f(detail::marked_arguments(at));
    result.value = S::digest(y, 0);
    detail::for_each_entry<n>(at.size(), [&](int i) __attribute__((always_inline)) { result.gradient.data()[i] = S::digest(y, i + 1); });
    return result;
  } else {
    for (Eigen::Index first = 0; first < at.size(); first += D::directions) {
      const Vector<D, n> seeds = detail::seeded<D>(at, first);
      static_assert(std::is_same_v<std::remove_cvref_t<decltype(f(seeds))>, D>,
                    "qdot: the function must return the scalar type of its argument (write it for "
                    "`const auto& x` and return an expression of x's entries, not a double)");
      const D y = f(seeds);
      result.value = y.value;
      const Eigen::Index end = std::min<Eigen::Index>(at.size(), first + D::directions);
      for (Eigen::Index i = first; i < end; ++i) result.gradient[i] = y.tangent[static_cast<std::size_t>(i - first)];
    }
    return result;
  }
}

/// ∇f(x) of a generic scalar function f; costs as value_and_gradient.
template <class F, class Derived>
auto gradient(F&& f, const Eigen::MatrixBase<Derived>& x) {
  return value_and_gradient(f, x).gradient;
}

/// f(x) and ∂f/∂x of a vector function.
template <class S, int m, int n>
struct ValueAndJacobian {
  Vector<S, m> value;        ///< f(x), m
  Matrix<S, m, n> jacobian;  ///< ∂f/∂x, m×n
};

/// f(x), m entries, and ∂f/∂x, m×n; one evaluation of f for fixed n, ⌈n/chunk⌉ for run-time n.
///
/// @param f  generic function that returns an Eigen column (fixed or dynamic) of its argument's scalar
/// @param x  the point, n
template <class F, class Derived>
auto value_and_jacobian(F&& f, const Eigen::MatrixBase<Derived>& x) {
  using S = typename Derived::Scalar;
  constexpr int n = Derived::RowsAtCompileTime;
  using D = Dual<S, detail::directions_for<n>, typename detail::tag_of<std::remove_cvref_t<F>>::type>;
  static_assert(Derived::ColsAtCompileTime == 1, "qdot: the point of a Jacobian must be a column vector");
  using Argument = std::conditional_t<detail::is_hash<S>, S, D>;
  using Returned = std::remove_cvref_t<decltype(f(std::declval<const Vector<Argument, n>&>()))>;
  static_assert(detail::require_real<S>());
  static_assert(detail::require_numbers<Returned>());
  static_assert(std::is_same_v<typename Returned::Scalar, Argument>,
                "qdot: the function must return a vector of the scalar type of its argument");
  constexpr int m = Returned::RowsAtCompileTime;
  const Vector<S, n> at = x;
  ValueAndJacobian<S, m, n> result;
  if constexpr (detail::is_hash<S>) {
    const Vector<S, m> y = f(detail::marked_arguments(at));
    result.value.resize(y.size());
    result.jacobian.resize(y.size(), at.size());
    for (Eigen::Index j = 0; j < y.size(); ++j) {
      result.value[j] = S::digest(y[j], 0);
      for (Eigen::Index i = 0; i < at.size(); ++i) result.jacobian(j, i) = S::digest(y[j], static_cast<int>(i) + 1);
    }
    return result;
  } else {
    for (Eigen::Index first = 0; first == 0 || first < at.size(); first += D::directions) {
      const Vector<D, m> y = f(detail::seeded<D>(at, first));
      if (first == 0) {
        result.value.resize(y.size());
        result.jacobian.resize(y.size(), at.size());
        for (Eigen::Index j = 0; j < y.size(); ++j) result.value[j] = y[j].value;
      }
      const Eigen::Index end = std::min<Eigen::Index>(at.size(), first + D::directions);
      for (Eigen::Index i = first; i < end; ++i)
        for (Eigen::Index j = 0; j < y.size(); ++j)
          result.jacobian(j, i) = y[j].tangent[static_cast<std::size_t>(i - first)];
    }
    return result;
  }
}

/// ∂f/∂x, m×n, of a generic vector function f; costs as value_and_jacobian.
template <class F, class Derived>
auto jacobian(F&& f, const Eigen::MatrixBase<Derived>& x) {
  return value_and_jacobian(f, x).jacobian;
}

/// ∂²f/∂x∂x, n×n and symmetric, of a generic scalar function f: the Jacobian of the gradient.
template <class F, class Derived>
auto hessian(F&& f, const Eigen::MatrixBase<Derived>& x) {
  using Tag = detail::SecondSlope<typename detail::tag_of<std::remove_cvref_t<F>>::type>;
  return jacobian(detail::marked<Tag>([&f](const auto& y) { return gradient(f, y); }), x);
}

/// df/ds of a function of one number: a scalar for a scalar f, an Eigen object for an Eigen f.
template <class F, class S>
auto derivative(F&& f, const S& s) {
  static_assert(detail::require_real<S>());
  using D = Dual<S, 1, typename detail::tag_of<std::remove_cvref_t<F>>::type>;
  using Argument = std::conditional_t<detail::is_hash<S>, S, D>;
  const auto y = [&] {
    if constexpr (detail::is_hash<S>) return detail::result_of(f, S::argument(s, 0));
    else return detail::result_of(f, D::variable(s, 0));
  }();
  using Y = std::remove_cvref_t<decltype(y)>;
  const auto slope_of = [](const auto& entry) {
    if constexpr (detail::is_hash<S>) return S::digest(entry, 1);
    else return entry.tangent[0];
  };
  if constexpr (std::is_same_v<Y, Argument>) {
    return slope_of(y);
  } else {
    static_assert(std::is_same_v<typename Y::Scalar, Argument>,
                  "qdot: the function must return the scalar type of its argument, or a matrix of it");
    Matrix<S, Y::RowsAtCompileTime, Y::ColsAtCompileTime> slope(y.rows(), y.cols());
    for (Eigen::Index j = 0; j < y.cols(); ++j)
      for (Eigen::Index i = 0; i < y.rows(); ++i) slope(i, j) = slope_of(y(i, j));
    return slope;
  }
}

}  // namespace qdot
