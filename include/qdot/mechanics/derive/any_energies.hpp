#pragma once
// SPDX-License-Identifier: MIT
//
// T and V of any type, behind virtual functions.
//
// A run asks T and V for a recording when it begins, and for numbers now and then. Everything else that it does depends on the number of coordinates
// alone. So simulate() replaces the user's functors by AnyEnergies. The code behind it (first_order_form.hpp, integrate/) is compiled once for each
// number of coordinates: in the library qdot::compiled, or in a program for all its systems.
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
#include <tuple>
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

/// All that is asked of functors in a run.
template <int n>
struct EnergiesFace : EnergiesOfNumbers<formula::Recorded, n>,
                      EnergiesOfNumbers<Dual<double, 1>, n>,
                      EnergiesOfNumbers<TermDual<Spare, n>, n>,
                      EnergiesOfNumbers<AskedNumber, n> {
  virtual bool kinetic_energy_takes_q() const = 0;
  virtual Fingerprint fingerprint(int size, const Answers* answers) const = 0;
  virtual void read_entries(const WatchedVector<n>& q, const WatchedVector<n>& qdot, double t) const = 0;
};

/// Energies of a type that is hidden. Copies share them: functors with a mutable state have one for a whole run, its watches included.
///
/// @tparam timed  whether T or V takes the time
/// @tparam More   kinds of numbers that are asked for beside the four of a run
template <int n, bool timed, class... More>
class AnyEnergies {
 public:
  template <class E>
  explicit AnyEnergies(E energies) : AnyEnergies(std::make_shared<const Held<E>>(std::move(energies))) {}

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
    if constexpr ((std::is_same_v<S, More> || ...)) return *std::get<std::shared_ptr<const EnergiesOfNumbers<S, n>>>(more_);
    else return *held_;
  }

  template <class E>
  struct Held final : EnergiesFace<n> {
    E energies;

    explicit Held(E it) : energies(std::move(it)) {}

    using Recorded = formula::Recorded;
    using Number = Dual<double, 1>;
    using Nested = TermDual<Spare, n>;
    Recorded T(const Vector<Recorded, n>& q, const Vector<Recorded, n>& v, const Recorded& t) const override { return kinetic<n>(energies, q, v, t); }
    Recorded V(const Vector<Recorded, n>& q, const Recorded& t) const override { return potential<n>(energies, q, t); }
    Number T(const Vector<Number, n>& q, const Vector<Number, n>& v, const Number& t) const override { return kinetic<n>(energies, q, v, t); }
    Number V(const Vector<Number, n>& q, const Number& t) const override { return potential<n>(energies, q, t); }
    Nested T(const Vector<Nested, n>& q, const Vector<Nested, n>& v, const Nested& t) const override { return kinetic<n>(energies, q, v, t); }
    Nested V(const Vector<Nested, n>& q, const Nested& t) const override { return potential<n>(energies, q, t); }
    AskedNumber T([[maybe_unused]] const Vector<AskedNumber, n>& q, [[maybe_unused]] const Vector<AskedNumber, n>& v, const AskedNumber& t) const override {
      if constexpr (T_may_throw<E, AskedNumber, n>) return kinetic<n>(energies, q, v, t);
      else return t;  // these numbers throw, and nothing is asked but whether they do
    }
    AskedNumber V([[maybe_unused]] const Vector<AskedNumber, n>& q, const AskedNumber& t) const override {
      if constexpr (V_may_throw<E, AskedNumber, n>) return potential<n>(energies, q, t);
      else return t;
    }
    bool kinetic_energy_takes_q() const override { return kinetic_signature<E, n>() != KineticSignature::velocity; }
    Fingerprint fingerprint(int size, const Answers* answers) const override { return qdot::detail::fingerprint<n>(energies, size, answers); }
    void read_entries(const WatchedVector<n>& q, const WatchedVector<n>& qdot, double t) const override {
      qdot::detail::read_entries<n>(energies, q, qdot, t);
    }
  };

  // T and V of further numbers S.
  template <class E, class S>
  struct HeldMore final : EnergiesOfNumbers<S, n> {
    std::shared_ptr<const Held<E>> held;

    explicit HeldMore(std::shared_ptr<const Held<E>> it) : held(std::move(it)) {}
    S T(const Vector<S, n>& q, const Vector<S, n>& v, const S& t) const override { return kinetic<n>(held->energies, q, v, t); }
    S V(const Vector<S, n>& q, const S& t) const override { return potential<n>(held->energies, q, t); }
  };

  template <class E>
  explicit AnyEnergies(const std::shared_ptr<const Held<E>>& held) : held_(held), more_(std::make_shared<const HeldMore<E, More>>(held)...) {}

  std::shared_ptr<const EnergiesFace<n>> held_;
  [[no_unique_address]] std::tuple<std::shared_ptr<const EnergiesOfNumbers<More, n>>...> more_;
};

}  // namespace qdot::detail
