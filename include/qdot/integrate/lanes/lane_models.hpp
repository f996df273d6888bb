#pragma once
// SPDX-License-Identifier: MIT
//
// What moves in the lanes of a pack: one system or scene for all motions, or one of a family for each.
//
//     of(i)                                the system or scene of motion i
//     equations().take(lane, i)            gives a lane to motion i
//     equations()(q, q̇, t, q̈) → mask      q̈ in all lanes, and in which of them it is one
//     equations().of_lane(lane)            the same with the parameters of one lane in all of them
//
// A functor that branches on packs is asked lane by lane where lanes disagree: PartingEquations does so. What a lane gets does not depend on that, for
// the same instructions go over the same number in each lane.

#include <cstddef>
#include <optional>
#include <tuple>
#include <type_traits>
#include <utility>

#include "qdot/effects/equations/forced_packs.hpp"
#include "qdot/integrate/lanes/lane_events.hpp"

namespace qdot {

template <int n, class EnergiesOf, class EffectsOf, class ParametersOf>
struct Family;

namespace detail {

struct NoEffects {
  std::tuple<> operator()(const auto&) const { return {}; }
};

// One system or scene for all motions.
template <class Sys>
struct OneSystem {
  using System = Sys;
  static constexpr int n = Sys::dof_at_compile_time;
  static constexpr bool is_common = true, goes_in_lanes = scene_goes_in_packs<Sys, LanePack>;
  const Sys& system;

  const Sys& of(std::size_t) const { return system; }

  struct Equations {
    const Sys& system;
    void take(int, std::size_t) {}
    const Equations& of_lane(int) const { return *this; }
    template <class P>
    typename P::Mask operator()(const P* q, const P* qdot, const P& t, P* qddot) const { return unchecked_accelerations(system, q, qdot, t, qddot); }
  };
  Equations equations() const { return {system}; }
};

// A system with the effects of a tuple, if there are some.
template <class Sys, class... Effects>
auto with_effects(Sys system, std::tuple<Effects...> effects) {
  if constexpr (sizeof...(Effects) == 0) return system;
  else return std::apply([&](auto&... e) { return scene(std::move(system), std::move(e)...); }, effects);
}

// Whether a scene goes in lanes with effects that have packs for parameters. A term in L is no force, and its derivatives are made for the scene.
template <class Sys, class Effects, class P>
inline constexpr bool family_goes_in_packs = scene_goes_in_packs<Sys, P>;
template <class Sys, class... Effects, class... InPacks, class P>
inline constexpr bool family_goes_in_packs<Scene<Sys, Effects...>, std::tuple<InPacks...>, P> = [] {
  constexpr int n = Sys::dof_at_compile_time;
  return goes_in_packs<Sys> && !(LagrangianEffect<Effects, n> || ...) && (plays_for_packs<Effects, InPacks, P, n>() && ...);
}();

// One of a family for each motion.
template <int dof, class EnergiesOf, class EffectsOf, class ParametersOf>
struct SystemsOfFamily {
  using F = Family<dof, EnergiesOf, EffectsOf, ParametersOf>;
  using Parameters = std::remove_cvref_t<std::invoke_result_t<const ParametersOf&, std::size_t>>;
  static constexpr int n = dof, k = Parameters::SizeAtCompileTime;
  static_assert(k != Dynamic, "qdot: the parameters of a family are a Vector<double, k> with k known when compiled");
  using InPacks = Vector<LanePack, k>;
  using PackEnergies = std::remove_cvref_t<std::invoke_result_t<const EnergiesOf&, const InPacks&>>;
  using PackEffects = std::remove_cvref_t<std::invoke_result_t<const EffectsOf&, const InPacks&>>;

  static auto made(const F& family, const Parameters& p) { return with_effects(mechanical_system<n>(family.energies_of(p)), family.effects_of(p)); }
  using System = decltype(made(std::declval<const F&>(), std::declval<const Parameters&>()));
  static constexpr bool is_common = false, goes_in_lanes = family_goes_in_packs<System, PackEffects, LanePack>;
  const F& family;

  System of(std::size_t i) const { return made(family, Parameters(family.parameters_of(i))); }

  struct Equations {
    const F& family;
    InPacks parameters = {};
    struct Made {
      PackEnergies energies;
      PackEffects effects;
    };
    mutable std::optional<Made> made = {};  // with these parameters, unless a lane has changed its own

    void take(int lane, std::size_t motion) {
      const Parameters p = family.parameters_of(motion);
      for (int j = 0; j < k; ++j) set_lane(parameters[j], lane, p[j]);
      made.reset();
    }
    Equations of_lane(int lane) const { return {family, only(parameters, lane), {}}; }

    template <class P>
    typename P::Mask operator()(const P* q, const P* qdot, const P& t, P* qddot) const {
      if (!made) made.emplace(Made{family.energies_of(parameters), family.effects_of(parameters)});
      if constexpr (requires { typename UnderForces<System>::Sc; }) {
        return UnderForces<System>::accelerations(made->energies, made->effects, q, qdot, t, qddot);
      } else {
        return register_accelerations<n>(made->energies, q, qdot, t, NoForces(), qddot);
      }
    }
  };
  Equations equations() const { return {family, InPacks(InPacks::Zero()), {}}; }
};

template <class Sys>
OneSystem<Sys> systems_of(const Sys& system) {
  return {system};
}
template <int n, class EnergiesOf, class EffectsOf, class ParametersOf>
SystemsOfFamily<n, EnergiesOf, EffectsOf, ParametersOf> systems_of(const Family<n, EnergiesOf, EffectsOf, ParametersOf>& family) {
  return {family};
}

// Asks for all lanes at once, or lane by lane where functors branch and lanes part.
template <class Equations, int n>
class PartingEquations {
 public:
  explicit PartingEquations(Equations equations) : equations_(std::move(equations)) {}

  void take(int lane, std::size_t motion) { equations_.take(lane, motion); }

  // q̈ of the lanes in `wanted` at least.
  template <class P>
  typename P::Mask accelerations(const P* q, const P* qdot, const P& t, P* qddot, const typename P::Mask& wanted) {
    if (partings_ < most_partings) {
      try {
        return equations_(q, qdot, t, qddot);
      } catch (const LanesPart&) {
        ++partings_;
      }
    }
    return lane_by_lane(q, qdot, t, qddot, wanted);
  }

 private:
  static constexpr int most_partings = 16;  // an exception costs more than what it spares: then lanes are not asked together any more

  template <class P>
  [[gnu::cold, gnu::noinline]] typename P::Mask lane_by_lane(const P* q, const P* qdot, const P& t, P* qddot, const typename P::Mask& wanted) const {
    typename P::Mask good = false;
    for (int lane = 0; lane < P::size; ++lane) {
      if (!wanted[lane]) continue;
      P x[n], v[n], a[n];
      for (int i = 0; i < n; ++i) {
        x[i] = only(q[i], lane);
        v[i] = only(qdot[i], lane);
      }
      set_lane(good, lane, equations_.of_lane(lane)(x, v, only(t, lane), a)[lane]);
      for (int i = 0; i < n; ++i) set_lane(qddot[i], lane, a[i][lane]);
    }
    return good;
  }

  Equations equations_;
  int partings_ = 0;
};

}  // namespace detail
}  // namespace qdot
