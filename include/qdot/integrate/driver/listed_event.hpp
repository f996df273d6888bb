#pragma once
// SPDX-License-Identifier: MIT
//
// One event of a run's list as the watch over it asks for it: by calls, whatever the types of its function and of its action are.
//
// Every lambda has a type of its own, and what is a template of it the compiler writes anew for each. The loop of a run and the search for
// roots need not know these types. An event is called some ten times in a step, and a call costs a nanosecond.

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/integrate/driver/event_proof.hpp"
#include "qdot/integrate/event.hpp"
#include "qdot/integrate/outcome.hpp"

namespace qdot::detail {

// Reads an Event that lives elsewhere.
struct ListedEvent {
  const void* event;
  const std::string* name;
  Direction direction;
  bool is_barrier, stops;
  double (*value)(const void* event, double t, const Eigen::VectorXd& y, Eigen::Index dof);
  std::optional<Failure> (*change)(const void* event, double t, Eigen::VectorXd& y, Eigen::Index dof);  // null where it has no action
  bool (*decide)(const void* event, StepBounds& bounds, double level, double a, double b);                    // null where g is no formula
  const Timetable* times;                                                                               // null where g is a function
};

// What an action has left behind that is no number.
template <class Form>
std::optional<Failure> what_is_not_finite(const Form& system, const std::string& name, double t, const Eigen::VectorXd& y) {
  for (Eigen::Index k = 0; k < y.size(); ++k)
    if (!std::isfinite(y[k]))
      return Failure{Outcome::non_finite, sentence({"the action of event '", name, "' at t = ", t, " must leave finite numbers, but ",
                                                    system.component_name(k), " became ", y[k]})};
  return std::nullopt;
}

// An action that changed a −0 into 0 has changed something: it may be the blow of a floor on what lies still.
inline bool same_bits(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

// Everything that happens at one moment.
struct Firing {
  double elapsed = 0.0;  // on the clock of the step
  double t = 0.0;        // the same for readers
  bool stops = false;
  bool changes = false;  // the state, or a phase of the system
  std::size_t first = 0; // index of the first function in it
};

template <int n, class G, class Action>
ListedEvent listed_event(const Event<G, Action>& event) {
  using E = Event<G, Action>;
  ListedEvent result{&event, &event.name, event.direction, E::is_barrier, E::stops, nullptr, nullptr, nullptr, nullptr};
  if constexpr (E::is_timed) result.times = &event.g;
  result.value = [](const void* e, double t, const Eigen::VectorXd& y, Eigen::Index dof) {
    return event_value<n>(static_cast<const E*>(e)->g, t, y, dof);
  };
  if constexpr (!E::stops && !E::records)
    result.change = [](const void* e, double t, Eigen::VectorXd& y, Eigen::Index dof) {
      const E& self = *static_cast<const E*>(e);
      return change_state<n>(self.name, self.change, t, y, dof);
    };
  if constexpr (E::is_formula)
    result.decide = [](const void* e, StepBounds& bounds, double level, double a, double b) {
      return bounds.decide<n>(static_cast<const E*>(e)->g, level, a, b);
    };
  return result;
}

// The events of a list, for calls; the list must outlive them.
template <int n, class... Events>
std::array<ListedEvent, sizeof...(Events)> listed_events(const EventList<Events...>& events) {
  return std::apply([](const auto&... each) { return std::array<ListedEvent, sizeof...(Events)>{listed_event<n>(each)...}; }, events.list);
}
inline std::vector<ListedEvent> kept(std::span<const ListedEvent> events) { return {events.begin(), events.end()}; }

}  // namespace qdot::detail
