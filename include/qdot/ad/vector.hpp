#pragma once
// SPDX-License-Identifier: MIT
//
// Vectors and matrices of any scalar: thin names for Eigen's, sized at compile time where the
// number of coordinates is known, at run time (Dynamic) where it is not.
//
// Matrices are stored by columns, whatever a caller's are: columns are handed on as runs of numbers.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <type_traits>

#include "qdot/ad/unroll.hpp"
#include "qdot/error.hpp"

#if !EIGEN_VERSION_AT_LEAST(3, 4, 0)
#error "qdot: Eigen must be 3.4 or newer"
#endif

#ifdef EIGEN_DEFAULT_TO_ROW_MAJOR
// A program may make Eigen store matrices by rows by default; qdot's matrices are stored by columns all the same. Within namespace qdot, `Eigen` means this
// namespace. Code with `using namespace qdot` writes `::Eigen` for Eigen's own.
namespace qdot::Eigen {

using namespace ::Eigen;
template <class S, int rows, int columns, int options = rows == 1 && columns != 1 ? ::Eigen::RowMajor : ::Eigen::ColMajor, int most_rows = rows,
          int most_columns = columns>
using Matrix = ::Eigen::Matrix<S, rows, columns, options, most_rows, most_columns>;  ///< by columns, as all of these
using Matrix3d = Matrix<double, 3, 3>;                                               ///< 3×3
using MatrixXd = Matrix<double, Dynamic, Dynamic>;                                   ///< of any size
using MatrixXcd = Matrix<std::complex<double>, Dynamic, Dynamic>;                    ///< the same of complex numbers

}  // namespace qdot::Eigen
#endif

namespace qdot {

/// The number of coordinates is known only at run time.
inline constexpr int Dynamic = Eigen::Dynamic;

/// Column of n scalars; n may be Dynamic.
template <class S, int n>
using Vector = Eigen::Matrix<S, n, 1>;

/// Matrix of rows × columns scalars, square unless told otherwise; either may be Dynamic.
template <class S, int rows, int columns = rows>
using Matrix = Eigen::Matrix<S, rows, columns>;

namespace detail {

// A quotient or a sine of integers is an integer: 1/2 is 0, and −9.81 is −9.
template <class S>
consteval bool require_real() {
  static_assert(!std::is_integral_v<S>,
                "qdot: these numbers are integers, and so would be all that is computed from them: pass real numbers, Eigen::Vector2d(0, 1) "
                "instead of Eigen::Vector2i(0, 1), or 1.0 instead of 1");
  return true;
}

// True when none of `count` numbers is infinite or NaN; for Eigen's allFinite() the compiler makes five types of each vector's.
inline bool all_finite(const double* numbers, Eigen::Index count) {
  double zero = 0.0, others = 0.0;  // x − x of a number that is not finite is NaN; two sums, for one addition waits for that before it
  const Eigen::Index whole = count - count % 4;
  for (Eigen::Index i = 0; i < whole; i += 4) {
    zero += (numbers[i] - numbers[i]) + (numbers[i + 1] - numbers[i + 1]);
    others += (numbers[i + 2] - numbers[i + 2]) + (numbers[i + 3] - numbers[i + 3]);
  }
  for (Eigen::Index i = whole; i < count; ++i) zero += numbers[i] - numbers[i];
  return zero + others == 0.0;
}
template <int rows, int columns, int options>
bool all_finite(const Eigen::Matrix<double, rows, columns, options>& of) {
  return all_finite(of.data(), of.size());
}

// The largest |x| of `count` numbers, NaN where one is; 0 for none. In loops: Eigen's cwiseAbs().maxCoeff() is several types for each type of vector.
inline double largest(const double* numbers, Eigen::Index count) {
  double most = 0.0;
  for (Eigen::Index i = 0; i < count; ++i)
    if (!(std::abs(numbers[i]) <= most) && most == most) most = std::abs(numbers[i]);
  return most;
}
template <int rows, int columns, int options>
double largest(const Eigen::Matrix<double, rows, columns, options>& of) {
  return largest(of.data(), of.size());
}

// A vector or matrix of zeros. Eigen's Zero() is a type of its own for each type of matrix, and its assignment a dozen functions.
template <class V>
V zeros(Eigen::Index rows, Eigen::Index columns = 1) {
  V all;
  all.resize(rows, columns);
  std::fill_n(all.data(), all.size(), typename V::Scalar(0));
  return all;
}

// The entries of x as scalars D. Eigen's cast() is a type of its own, too.
template <class D, class S, int n>
Vector<D, n> converted(const Vector<S, n>& x) {
  Vector<D, n> all(x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) all.data()[i] = D(x.data()[i]);
  return all;
}

// The vector of `count` numbers. Of Eigen's map it would be a dozen functions, too.
template <int n, class S = double>
Vector<S, n> vector_at(const S* first, Eigen::Index count) {
  Vector<S, n> x;
  x.resize(count);
  std::copy_n(first, count, x.data());
  return x;
}

// Whether all numbers are finite, by their sum, which is not where one of them is not. Of packs for each. A sum begins with −0, the zero that adds
// nothing: 0 + x would have to be computed, for an x that is −0.
template <class Number>
[[gnu::always_inline]] inline auto is_finite(const Number& sum) {
  if constexpr (std::is_same_v<Number, double>) return static_cast<bool>(__builtin_isfinite(sum));
  else return sum - sum == 0.0;
}

// Numbers that will be read in pairs: a processor that finds a store narrower than the load waits for it.
template <int n>
[[gnu::always_inline]] inline void write_in_pairs(double* to, const double* from) {
  using Two = double __attribute__((vector_size(16)));
  unroll<n / 2>([&](auto k) __attribute__((always_inline)) {
    const Two two{from[2 * k], from[2 * k + 1]};
    __builtin_memcpy(to + 2 * k, &two, sizeof two);
  });
  if constexpr (n % 2 == 1) to[n - 1] = from[n - 1];
}

// Whether a factorization is one: its info() is Eigen::Success, a name that X11 makes a macro.
template <class Factors>
bool succeeded(const Factors& factors) {
  return factors.info() == Eigen::ComputationInfo{};
}

// The place of the largest |x|, the first of several; 0 for none.
inline Eigen::Index place_of_largest(const double* numbers, Eigen::Index count) {
  Eigen::Index place = 0;
  for (Eigen::Index i = 1; i < count; ++i)
    if (std::abs(numbers[i]) > std::abs(numbers[place])) place = i;
  return place;
}

}  // namespace detail

}  // namespace qdot
