#pragma once
// SPDX-License-Identifier: MIT
//
// Does an effect fit its system?
//
// What the compiler sees, it refuses: a force on three coordinates in a system of two, a constraint that returns a matrix.
// What it can't see is asked for once, when the scene is made,
//
//     require_fit(q)      a role that an effect may have: throws where it can't act on so many coordinates,
//
// or counted: a constraint functor whose result has a length known at run time only must keep to one number of rows, since
// sizes are fixed before the run. It is the number that the constraint declares, holonomic<3>("loop", phi), or else the one
// that it returns at q = 0 when the scene is made. Every later result is compared with it before it is copied anywhere.
// Where lengths are part of the types there is nothing to count and nothing to compare.

#include <array>
#include <cstddef>
#include <string>
#include <tuple>
#include <type_traits>

#include "qdot/ad/dual.hpp"
#include "qdot/ad/vector.hpp"
#include "qdot/effects/effect.hpp"
#include "qdot/error.hpp"

namespace qdot {

/// The number of rows of a constraint that does not declare one.
inline constexpr int rows_as_returned = 0;

namespace detail {

// Coordinate k of n must exist.
inline void require_coordinate(const std::string& who, Eigen::Index k, Eigen::Index n) {
  if (k >= 0 && k < n) return;
  throw InvalidValue(sentence({"an effect can only act on a coordinate of its system, 0 to ", n - 1, ", but ", who, " is given coordinate ", k,
                               "; count coordinates from 0"}));
}

[[noreturn]] inline void throw_changed_rows(const std::string& name, Eigen::Index counted, Eigen::Index returned, double t) {
  throw ConstraintError(name, t, 0.0,
                        sentence({"a constraint must have the same number of rows in every state, but '", name, "' had ", counted,
                                  " at q = 0 when the scene was made, and returned ", returned, " at t = ", std::to_string(t),
                                  "; return a row for each condition at all times"}));
}

// The rows of a constraint that declares how many it has.
template <int rows, class Result, class S>
auto declared_rows(const Result& result, const std::string& name, const S& t) {
  const auto returned = as_rows(result);
  using Returned = std::remove_cvref_t<decltype(returned)>;
  static_assert(Returned::RowsAtCompileTime == rows || Returned::RowsAtCompileTime == Dynamic,
                "qdot: this constraint returns another number of rows than it declares");
  if (returned.size() != rows) {
    const double at = static_cast<double>(innermost_value(t));
    throw ConstraintError(name, at, 0.0,
                          sentence({"a constraint must have as many rows as it declares, but '", name, "' declares ", rows, " and returned ",
                                    returned.size(), " at t = ", std::to_string(at), "; make the two agree"}));
  }
  return Vector<typename Returned::Scalar, rows>(returned);
}

// Compares the rows that an effect returned with those that the scene has counted.
template <class Effect, class Rows, class S>
void require_rows(const Effect& e, const Rows& returned, Eigen::Index counted, const S& t) {
  if constexpr (Rows::RowsAtCompileTime == Dynamic)
    if (returned.size() != counted)
      throw_changed_rows(constraint_name(e), counted, returned.size(), static_cast<double>(innermost_value(t)));
}

template <int n, class Effect>
Eigen::Index counted_rows(const Effect& e, const Vector<double, n>& q) {
  constexpr int known = constraint_rows_of<Effect, n>();
  if constexpr (known != Dynamic) {
    return known;
  } else if constexpr (HolonomicEffect<Effect, n>) {
    return as_rows(e.phi(q, 0.0)).size();
  } else {
    return as_rows(e.velocity_constraint(q, q, 0.0)).size();
  }
}

// How many rows each constraint effect of a scene has, counted when it is made.
template <bool counted, std::size_t effects>
struct RowCounts {
  std::array<Eigen::Index, effects> each{};  // of the constraint effects, in order
  Eigen::Index total = 0;

  template <int n, class... Effects>
  void count(const std::tuple<Effects...>& all, const Vector<double, n>& q) {
    std::size_t k = 0;
    const auto add = [&](const auto& e) {
      if constexpr (ConstraintEffect<std::remove_cvref_t<decltype(e)>, n>) total += each[k++] = counted_rows<n>(e, q);
    };
    std::apply([&](const auto&... e) { (add(e), ...); }, all);
  }
};
template <std::size_t effects>
struct RowCounts<false, effects> {  // all known to the compiler
  template <int n, class... Effects>
  void count(const std::tuple<Effects...>&, const Vector<double, n>&) {}
};

}  // namespace detail
}  // namespace qdot
