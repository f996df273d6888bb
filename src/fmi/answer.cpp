// SPDX-License-Identifier: MIT
#include "fmi/answer.hpp"

#include <algorithm>
#include <cstring>
#include <exception>
#include <new>

#include "qdot/error.hpp"
#include "qdot/integrate/simulator_state.hpp"

namespace qdot::fmi {

std::uint64_t Library::owner(Interface interface) const {
  const std::string words = description.token + (interface == Interface::model_exchange ? "me" : "cs");
  return qdot::detail::checksum(qdot::detail::empty_checksum, words.data(), words.size());
}

const Library& library() {
  static const Library one;
  return one;
}

std::size_t log_category(const char* name) {
  const auto found = std::find_if(log_categories.begin(), log_categories.end(), [&](const LogCategory& c) { return std::strcmp(c.name, name) == 0; });
  return static_cast<std::size_t>(found - log_categories.begin());
}

void Handle::say(fmi3Status status, const char* category, const std::string& message) const {
  if (log == nullptr || (status < fmi3Error && !logged[log_category(category)])) return;
  log(environment, status, category, (name + ": " + message).c_str());
}

static const char* words(Mode mode) {
  switch (mode) {
    case Mode::instantiated:
      return "instantiated";
    case Mode::initialization:
      return "in initialization mode";
    case Mode::event:
      return "in event mode";
    case Mode::continuous_time:
      return "in continuous-time mode";
    case Mode::step:
      return "in step mode";
    case Mode::terminated:
      return "terminated";
  }
  return "";
}

void require_mode(const Handle& handle, std::initializer_list<Mode> modes) {
  if (std::find(modes.begin(), modes.end(), handle.instance.mode()) != modes.end()) return;
  std::string allowed;
  for (const Mode mode : modes) allowed += (allowed.empty() ? "" : " or ") + std::string(words(mode));
  forbid("the instance must be " + allowed + ", but is " + words(handle.instance.mode()));
}

void require_interface(const Handle& handle, Interface interface) {
  if (handle.instance.interface() == interface) return;
  forbid(interface == Interface::model_exchange ? "the function is one of Model Exchange, but the instance is one of Co-Simulation"
                                                : "the function is one of Co-Simulation, but the instance is one of Model Exchange");
}

void require_pointer(const void* pointer, const char* what) {
  if (pointer == nullptr) forbid(std::string(what) + " must not be a null pointer");
}

void require_count(const char* what, std::size_t wanted, std::size_t given) {
  if (wanted != given) forbid(std::string(what) + " must be " + std::to_string(wanted) + ", but there are " + std::to_string(given));
}

fmi3Status answered(fmi3Instance instance, const char* function, const void* body, void (*run)(const void* body, Handle& handle)) noexcept {
  if (instance == nullptr) return fmi3Error;
  Handle& handle = *static_cast<Handle*>(instance);
  fmi3Status status = fmi3OK;
  try {
    std::string message;
    try {
      run(body, handle);
    } catch (const Refusal& refusal) {
      status = refusal.status;
      message = refusal.message;
    } catch (const qdot::Error& error) {  // of the model, at this state or these parameters
      status = fmi3Discard;
      message = error.what();
    } catch (const std::bad_alloc&) {
      status = fmi3Error;
      message = "there is no memory left";
    } catch (const std::exception& error) {
      status = fmi3Error;
      message = error.what();
    } catch (...) {
      status = fmi3Error;
      message = "a functor threw what is no std::exception";
    }
    for (const auto& [category, text] : handle.instance.news()) {
      const bool warns = std::strcmp(category, "logStatusWarning") == 0;
      handle.say(warns ? fmi3Warning : fmi3OK, category, text);
      if (warns && status == fmi3OK) status = fmi3Warning;
    }
    if (status == fmi3Discard) handle.say(status, "logStatusDiscard", std::string(function) + ": " + message);
    if (status == fmi3Error) {
      handle.say(status, "logStatusError", std::string(function) + ": " + message);
      if (handle.instance.mode() != Mode::instantiated) handle.instance.end();
    }
  } catch (...) {  // no memory for the message
    return fmi3Error;
  }
  return status;
}

}  // namespace qdot::fmi
