#pragma once
// SPDX-License-Identifier: MIT
//
// What moves in the lanes of a pack: one system or scene for all motions, or one of a family for each.
//
//     of(i)              the system or scene of motion i
//     to_begin(i)        the same, for the few evaluations at a start
//     recorded()         T, V and forces as they are now; throws where they are no formulas
//     take(lane, i, q̈)   gives a lane of the equations to motion i
//
// What a lane gets does not depend on its neighbours, for the same operations go over the number in each lane.

#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

#include "qdot/effects/equations/lines_under_forces.hpp"
#include "qdot/integrate/lanes/lane_events.hpp"

namespace qdot {

template <int n, class EnergiesOf, class EffectsOf, class ParametersOf>
struct Family;

namespace detail {

struct NoEffects {
  std::tuple<> operator()(const auto&) const { return {}; }
};

// Whether a system or scene may go in lanes, as far as types tell; `Made`: its effects with recorded parameters.
template <class Sys, class Made>
inline constexpr bool scene_goes_in_lanes = may_have_lane_lines<Sys>;
template <class Sys, class... Effects, class... Made>
inline constexpr bool scene_goes_in_lanes<Scene<Sys, Effects...>, std::tuple<Made...>> = [] {
  constexpr int n = Sys::dof_at_compile_time;
  if constexpr (may_have_lane_lines<typename Scene<Sys, Effects...>::SystemType>) return (is_recordable_force<Effects, Made, n>() && ...);
  else return false;
}();
template <class Sys>
inline constexpr bool goes_in_lanes_itself = scene_goes_in_lanes<Sys, std::tuple<>>;
template <class Sys, class... Effects>
inline constexpr bool goes_in_lanes_itself<Scene<Sys, Effects...>> = scene_goes_in_lanes<Scene<Sys, Effects...>, std::tuple<Effects...>>;

// Lanes are a way of their own.
template <class Sys>
void require_no_way(const Sys& system) {
  if (!system.kept_lines()->is_fastest()) throw InvalidValue("a system that is evaluated by one way does not go in lanes");
}

// A system, or a scene, as it is now.
template <class E, int n, Inertia inertia>
RecordedMotion recorded_for_lanes(const System<E, n, inertia>& system) {
  RecordedMotion m = motion_variables(n);
  require_no_way(system);
  record_under_forces<n, false, E>(m, system.energies(), std::tuple<>());
  return m;
}
template <class Sys, class... Effects>
RecordedMotion recorded_for_lanes(const Scene<Sys, Effects...>& scene) {
  constexpr int n = Sys::dof_at_compile_time;
  using Energies = typename Scene<Sys, Effects...>::SystemType::EnergiesType;
  RecordedMotion m = motion_variables(n);
  require_no_way(scene.system());
  record_under_forces<n, false, Energies, Effects...>(m, scene.system().energies(), scene.effects());
  return m;
}

// One system or scene for all motions.
template <class Sys>
struct OneSystem {
  using System = Sys;
  static constexpr int n = Sys::dof_at_compile_time, parameters = 0;
  static constexpr bool is_common = true, goes_in_lanes = goes_in_lanes_itself<Sys>;
  const Sys& system;

  const Sys& of(std::size_t) const { return system; }
  const Sys& to_begin(std::size_t) const { return system; }
  RecordedMotion recorded() const { return recorded_for_lanes(system); }
  template <class Equations>
  void take(int, std::size_t, Equations&) const {}
};

// A system with the effects of a tuple, if there are some.
template <class Sys, class... Effects>
auto with_effects(Sys system, std::tuple<Effects...> effects) {
  if constexpr (sizeof...(Effects) == 0) return system;
  else return std::apply([&](auto&... e) { return scene(std::move(system), std::move(e)...); }, effects);
}

// Whether the effects of a family are all that its scenes have beside their own T and V. A term in L is no force, and its derivatives are made for the scene.
template <class Sys>
inline constexpr bool adds_terms = false;
template <class Sys, class... Effects>
inline constexpr bool adds_terms<Scene<Sys, Effects...>> = (LagrangianEffect<Effects, Sys::dof_at_compile_time> || ...);

// One of a family for each motion. Its parameters are inputs of the lines.
template <int dof, class EnergiesOf, class EffectsOf, class ParametersOf>
struct SystemsOfFamily {
  using F = Family<dof, EnergiesOf, EffectsOf, ParametersOf>;
  using Parameters = std::remove_cvref_t<std::invoke_result_t<const ParametersOf&, std::size_t>>;
  static constexpr int n = dof, k = Parameters::SizeAtCompileTime, parameters = k;
  static_assert(k != Dynamic, "qdot: the parameters of a family are a Vector<double, k> with k known when compiled");
  using Recorded = Vector<formula::Recorded, k>;
  using Numbers = std::remove_cvref_t<std::invoke_result_t<const EnergiesOf&, const Parameters&>>;
  using Effects = std::remove_cvref_t<std::invoke_result_t<const EffectsOf&, const Recorded&>>;

  static auto made(const F& family, const Parameters& p, bool keeps_lines = true) {
    auto system = mechanical_system<n>(family.energies_of(p));
    if (!keeps_lines) *system.kept_lines() = KeptLines::none();
    return with_effects(std::move(system), family.effects_of(p));
  }
  using System = decltype(made(std::declval<const F&>(), std::declval<const Parameters&>()));
  static constexpr bool is_common = false,
                        goes_in_lanes = scene_goes_in_lanes<System, Effects> && !adds_terms<System>;
  const F& family;

  System of(std::size_t i) const { return made(family, Parameters(family.parameters_of(i))); }
  System to_begin(std::size_t i) const { return made(family, Parameters(family.parameters_of(i)), false); }

  RecordedMotion recorded() const {
    RecordedMotion m = motion_variables(n);
    record(m, recorded_vector<k>(m.recording, new_variables(m.recording, 3 * n + 1, k)), std::type_identity<System>());
    return m;
  }
  template <class Equations>
  void take(int lane, std::size_t motion, Equations& equations) const {
    const Parameters p = family.parameters_of(motion);
    for (int j = 0; j < k; ++j) equations.set_parameter(j, lane, p[j]);
  }

 private:
  template <class Sys>
  void record(RecordedMotion& m, const Recorded& p, std::type_identity<Sys>) const {
    record_under_forces<n, false, Numbers>(m, family.energies_of(p), family.effects_of(p));
  }
  template <class Sys, class... Roles>
  void record(RecordedMotion& m, const Recorded& p, std::type_identity<Scene<Sys, Roles...>>) const {
    record_under_forces<n, true, Numbers, Roles...>(m, family.energies_of(p), family.effects_of(p));
  }
};

template <class Sys>
OneSystem<Sys> systems_of(const Sys& system) {
  return {system};
}
template <int n, class EnergiesOf, class EffectsOf, class ParametersOf>
SystemsOfFamily<n, EnergiesOf, EffectsOf, ParametersOf> systems_of(const Family<n, EnergiesOf, EffectsOf, ParametersOf>& family) {
  return {family};
}

}  // namespace detail
}  // namespace qdot
