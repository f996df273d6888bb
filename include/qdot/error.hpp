#pragma once
// SPDX-License-Identifier: MIT
//
// Errors: what a mechanical model can get wrong, each with a type of its own.
//
// Every message says three things in this order: the rule that was broken, the values that
// broke it, and what to do about it. A user that only reads `what()` can act on it; code that reacts to it catches the type and
// reads its members.
//
// Two kinds of trouble are kept apart. An *error* is an exception from this file: the model or
// a call is wrong, and there is nothing to return. An *outcome* (integrate/outcome.hpp) is how
// a run ended: the trajectory up to the last good step comes back with it.
//
// Both rest on NaN and infinity, which mark failed results. Options that let the compiler assume that there are none remove every such
// check, so they are refused. So is the reordering of sums, which removes the compensation of rounding.

#if defined(min) || defined(max)
#error "qdot: min and max are macros here, as <windows.h> makes them, and would change those of the library: define NOMINMAX in front of it"
#endif

#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdio>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) || defined(__ASSOCIATIVE_MATH__) || defined(_M_FP_FAST)
#error "qdot: -ffast-math, -Ofast, -ffinite-math-only and -fassociative-math make NaN pass for a number and sums lose their digits; compile without them, or add -fno-fast-math for the files that include qdot"
#endif

namespace qdot {

namespace detail {

// A phrase of a message: words, or a number. Two words of memory each, since there are many of them in many places.
struct Phrase {
  Phrase(const char* text) : words(text), form(whole) {}
  Phrase(std::string_view text) : words(text.data()), form(static_cast<std::ptrdiff_t>(text.size())) {}
  Phrase(const std::string& text) : words(text.data()), form(static_cast<std::ptrdiff_t>(text.size())) {}
  Phrase(double x, int significant = 10) : number(x), form(-significant) {}
  template <std::integral Integer>
  Phrase(Integer i) : count(static_cast<long long>(i)), form(counted) {}

  static constexpr std::ptrdiff_t whole = -1000, counted = -1001;
  union {
    const char* words;
    double number;
    long long count;
  };
  std::ptrdiff_t form;  // how many characters, or minus how many digits, or `whole` of words to their end, or `counted`
};

// The phrases one after the other. A function of its own, so that the many places that may have to complain cost the compiler little.
template <class = void>
[[gnu::cold, gnu::noinline]] std::string sentence(std::initializer_list<Phrase> phrases) {
  std::string text;
  char digits[32];
  for (const Phrase& phrase : phrases) {
    const char* words = digits;
    if (phrase.form >= 0 || phrase.form == Phrase::whole) {
      words = phrase.words;
    } else if (phrase.form == Phrase::counted) {
      std::snprintf(digits, sizeof digits, "%lld", phrase.count);
    } else {
      std::snprintf(digits, sizeof digits, "%.*g", static_cast<int>(-phrase.form), phrase.number == phrase.number ? phrase.number : NAN);  // without a sign
    }
    text.append(words, phrase.form >= 0 ? static_cast<std::size_t>(phrase.form) : std::char_traits<char>::length(words));
  }
  return text;
}

// The name of an enumerator, from those of all in their order.
template <class Enumeration>
constexpr const char* name_in(std::initializer_list<const char*> names, Enumeration of) noexcept {
  const auto place = static_cast<std::size_t>(of);
  return place < names.size() ? names.begin()[place] : "unknown";
}

}  // namespace detail

/// Base of every exception that the library itself throws.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A vector or matrix has a size that disagrees with the number of coordinates.
class DimensionError : public Error {
 public:
  /// @param subject   what has the wrong size, e.g. "qdot"
  /// @param expected  the size that the rule asks for
  /// @param actual    the size that was given
  /// @param remedy    what to change
  [[gnu::cold, gnu::noinline]] DimensionError(std::string_view subject, long expected, long actual, std::string_view remedy)
      : Error(detail::sentence({subject, " must have ", expected, expected == 1 ? " entry" : " entries", ", but has ", actual, "; ", remedy})),
        expected_(expected),
        actual_(actual) {}

  /// The size that the rule asks for.
  long expected() const noexcept { return expected_; }
  /// The size that was given.
  long actual() const noexcept { return actual_; }

 private:
  long expected_;
  long actual_;
};

/// A number or an option is outside its range: NaN in a state, a negative tolerance, a mass of zero.
class InvalidValue : public Error {
 public:
  using Error::Error;
};

namespace detail {

template <class = void>
[[noreturn, gnu::cold, gnu::noinline]] void throw_invalid_value(std::initializer_list<Phrase> message) {
  throw InvalidValue(sentence(message));
}

#ifdef QDOT_COMPILED
extern template std::string sentence<void>(std::initializer_list<Phrase>);
extern template void throw_invalid_value<void>(std::initializer_list<Phrase>);
#endif

}  // namespace detail

/// An evaluation of the model gave infinity or NaN.
class NonFinite : public Error {
 public:
  /// @param component  the name of the first offending quantity, e.g. "the acceleration of phi"
  /// @param t          the time at which it appeared
  NonFinite(std::string component, double t, const std::string& message)
      : Error(message), component_(std::move(component)), t_(t) {}

  /// Its name.
  const std::string& component() const noexcept { return component_; }
  /// Where it happened.
  double t() const noexcept { return t_; }

 private:
  std::string component_;
  double t_;
};

/// M(q, q̇) has no usable inverse: some direction of motion has no inertia, or a negative one.
class MassMatrixError : public Error {
 public:
  /// @param direction  coordinate weights of the offending direction, length n, largest weight 1
  /// @param inertia    directionᵀ M direction / |direction|² with every coordinate scaled to unit inertia
  MassMatrixError(const std::string& message, double t, std::vector<double> direction, double inertia)
      : Error(message), t_(t), direction_(std::move(direction)), inertia_(inertia) {}

  /// Where it happened.
  double t() const noexcept { return t_; }
  /// Coordinate weights of the offending direction, n, the largest of them 1.
  const std::vector<double>& direction() const noexcept { return direction_; }
  /// Relative inertia of that direction: 0 for none, negative where T is no kinetic energy.
  double inertia() const noexcept { return inertia_; }

 private:
  double t_;
  std::vector<double> direction_;
  double inertia_;
};

/// M is singular to working precision: a direction of motion without inertia.
class SingularMassMatrix : public MassMatrixError {
 public:
  using MassMatrixError::MassMatrixError;
};

/// M is regular but not positive definite: T is no kinetic energy.
class IndefiniteMassMatrix : public MassMatrixError {
 public:
  using MassMatrixError::MassMatrixError;
};

/// Constraints contradict each other, or cannot be met from where the system is.
class ConstraintError : public Error {
 public:
  /// @param constraint  name of the row that is worst off
  /// @param residual    by how much it is missed
  ConstraintError(std::string constraint, double t, double residual, const std::string& message)
      : Error(message), constraint_(std::move(constraint)), t_(t), residual_(residual) {}

  /// Name of the row that is worst off.
  const std::string& constraint() const noexcept { return constraint_; }
  /// Where it happened.
  double t() const noexcept { return t_; }
  /// By how much that row is missed.
  double residual() const noexcept { return residual_; }

 private:
  std::string constraint_;
  double t_;
  double residual_;
};

/// T, V, a force or a constraint is not one formula where one is needed: it compares values, has a kink or asks for a plain number.
class NotAnalytic : public Error {
 public:
  NotAnalytic(const std::string& what, std::string source) : Error(what), source_(std::move(source)) {}

  /// What it is: "T or V", or "the force of an effect".
  const std::string& source() const noexcept { return source_; }

 private:
  std::string source_;
};

/// Thrown by a user's functor (or by an effect) to ask the stepper for a smaller step.
///
/// Any other exception ends the run and reaches the caller of the run unchanged.
class RecoverableError : public Error {
 public:
  using Error::Error;
};

}  // namespace qdot
