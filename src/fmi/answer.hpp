#pragma once
// SPDX-License-Identifier: MIT
//
// How the C functions of FMI answer: a body that throws becomes a status and a message to the importer's log.
//
//     return answer(instance, "fmi3Terminate", [&](Handle& handle) {
//       require_mode(handle, {Mode::event, Mode::continuous_time, Mode::step});
//       handle.instance.end();
//     });
//
// A Refusal has its status. What the model throws at a state or for parameters is a discard; anything else an error, which ends the instance, as FMI
// asks for. No exception gets out.

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include "fmi/description.hpp"
#include "fmi/instance.hpp"

namespace qdot::fmi {

using Interface = Instance::Interface;

/// What all instances share: it never changes.
struct Library {
  Variables variables = variables_of(choice());
  Description description = description_of(choice(), variables);

  /// A number for this library and an interface, which serialized states bear.
  std::uint64_t owner(Interface interface) const;
};

/// @throws InvalidValue  the scene contradicts itself
const Library& library();

/// What stands behind fmi3Instance.
struct Handle {
  Instance instance;
  std::string name;
  fmi3InstanceEnvironment environment;
  fmi3LogMessageCallback log;
  std::vector<bool> logged;  // of each category

  void say(fmi3Status status, const char* category, const std::string& message) const;
};

/// The place of a log category; that of none is their number.
std::size_t log_category(const char* name);

// What a call is checked for.
void require_mode(const Handle& handle, std::initializer_list<Mode> modes);
void require_interface(const Handle& handle, Interface interface);
void require_pointer(const void* pointer, const char* what);
void require_count(const char* what, std::size_t wanted, std::size_t given);

inline constexpr auto initialized = {Mode::initialization, Mode::event, Mode::continuous_time, Mode::step, Mode::terminated};

template <class T>
std::span<T> list(T* first, std::size_t count, const char* what) {
  if (count > 0) require_pointer(first, what);
  return {first, count};
}

/// Runs body(handle), and makes a status of what it throws.
fmi3Status answered(fmi3Instance instance, const char* function, const void* body, void (*run)(const void* body, Handle& handle)) noexcept;

template <class Body>
fmi3Status answer(fmi3Instance instance, const char* function, const Body& body) noexcept {
  return answered(instance, function, &body, [](const void* b, Handle& handle) { (*static_cast<const Body*>(b))(handle); });
}

}  // namespace qdot::fmi
