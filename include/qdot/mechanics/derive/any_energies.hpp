#pragma once
// SPDX-License-Identifier: MIT
//
// T and V of any type, behind virtual functions.
//
// A run asks T and V for a recording when it begins, and for numbers now and then. Everything else that it does depends on the number of coordinates
// alone. So simulate() replaces the user's functors by AnyEnergies, and what stands behind it (first_order_form.hpp, integrate/) is compiled once for
// each number of coordinates: in the library qdot::compiled, or in a program for all its systems.
//
// The functors are run on four kinds of numbers:
//
//     formula::Recorded               writes down what is done to it
//     Dual<double, 1>                 values, and the energy's slope along a motion
//     Dual<Dual<Dual<double, 1>, 1>, k>  M, r and their slopes, where no lines are (mechanics/equations/lagrange_terms.hpp)
//     AskedNumber                     finds the function that has no value
//
// and on hashes and on vectors that know their size, which have functions of their own, so that the compiler sees through them.

#include <memory>
#include <type_traits>
#include <utility>

#include "qdot/ad/forward/where_broken.hpp"
#include "qdot/mechanics/derive/fingerprint.hpp"
#include "qdot/mechanics/derive/recorded_energies.hpp"
#include "qdot/mechanics/equations/entries.hpp"
#include "qdot/mechanics/equations/lagrange_terms.hpp"
#include "qdot/mechanics/equations/small_solve.hpp"

namespace qdot::detail {

/// T and V of one kind of numbers S, and of n coordinates.
template <class S, int n>
struct EnergiesOfNumbers {
  virtual ~EnergiesOfNumbers() = default;
  virtual S T(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const = 0;
  virtual S V(const Vector<S, n>& q, const S& t) const = 0;
};

/// All that is asked of functors in a run, and T and V of more kinds of numbers.
template <int n, class... More>
struct EnergiesFace : EnergiesOfNumbers<formula::Recorded, n>,
                      EnergiesOfNumbers<Dual<double, 1>, n>,
                      EnergiesOfNumbers<TermDual<Spare, n>, n>,
                      EnergiesOfNumbers<AskedNumber, n>,
                      EnergiesOfNumbers<More, n>... {
  virtual bool kinetic_energy_takes_q() const = 0;
  virtual Fingerprint fingerprint(int size, const Answers* answers) const = 0;
  virtual void read_entries(const WatchedVector<n>& q, const WatchedVector<n>& qdot, double t) const = 0;
};

/// The functors E behind a Face; T and V of the numbers S, and of the Others after them.
template <class E, class Face, int n, class... Numbers>
struct HeldEnergies : Face {
  E energies;

  explicit HeldEnergies(E it) : energies(std::move(it)) {}
  bool kinetic_energy_takes_q() const override { return kinetic_signature<E, n>() != KineticSignature::velocity; }
  Fingerprint fingerprint(int size, const Answers* answers) const override { return qdot::detail::fingerprint<n>(energies, size, answers); }
  void read_entries(const WatchedVector<n>& q, const WatchedVector<n>& qdot, double t) const override {
    qdot::detail::read_entries<n>(energies, q, qdot, t);
  }
};
template <class E, class Face, int n, class S, class... Others>
struct HeldEnergies<E, Face, n, S, Others...> : HeldEnergies<E, Face, n, Others...> {
  using Base = HeldEnergies<E, Face, n, Others...>;
  using Base::Base;
  // Numbers that throw: nothing is asked but whether they do.
  static constexpr bool is_asked = std::is_same_v<S, AskedNumber>;

  S T([[maybe_unused]] const Vector<S, n>& q, [[maybe_unused]] const Vector<S, n>& qdot, const S& t) const override {
    if constexpr (is_asked && !T_may_throw<E, AskedNumber, n>) return t;
    else return kinetic<n>(this->energies, q, qdot, t);
  }
  S V([[maybe_unused]] const Vector<S, n>& q, const S& t) const override {
    if constexpr (is_asked && !V_may_throw<E, AskedNumber, n>) return t;
    else return potential<n>(this->energies, q, t);
  }
};

/// Energies of a type that is hidden. Copies share them: functors with a mutable state have one for a whole run, its watches included.
///
/// @tparam timed  whether T or V takes the time
/// @tparam More   kinds of numbers that are asked for beside the four of a run, each once
template <int n, bool timed, class... More>
class AnyEnergies {
  using Face = EnergiesFace<n, More...>;

 public:
  template <class E>
  explicit AnyEnergies(E energies)
      : held_(std::make_shared<const HeldEnergies<E, Face, n, formula::Recorded, Dual<double, 1>, TermDual<Spare, n>, AskedNumber, More...>>(
            std::move(energies))) {}

  template <class S>
  S T(const Vector<S, n>& q, const Vector<S, n>& qdot) const
    requires(!timed)
  {
    return of<S>().T(q, qdot, S(0.0));
  }
  template <class S>
  S T(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const
    requires timed
  {
    return of<S>().T(q, qdot, t);
  }
  template <class S>
  S V(const Vector<S, n>& q) const
    requires(!timed)
  {
    return of<S>().V(q, S(0.0));
  }
  template <class S>
  S V(const Vector<S, n>& q, const S& t) const
    requires timed
  {
    return of<S>().V(q, t);
  }
  bool kinetic_energy_takes_q() const { return held_->kinetic_energy_takes_q(); }
  Fingerprint fingerprint(int size, const Answers* answers) const { return held_->fingerprint(size, answers); }
  void read_entries(const WatchedVector<n>& q, const WatchedVector<n>& qdot, double t) const { held_->read_entries(q, qdot, t); }

 private:
  template <class S>
  const EnergiesOfNumbers<S, n>& of() const {
    return *held_;
  }

  std::shared_ptr<const Face> held_;
};

}  // namespace qdot::detail
