#pragma once
// SPDX-License-Identifier: MIT
//
// What moves in the lanes of a pack: one system or scene for all motions, or one of a family for each.
//
//     of(i)                                     the system or scene of motion i
//     lines()                                   from which its equations are evaluated; none where T and V are no formulas
//     equations(lines).take(lane, i)            gives a lane to motion i
//     equations(lines)(q, q̇, t, wanted, q̈)     q̈ in all lanes, and in which of them it is one
//
// What a lane gets does not depend on its neighbours, for the same operations go over the number in each lane.

#include <cstddef>
#include <memory>
#include <optional>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/effects/equations/lane_forces.hpp"
#include "qdot/integrate/lanes/lane_events.hpp"

namespace qdot {

template <int n, class EnergiesOf, class EffectsOf, class ParametersOf>
struct Family;

namespace detail {

struct NoEffects {
  std::tuple<> operator()(const auto&) const { return {}; }
};

// Lines, as long as somebody has them.
using LinesForLanes = std::shared_ptr<const DerivedLines>;

// One system or scene for all motions.
template <class Sys>
struct OneSystem {
  using System = Sys;
  static constexpr int n = Sys::dof_at_compile_time;
  static constexpr bool is_common = true, goes_in_lanes = scene_goes_in_lanes<Sys, LanePack>;
  const Sys& system;

  const Sys& of(std::size_t) const { return system; }
  LinesForLanes lines() const {
    if constexpr (goes_in_lanes) {
      auto held = std::make_shared<Derivations::Held>();
      if constexpr (requires { system.effects(); }) return {held, lane_lines_of(system.system(), *held)};
      else return {held, lane_lines_of(system, *held)};
    } else {
      return {};
    }
  }

  class Equations {
   public:
    Equations(const Sys& system, const DerivedLines& lines) : system_(system), x_(lane_numbers(lines)), lines_(lines, x_.data()) {}
    Equations(const Equations&) = delete;
    void take(int, std::size_t) {}
    template <class P>
    typename P::Mask operator()(const P* q, const P* qdot, const P& t, const typename P::Mask& wanted, P* qddot) {
      if constexpr (requires { requires Sys::has_forces; }) {
        const auto effects = [&](int) -> const auto& { return system_.effects(); };
        return lines_(q, qdot, t, [&](const P* x, const P* v, P* Q) { forces_.write(system_.effects(), effects, x, v, t, wanted, Q); }, qddot);
      } else {
        return lines_(q, qdot, t, NoLaneForces(), qddot);
      }
    }

   private:
    const Sys& system_;
    std::vector<formula::LaneNumber> x_;
    LaneEquations<n, LanePack> lines_;
    LaneForces<Sys, ForceSum::plain> forces_;
  };
  Equations equations(const DerivedLines& lines) const { return {system, lines}; }
};

// A system with the effects of a tuple, if there are some.
template <class Sys, class... Effects>
auto with_effects(Sys system, std::tuple<Effects...> effects) {
  if constexpr (sizeof...(Effects) == 0) return system;
  else return std::apply([&](auto&... e) { return scene(std::move(system), std::move(e)...); }, effects);
}

// Whether a scene goes in lanes with effects that have packs for parameters. A term in L is no force, and its derivatives are made for the scene.
template <class Sys, class Effects, class P>
inline constexpr bool family_goes_in_lanes = scene_goes_in_lanes<Sys, P>;
template <class Sys, class... Effects, class... InPacks, class P>
inline constexpr bool family_goes_in_lanes<Scene<Sys, Effects...>, std::tuple<InPacks...>, P> = [] {
  constexpr int n = Sys::dof_at_compile_time;
  return may_have_lane_lines<Sys> && !(LagrangianEffect<Effects, n> || ...) && (plays_for_packs<Effects, InPacks, P, n>() && ...);
}();

// One of a family for each motion. Parameters are inputs of the lines of its energies, and packs in its effects.
template <int dof, class EnergiesOf, class EffectsOf, class ParametersOf>
struct SystemsOfFamily {
  using F = Family<dof, EnergiesOf, EffectsOf, ParametersOf>;
  using Parameters = std::remove_cvref_t<std::invoke_result_t<const ParametersOf&, std::size_t>>;
  static constexpr int n = dof, k = Parameters::SizeAtCompileTime;
  static_assert(k != Dynamic, "qdot: the parameters of a family are a Vector<double, k> with k known when compiled");
  using InPacks = Vector<LanePack, k>;
  using Effects = std::remove_cvref_t<std::invoke_result_t<const EffectsOf&, const InPacks&>>;

  static auto made(const F& family, const Parameters& p) { return with_effects(mechanical_system<n>(family.energies_of(p)), family.effects_of(p)); }
  using System = decltype(made(std::declval<const F&>(), std::declval<const Parameters&>()));
  static constexpr bool is_common = false, goes_in_lanes = family_goes_in_lanes<System, Effects, LanePack>;
  const F& family;

  System of(std::size_t i) const { return made(family, Parameters(family.parameters_of(i))); }

  LinesForLanes lines() const {
    if constexpr (goes_in_lanes) {
      auto made = std::make_shared<Derivation<>>();
      try {
        RecordedMotion m = motion_variables(n);
        const auto nodes = new_variables(m.recording, 3 * n + 1, k);
        const auto energies = family.energies_of(recorded_vector<k>(m.recording, nodes));
        if constexpr (recordable_as_lines<std::remove_cvref_t<decltype(energies)>, n>) {
          run_energies<n>(m, energies);
          made->derive(std::move(m), nullptr, static_cast<std::size_t>(k));
          if (n > straight_line_limit && made->lines.exist()) made->writer->write_solutions(made->lines);
          if (!made->lines.solution[0].accelerations.empty()) return {made, &made->lines};
        }
      } catch (...) {  // what functors throw they throw again, where they are asked for values
      }
    }
    return {};
  }

  class Equations {
   public:
    Equations(const F& family, const DerivedLines& lines) : family_(family), x_(lane_numbers(lines)), lines_(lines, x_.data()) {}
    Equations(const Equations&) = delete;

    void take(int lane, std::size_t motion) {
      const Parameters p = family_.parameters_of(motion);
      for (int j = 0; j < k; ++j) {
        set_lane(parameters_[j], lane, p[j]);
        lines_.set_parameter(j, lane, p[j]);
      }
      effects_.reset();
    }

    template <class P>
    typename P::Mask operator()(const P* q, const P* qdot, const P& t, const typename P::Mask& wanted, P* qddot) {
      if constexpr (requires { requires System::has_forces || System::adds_potentials_only; }) {
        if (!effects_) effects_.emplace(family_.effects_of(parameters_));
        const auto of_lane = [&](int lane) { return family_.effects_of(only(parameters_, lane)); };
        return lines_(q, qdot, t, [&](const P* x, const P* v, P* Q) { forces_.write(*effects_, of_lane, x, v, t, wanted, Q); }, qddot);
      } else {
        return lines_(q, qdot, t, NoLaneForces(), qddot);
      }
    }

   private:
    static constexpr ForceSum sum = [] {
      if constexpr (requires { System::adds_potentials_only; }) return sum_beside_energies<System>;
      else return ForceSum::plain;
    }();
    const F& family_;
    InPacks parameters_ = InPacks::Zero();
    std::optional<Effects> effects_ = {};  // with these parameters
    std::vector<formula::LaneNumber> x_;
    LaneEquations<n, LanePack> lines_;
    LaneForces<System, sum> forces_;
  };
  Equations equations(const DerivedLines& lines) const { return {family, lines}; }
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
