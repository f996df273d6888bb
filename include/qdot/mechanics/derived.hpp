#pragma once
// SPDX-License-Identifier: MIT
//
// Plain loops in T and V at a quarter to a third of the cost outside of runs, too.
//
//     struct Chain {
//       double m = 1.0, l = 1.0, g = 9.81;
//       auto T(const auto& q, const auto& qdot) const { … for (Eigen::Index k = 0; k < q.size(); ++k) … }
//       auto V(const auto& q) const { … }
//     };
//     const auto system = mechanical_system<4>(derived<4>(Chain{.m = 0.3}));
//
// A run derives the equations of such energies by itself (mechanics/derive/kept_lines.hpp). This word does it when the object is made, for
// all who evaluate it afterwards: T and V are run once on a scalar that records what is done to it (ad/formula/recording.hpp), from that
// Lagrange's equations are derived, and evaluations go through the lines that come out (mechanics/derive/lines.hpp). Nothing
// is asked of T and V: they need not be constexpr, as written_out() wants them (mechanics/written_out.hpp), and may use Eigen. It pays
// where T and V are loops. Straight-line code of up to four coordinates is faster as it is, and written_out() is twice as
// fast again, for seconds of compile time.
//
// What is no formula (T or V that branch on the state or use abs, max or a power that varies), and what would need more lines than it saves
// (rotations), is evaluated as without the word. Parameters are read when the object is made, so they must
// be numbers in it, not behind a pointer, in a std::vector or captured by reference. What T and V read elsewhere, a global variable, must stay as it
// was: a run records them again at its looks and ends by the name of model_changed where they have become others
// (integrate/watch/change_watch.hpp).

#include <Eigen/Core>
#include <memory>
#include <type_traits>
#include <utility>

#include "qdot/mechanics/derive/kept_lines.hpp"
#include "qdot/mechanics/derive/traced_energies.hpp"
#include "qdot/mechanics/equations/equation_slopes.hpp"
#include "qdot/mechanics/mass_and_rhs.hpp"

namespace qdot {

/// Energies whose equations of motion were derived when the object was made; made by derived().
template <int n, class E>
class Derived : public E {
 public:
  static constexpr bool has_own_equations = true;  ///< evaluations ask it for q̈ in place of T and V

  Derived()
    requires std::is_default_constructible_v<E>
      : Derived(E{}) {}
  explicit Derived(E energies) : E(std::move(energies)), derivation_(std::make_shared<detail::KeptDerivation>()) {
    derivation_->derive<n>(this->energies(), std::nullopt);
    lines_ = derivation_->lines();
    if constexpr (n <= detail::straight_line_limit) derivation_->lines_with_slopes();
  }

  /// T and V as they were given.
  const E& energies() const noexcept { return *this; }

  /// False when T and V are no formulas; then they are evaluated as they are.
  bool has_lines() const noexcept { return lines_ != nullptr; }

  /// Whether T and V, recorded anew, are what was derived: false when they read something that has changed since.
  bool still_holds() const { return derivation_->still_holds<n>(energies()); }

  /// M and r, handed to `use` (mass_and_rhs.hpp); false where T or V has no value, and where `use` says so.
  template <class Use>
  bool equations(const double* q, const double* qdot, Eigen::Index, double t, const Use& use) const {
    if (has_lines()) return lines_->template with_mass_and_rhs<n>(q, qdot, t, use);
    return detail::with_mass_and_rhs<n>(energies(), vector_of(q), vector_of(qdot), t, use);
  }

  /// The lines of M, r and slopes, if there are any.
  const detail::DerivedLines* lines_with_slopes() const { return has_lines() && lines_->have_slopes() ? lines_ : nullptr; }

  /// M, and the derivatives of r − M a at accelerations a (mechanics/equations/equation_slopes.hpp).
  template <class Row>
  bool slopes(const double* q, const double* qdot, const double* a, double t, double* M, Row* rows) const {
    if (lines_with_slopes()) return lines_->template write_slopes<n>(q, qdot, t, M, rows, detail::AccelerationsAre{a, n});
    return detail::slopes_written<n>(energies(), vector_of(q), vector_of(qdot), vector_of(a), t, M, rows);
  }

 private:
  static Vector<double, n> vector_of(const double* numbers) { return Eigen::Map<const Vector<double, n>>(numbers); }

  std::shared_ptr<detail::KeptDerivation> derivation_;  // copies of the object share it
  const detail::DerivedLines* lines_ = nullptr;
};

namespace detail {

template <int n, class E>
Derived<n, E> derived_of(E energies) {
  static_assert(require_energies<E, n>());
  static_assert(n >= 1 && n <= 16, "qdot: derived is for up to 16 coordinates: leave it away, or take written_out, which goes up to 32");
  static_assert(HoldsItsParameters<E>,
                "qdot: derived reads the parameters of T and V once, so they must be numbers in the object itself (of a lambda: doubles) and not behind "
                "a pointer, in a std::vector or captured by reference, where they may change unseen: leave derived away for such a class");
  return Derived<n, E>(std::move(energies));
}

}  // namespace detail

/// Energies whose equations of motion are derived when the object is made, for mechanical_system<n>(): an object with members T and V, or T alone.
///
/// See the head of this file. Up to 16 coordinates; Jacobians come from lines up to 8. Making the object takes 0.02 to 0.3 ms;
/// an evaluation of it allocates nothing and uses 32 kB of stack.
template <int n, class Energies>
auto derived(Energies energies) {
  return detail::derived_of<n>(detail::energies_object<n>(std::move(energies)));
}

/// The same of two functors.
template <int n, class Kinetic, class Potential>
auto derived(Kinetic T, Potential V) {
  return detail::derived_of<n>(KineticAndPotential<Kinetic, Potential>{std::move(T), std::move(V)});
}

}  // namespace qdot
