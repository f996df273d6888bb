#pragma once
// SPDX-License-Identifier: MIT
//
// T and V run by the compiler.
//
// What is run must be an object, and the compiler has none but the class. If all members have default values that is one; if not, bytes of
// numbers are taken for one, which lambdas that capture doubles are. A second object with other numbers tells parameters from
// literals (ad/formula/trace_list.hpp).

#include <array>
#include <bit>
#include <cstddef>
#include <type_traits>

#include "qdot/ad/formula/trace_list.hpp"
#include "qdot/mechanics/equations/energy_functors.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot::detail {

// An object that consists of numbers, with numbers that differ from each other and from example to example.
template <class E, int which>
  requires(std::is_trivially_copyable_v<E> && sizeof(E) % sizeof(double) == 0)
constexpr E object_of_numbers() {
  std::array<double, sizeof(E) / sizeof(double)> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = which == 0 ? 0.75 + static_cast<double>(i) / 128.0 : 0.61 + static_cast<double>(i) / 97.0;
  return std::bit_cast<E>(numbers);
}

template <class E, int which>
concept ConsistsOfNumbers = !std::is_empty_v<E> && requires { typename std::bool_constant<((void)object_of_numbers<E, which>(), true)>; };
template <class E>
concept HasDefault = requires { typename std::bool_constant<((void)E{}, true)>; };

// Objects to be run by the compiler: 0 is as the user meets it, 1 another one.
template <class E>
struct Example {
  static constexpr bool exists = HasDefault<E> || ConsistsOfNumbers<E, 0>;
  static constexpr bool another_exists = std::is_empty_v<E> || ConsistsOfNumbers<E, 1>;
  template <int which>
  static constexpr E object() {
    if constexpr ((which == 0 || std::is_empty_v<E>) && HasDefault<E>) {
      return E{};
    } else {
      return object_of_numbers<E, which>();
    }
  }
};
template <class Kinetic, class Potential>
struct Example<KineticAndPotential<Kinetic, Potential>> {
  static constexpr bool exists = Example<Kinetic>::exists && Example<Potential>::exists;
  static constexpr bool another_exists = Example<Kinetic>::another_exists && Example<Potential>::another_exists;
  template <int which>
  static constexpr KineticAndPotential<Kinetic, Potential> object() {
    return {Example<Kinetic>::template object<which>(), Example<Potential>::template object<which>()};
  }
};

// Objects whose parameters lie in themselves: of a pointer or a reference the compiler knows no bits.
template <class E>
constexpr auto bits_of_example() {
  return std::bit_cast<std::array<std::byte, sizeof(E)>>(Example<E>::template object<0>());
}
template <class E>
concept HoldsItsParameters = std::is_empty_v<E> || (std::is_trivially_copyable_v<E> &&
                                                    requires { typename std::bool_constant<((void)bits_of_example<E>(), true)>; });

enum class Energy { T, V };

// A run of T or V. The inputs are q, q̇ and t, whether it reads them or not.
template <int n, Energy energy, class E>
constexpr void record(const E& e, trace::Recording& ordered) {
  trace::Recording run;
  run.inputs = 2 * n + 1;
  trace::TracedVector<n> q{}, qdot{};
  for (int i = 0; i < n; ++i) {
    q.entries[i] = trace::Traced(run, i);
    qdot.entries[i] = trace::Traced(run, n + i);
  }
  const trace::Traced t(run, 2 * n);
  trace::Traced result;
  if constexpr (energy == Energy::T) {
    if constexpr (kinetic_signature<E, n>() == KineticSignature::velocity) {
      result = e.T(qdot);
    } else if constexpr (kinetic_signature<E, n>() == KineticSignature::state) {
      result = e.T(q, qdot);
    } else {
      result = e.T(q, qdot, t);
    }
  } else {
    if constexpr (potential_signature<E, n>() == PotentialSignature::position) {
      result = e.V(q);
    } else {
      result = e.V(q, t);
    }
  }
  run.result = result.operand_in(run);
  run.put_in_order(ordered);
}

struct ExtentOfRun {
  int steps, constants;
  bool branches, too_long;
};
template <int n, Energy energy, class E, int which>
constexpr ExtentOfRun extent_of_run() {
  trace::Recording run;
  record<n, energy>(Example<E>::template object<which>(), run);
  return {run.steps, run.constants, run.branches, run.too_long};
}
template <int n, Energy energy, class E, int which>
concept RunsWhileCompiling = requires { typename std::bool_constant<(extent_of_run<n, energy, E, which>(), true)>; };

template <int n, Energy energy, class E>
constexpr auto list_of_operations() {
  constexpr ExtentOfRun extent = extent_of_run<n, energy, E, 0>();
  trace::Recording run;
  record<n, energy>(Example<E>::template object<0>(), run);
  constexpr bool has_another = [] {
    if constexpr (Example<E>::another_exists) {
      return RunsWhileCompiling<n, energy, E, 1>;
    } else {
      return false;
    }
  }();
  if constexpr (has_another) {
    trace::Recording other;
    record<n, energy>(Example<E>::template object<1>(), other);
    return trace::List<extent.steps, extent.constants>(run, &other);
  } else {
    return trace::List<extent.steps, extent.constants>(run, nullptr);
  }
}

}  // namespace qdot::detail
