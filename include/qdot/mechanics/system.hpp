#pragma once
// SPDX-License-Identifier: MIT
//
// A mechanical system is two functors, T and V, and a number of coordinates. Everything else is computed from these.
//
//     quantity                                 math                code             shape
//     coordinates, velocities, accelerations   q, q̇, q̈             q, qdot, qddot   n
//     kinetic, potential energy, Lagrangian    T, V, L = T − V     T, V, L          1
//     mass matrix, conjugate momenta           M, p = ∂L/∂q̇        M, p             n×n, n
//     generalized forces, Rayleigh function    Q = −∂R/∂q̇          Q, R             n, 1
//     constraints, Jacobian, multipliers       φ(q,t) = 0, J, λ    phi, J, lambda   m, m×n, m
//
// Every header obeys this notation and these signs. With constraints M q̈ = rhs + Jᵀλ, so that Jᵀλ is the force of the
// constraint *on* the system. Angles are in rad, everything else in whatever consistent units the user has.

#include <concepts>
#include <initializer_list>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/mechanics/by.hpp"
#include "qdot/mechanics/equations/energy_functors.hpp"
#include "qdot/mechanics/equations/kept_lines.hpp"

namespace qdot {

/// What a system's mass matrix is promised to be.
enum class Inertia {
  positive_definite,  ///< a true kinetic energy: anything else is an error (the default)
  indefinite          ///< only regular: for Lagrangians that are no kinetic energy minus potential
};

namespace detail {

// q or q̇ of a state. It takes {1.0} for one coordinate and {3, 1} for two that are counted at run time. Eigen's own vectors take
// the first for a size and the second for three rows and a column.
template <int n>
struct ListedVector : Vector<double, n> {
  using Numbers = std::conditional_t<n == Dynamic, std::initializer_list<double>, double>;

  ListedVector() = default;
  ListedVector(Numbers numbers)
    requires(n == 1)
  {
    (*this)[0] = numbers;
  }
  ListedVector(Numbers numbers)
    requires(n == Dynamic)
      : Vector<double, n>(Eigen::Map<const Vector<double, n>>(numbers.begin(), static_cast<Eigen::Index>(numbers.size()))) {}
  ListedVector(Vector<double, n>&& x) : Vector<double, n>(std::move(x)) {}
  template <class X>
  ListedVector(const Eigen::EigenBase<X>& x) : Vector<double, n>(x) {}
  using Vector<double, n>::operator=;
};

// What a system has beside its energies: one type for all of them.
struct SystemParts {
  Eigen::Index dof;
  std::vector<std::string> names{};  // of its coordinates; none where they are q0, q1, …
  KeptLines kept{};
};

template <int n>
using StateVector = std::conditional_t<n == 1 || n == Dynamic, ListedVector<n>, Vector<double, n>>;

}  // namespace detail

/// A time, a configuration and its velocity: State<1>{0.0, {1.0}, {0.0}}.
template <int n>
struct State {
  double t = 0.0;               ///< time
  detail::StateVector<n> q;     ///< coordinates, n
  detail::StateVector<n> qdot;  ///< velocities, n
};

/// Two energies and their coordinates.
///
/// Made by mechanical_system(). Holds the functors by value; copying it copies them. It and its copies share
/// equations that were derived from the functors and are checked at each use (mechanics/derive/kept_lines.hpp). One
/// system may be used from several threads as far as its functors allow.
///
/// @tparam Energies  object with callable members T and V
/// @tparam n         number of coordinates, or Dynamic
template <class Energies, int n, Inertia inertia_ = Inertia::positive_definite>
class System {
  static_assert(n == Dynamic || n >= 1, "qdot: a system needs at least one coordinate");

 public:
  static constexpr int dof_at_compile_time = n;                                                          ///< n, or Dynamic
  static constexpr Inertia inertia = inertia_;                                                           ///< what M is promised to be
  static constexpr KineticSignature kinetic_signature = detail::kinetic_signature<Energies, n>();        ///< what T is a function of
  static constexpr PotentialSignature potential_signature = detail::potential_signature<Energies, n>();  ///< what V is a function of

  /// True when neither energy mentions the time, so that Jacobi's energy function is conserved.
  static constexpr bool autonomous = kinetic_signature != KineticSignature::state_and_time &&
                                     potential_signature == PotentialSignature::position;

  using EnergiesType = Energies;  ///< the object with T and V

  System(Energies energies, Eigen::Index dof) : energies_(std::move(energies)), parts_{dof} {
    if (dof < 1)
      detail::throw_invalid_value({"the number of coordinates must be at least 1, but is ", dof,
                                   "; pass the length of q to mechanical_system(n, T, V)"});
  }
  /// A system of the same functions in another object, which shares the derived equations.
  System(Energies energies, const detail::SystemParts& parts) : energies_(std::move(energies)), parts_(parts) {}

  /// Number of coordinates.
  Eigen::Index dof() const noexcept {
    if constexpr (n == Dynamic) {
      return parts_.dof;
    } else {
      return n;
    }
  }
  /// All but the energies.
  const detail::SystemParts& parts() const noexcept { return parts_; }

  /// This system. Scenes have the same function, which returns the system with the terms of their effects in T and V.
  const System& system() const noexcept { return *this; }
  /// The object with T and V.
  const Energies& energies() const noexcept { return energies_; }

  /// Its derived equations: checked at each use, or a run's own.
  detail::KeptLines* kept_lines() const noexcept { return &parts_.kept; }
  void keep(const detail::KeptLines& lines) { parts_.kept = lines; }  ///< makes this object keep them

  /// A copy, all of whose evaluations go one way (mechanics/by.hpp).
  System by(By way) const {
    System other(*this);
    other.parts_.kept = detail::KeptLines(parts_.kept, way);
    return other;
  }

  /// The same system whose coordinates bear the user's names, for messages and tables.
  ///
  /// @throws DimensionError  unless there is one name for each coordinate
  System with_names(std::vector<std::string> names) const {
    if (static_cast<Eigen::Index>(names.size()) != dof())
      throw DimensionError("the list of coordinate names", static_cast<long>(dof()), static_cast<long>(names.size()),
                           "give one name for each coordinate");
    System named(*this);
    named.parts_.names = std::move(names);
    return named;
  }

  /// The same system for a Lagrangian whose M is regular but not positive definite.
  ///
  /// M is then factored with full pivoting instead of by Cholesky.
  auto with_indefinite_mass_matrix() const {
    System<Energies, n, Inertia::indefinite> other(energies_, dof());
    other.keep(detail::KeptLines(*other.kept_lines(), parts_.kept.by()));
    return parts_.names.empty() ? other : other.with_names(parts_.names);
  }

  /// Name of coordinate i: the user's, or q0, q1, …
  std::string coordinate_name(Eigen::Index i) const {
    return parts_.names.empty() ? detail::sentence({"q", i}) : parts_.names[static_cast<std::size_t>(i)];
  }

  /// Name of velocity i: the coordinate's with "dot" behind it.
  std::string velocity_name(Eigen::Index i) const {
    return parts_.names.empty() ? detail::sentence({"qdot", i}) : detail::sentence({coordinate_name(i), "dot"});
  }

 private:
  Energies energies_;
  mutable detail::SystemParts parts_;
};

/// A system, or a scene: what has T and V.
template <class M>
concept HasEnergies = requires(const M& model) {
  { M::dof_at_compile_time } -> std::convertible_to<int>;
  model.system().energies();
};

/// A vector with one entry for each coordinate of a system or scene.
template <class Sys>
using Coordinates = Vector<double, Sys::dof_at_compile_time>;

namespace detail {

template <int n, class E>
auto checked_system(E energies, Eigen::Index dof) {
  static_assert(require_energies<E, n>());
  return System<E, n>(std::move(energies), dof);
}

// Beyond this, a matrix of n × n is more than Eigen puts on the stack, and n is kept at run time.
inline constexpr int largest_fixed_size = 128;
template <int n>
inline constexpr int held_as = n > largest_fixed_size ? Dynamic : n;

}  // namespace detail

/// The system with n coordinates, n known at compile time, and energies T and V. With more than 128 its vectors are of dynamic size, as
/// of the system below.
template <int n, class Kinetic, class Potential>
auto mechanical_system(Kinetic T, Potential V) {
  return detail::checked_system<detail::held_as<n>>(KineticAndPotential<Kinetic, Potential>{std::move(T), std::move(V)}, n);
}

/// The system with n coordinates from one object with members T and V, or from T alone when there is no potential.
template <int n, class Energies>
auto mechanical_system(Energies energies) {
  return detail::checked_system<detail::held_as<n>>(detail::energies_object<detail::held_as<n>>(std::move(energies)), n);
}

/// The system whose number of coordinates is known only at run time; q and qdot are dynamic vectors.
///
/// @throws InvalidValue  when n < 1
template <class Kinetic, class Potential>
auto mechanical_system(Eigen::Index n, Kinetic T, Potential V) {
  return detail::checked_system<Dynamic>(KineticAndPotential<Kinetic, Potential>{std::move(T), std::move(V)}, n);
}

/// The system with n coordinates, n known at run time, from one object with members T and V, or from T alone when there is no potential.
template <class Energies>
auto mechanical_system(Eigen::Index n, Energies energies) {
  return detail::checked_system<Dynamic>(detail::energies_object<Dynamic>(std::move(energies)), n);
}

namespace detail {

// The size of a vector with an entry for each coordinate, checked when it is known only at run time. Deducing `void` instantiates it where it is called,
// so that its message comes before those of later calls.
template <class Sys, class X>
auto require_size(const Sys& system, const char* name, const X& x) {
  static_assert(require_real<typename X::Scalar>());
  constexpr int n = Sys::dof_at_compile_time, size = X::SizeAtCompileTime;
  static_assert(size == Dynamic || n == Dynamic || size == n, "qdot: q and qdot must have one entry for each coordinate of the system");
  if (x.size() != system.dof())
    throw DimensionError(name, static_cast<long>(system.dof()), static_cast<long>(x.size()), "pass one entry for each coordinate of the system");
}
template <class Sys, class Q, class Qdot>
void require_sizes(const Sys& system, const Q& q, const Qdot& qdot) {
  require_size(system, "q", q);
  require_size(system, "qdot", qdot);
}

template <class Sys>
using is_system = std::bool_constant<requires { Sys::dof_at_compile_time; typename Sys::EnergiesType; }>;

}  // namespace detail
}  // namespace qdot
