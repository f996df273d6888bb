#pragma once
// SPDX-License-Identifier: MIT
//
// Effects that are in a scene or not, by a constant known to the compiler:
//
//     scene(cart, optional<with_friction>(friction), optional<with_motor>(motor))
//
// An effect that is off leaves no trace: scene() drops it before the scene's type is made. So the scene has the same type as one
// without it, and the same instructions run.
//
// In a file that says `using namespace qdot;` and `using namespace std;`, or `using std::optional;`, write qdot::optional<…>(…) for the effect and
// std::optional<…> for the type.

#include <tuple>
#include <type_traits>
#include <utility>

#include "qdot/effects/scene.hpp"

namespace qdot {

/// An effect that was switched off.
struct Absent {};

/// The effect where `on`, and nothing otherwise.
template <bool on, class Effect>
auto optional(Effect effect) {
  if constexpr (on) {
    return effect;
  } else {
    return Absent{};
  }
}

namespace detail {

template <class Effect>
auto present(Effect effect) {
  if constexpr (std::is_same_v<Effect, Absent>) {
    return std::tuple<>();
  } else {
    return std::tuple<Effect>(std::move(effect));
  }
}

}  // namespace detail

/// A system with those of the effects that are on.
template <class E, int n, Inertia inertia, class... Effects>
  requires(std::is_same_v<Effects, Absent> || ...)
auto scene(System<E, n, inertia> system, Effects... effects) {
  return std::apply([&](auto... present) { return scene(std::move(system), std::move(present)...); },
                    std::tuple_cat(detail::present(std::move(effects))...));
}

// Old names, accepted until 0.4.

/// optional() by its old name.
template <bool on, class Effect>
[[deprecated("qdot: say optional()")]]
auto only_if(Effect effect) {
  return qdot::optional<on>(std::move(effect));
}

}  // namespace qdot
