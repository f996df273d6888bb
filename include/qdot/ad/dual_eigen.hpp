#pragma once
// SPDX-License-Identifier: MIT
//
// Dual numbers inside Eigen: vectors and matrices of duals, fixed or dynamic, compute like those of
// plain numbers.
//
// Eigen asks two things of a scalar. NumTraits says how it behaves: here like a real number without
// SIMD packets, whose constructor must run and whose precision is that of the number inside.
// ScalarBinaryOpTraits gives the type of a mixed product. A dual times a plain number is a dual, so `m * v` with a double m and a
// vector v of duals needs no cast.

#include <type_traits>

#include <Eigen/Core>

#include "qdot/ad/dual_math.hpp"

namespace qdot::detail {

// The plain number under any depth of duals, which is all that may stand beside a dual in Eigen.
template <class Number, class D>
concept EigenConstantBeside = ConstantBeside<Number, typename D::Scalar, D> || std::is_same_v<Number, typename D::Scalar>;

}  // namespace qdot::detail

template <class S, int N, class Tag>
struct Eigen::NumTraits<qdot::Dual<S, N, Tag>> : Eigen::NumTraits<S> {
  using Real = qdot::Dual<S, N, Tag>;
  using NonInteger = Real;
  using Nested = Real;
  using Literal = typename Eigen::NumTraits<S>::Literal;
  enum {
    IsInteger = 0,
    IsSigned = 1,
    IsComplex = 0,
    RequireInitialization = 1,
    ReadCost = (N + 1) * Eigen::NumTraits<S>::ReadCost,
    AddCost = (N + 1) * Eigen::NumTraits<S>::AddCost,
    MulCost = (2 * N + 1) * Eigen::NumTraits<S>::MulCost
  };
  static Real epsilon() { return Real(Eigen::NumTraits<S>::epsilon()); }
  static Real dummy_precision() { return Real(Eigen::NumTraits<S>::dummy_precision()); }
  static Real highest() { return Real(Eigen::NumTraits<S>::highest()); }
  static Real lowest() { return Real(Eigen::NumTraits<S>::lowest()); }
  static Real infinity() { return Real(Eigen::NumTraits<S>::infinity()); }
  static Real quiet_NaN() { return Real(Eigen::NumTraits<S>::quiet_NaN()); }
};

template <class S, int N, class Tag, class Number, class Operation>
  requires qdot::detail::EigenConstantBeside<Number, qdot::Dual<S, N, Tag>>
struct Eigen::ScalarBinaryOpTraits<qdot::Dual<S, N, Tag>, Number, Operation> {
  using ReturnType = qdot::Dual<S, N, Tag>;
};

template <class S, int N, class Tag, class Number, class Operation>
  requires qdot::detail::EigenConstantBeside<Number, qdot::Dual<S, N, Tag>>
struct Eigen::ScalarBinaryOpTraits<Number, qdot::Dual<S, N, Tag>, Operation> {
  using ReturnType = qdot::Dual<S, N, Tag>;
};

namespace qdot {

/// x itself: duals are real. One of the names that Eigen looks up.
template <class S, int N, class Tag>
const Dual<S, N, Tag>& conj(const Dual<S, N, Tag>& x) {
  return x;
}
/// x itself.
template <class S, int N, class Tag>
const Dual<S, N, Tag>& real(const Dual<S, N, Tag>& x) {
  return x;
}
/// Zero.
template <class S, int N, class Tag>
Dual<S, N, Tag> imag(const Dual<S, N, Tag>&) {
  return Dual<S, N, Tag>{};
}
/// x².
template <class S, int N, class Tag>
Dual<S, N, Tag> abs2(const Dual<S, N, Tag>& x) {
  return x * x;
}

}  // namespace qdot
