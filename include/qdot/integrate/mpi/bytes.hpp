#pragma once
// SPDX-License-Identifier: MIT
//
// Values as bytes, to be sent from one process of a program to another.
//
//     number, struct of numbers    as it lies in memory
//     string, std::vector, Eigen   its size, and what is in it
//     pair, tuple, array, State    what is in it
//     a type of the user's         what its to_bytes() makes of it, and from_bytes() takes
//
// The reader is the same program on a machine of the same kind, so types are not written. Nothing here knows MPI.
//
// A pointer means nothing in another process. One in a struct cannot be seen from here; pointers themselves, string_view and span are refused.

#include <Eigen/Core>
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <ranges>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/integrate/many_in_lanes.hpp"
#include "qdot/integrate/ensemble.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot::detail {

template <class T>
concept HasOwnBytes = std::default_initializable<T> && requires(const T& value, T& other, std::string_view bytes) {
  { to_bytes(value) } -> std::convertible_to<std::string>;
  from_bytes(bytes, other);
};

template <class T>
inline constexpr bool is_vector = false;
template <class T, class Allocator>
inline constexpr bool is_vector<std::vector<T, Allocator>> = true;

template <class T>
concept HasTupleSize = requires { std::tuple_size<T>::value; };

template <class T>
concept IsStoredMatrix = std::derived_from<T, Eigen::PlainObjectBase<typename T::PlainObject>>;

// What types of the library consist of.
template <class T>
struct Members {
  static constexpr bool are_known = false;
};
template <int n>
struct Members<State<n>> {
  static constexpr bool are_known = true;
  static auto of(auto& state) { return std::tie(state.t, state.q, state.qdot); }
};
template <int n>
struct Members<MotionEnd<n>> {
  static constexpr bool are_known = true;
  static auto of(auto& end) { return std::tie(end.state, end.outcome, end.message, end.event, end.steps, end.evaluations); }
};

template <class T>
constexpr bool can_be_sent();

// Sent as it lies in memory.
template <class T>
inline constexpr bool is_plain =
    !HasOwnBytes<T> && !Members<T>::are_known && !is_vector<T> && !IsStoredMatrix<T> && !HasTupleSize<T> &&
    std::is_trivially_copyable_v<T> && !std::is_pointer_v<T> && !std::is_member_pointer_v<T> && !std::ranges::view<T>;

template <class T, std::size_t... k>
constexpr bool all_can_be_sent(std::index_sequence<k...>) {
  return (can_be_sent<std::remove_cv_t<std::tuple_element_t<k, T>>>() && ...);
}

template <class T>
constexpr bool can_be_sent() {
  if constexpr (HasOwnBytes<T> || Members<T>::are_known || std::same_as<T, std::string>) {
    return true;
  } else if constexpr (is_vector<T>) {
    return can_be_sent<typename T::value_type>();
  } else if constexpr (IsStoredMatrix<T>) {
    return can_be_sent<typename T::Scalar>();
  } else if constexpr (HasTupleSize<T>) {
    return all_can_be_sent<T>(std::make_index_sequence<std::tuple_size_v<T>>());
  } else {
    return is_plain<T>;
  }
}

template <class T>
void write_bytes(std::string& bytes, const T& value);
template <class T>
T read_bytes(std::string_view& bytes);

template <class T>
void write_row(std::string& bytes, const T* values, std::size_t count) {
  if constexpr (is_plain<T>) {
    if (count > 0) bytes.append(reinterpret_cast<const char*>(values), count * sizeof(T));
  } else {
    for (std::size_t k = 0; k < count; ++k) write_bytes(bytes, values[k]);
  }
}
template <class T>
void read_row(std::string_view& bytes, T* values, std::size_t count) {
  if constexpr (is_plain<T>) {
    if (count > 0) std::memcpy(static_cast<void*>(values), bytes.data(), count * sizeof(T));
    bytes.remove_prefix(count * sizeof(T));
  } else {
    for (std::size_t k = 0; k < count; ++k) values[k] = read_bytes<T>(bytes);
  }
}

template <class T>
void write_bytes(std::string& bytes, const T& value) {
  if constexpr (HasOwnBytes<T>) {
    write_bytes(bytes, std::string(to_bytes(value)));
  } else if constexpr (Members<T>::are_known) {
    std::apply([&](const auto&... part) { (write_bytes(bytes, part), ...); }, Members<T>::of(value));
  } else if constexpr (std::same_as<T, std::string>) {
    write_bytes(bytes, static_cast<std::uint64_t>(value.size()));
    bytes += value;
  } else if constexpr (is_vector<T>) {
    write_bytes(bytes, static_cast<std::uint64_t>(value.size()));
    if constexpr (std::same_as<typename T::value_type, bool>)
      for (const bool part : value) write_bytes(bytes, part);
    else write_row(bytes, value.data(), value.size());
  } else if constexpr (IsStoredMatrix<T>) {
    write_bytes(bytes, std::array<Eigen::Index, 2>{value.rows(), value.cols()});
    write_row(bytes, value.data(), static_cast<std::size_t>(value.size()));
  } else if constexpr (HasTupleSize<T>) {
    std::apply([&](const auto&... part) { (write_bytes(bytes, part), ...); }, value);
  } else {
    write_row(bytes, &value, 1);
  }
}

// The value that bytes begin with, which then begin behind it.
template <class T>
T read_bytes(std::string_view& bytes) {
  if constexpr (HasOwnBytes<T>) {
    T value{};
    from_bytes(std::string_view(read_bytes<std::string>(bytes)), value);
    return value;
  } else if constexpr (Members<T>::are_known) {
    T value;
    std::apply([&](auto&... part) { ((part = read_bytes<std::remove_cvref_t<decltype(part)>>(bytes)), ...); }, Members<T>::of(value));
    return value;
  } else if constexpr (std::same_as<T, std::string>) {
    const auto size = static_cast<std::size_t>(read_bytes<std::uint64_t>(bytes));
    std::string value(bytes.substr(0, size));
    bytes.remove_prefix(size);
    return value;
  } else if constexpr (is_vector<T>) {
    T value;
    const auto size = static_cast<std::size_t>(read_bytes<std::uint64_t>(bytes));
    if constexpr (is_plain<typename T::value_type> && std::default_initializable<typename T::value_type> && !std::same_as<typename T::value_type, bool>) {
      value.resize(size);
      read_row(bytes, value.data(), size);
    } else {
      value.reserve(size);
      for (std::size_t k = 0; k < size; ++k) value.push_back(read_bytes<typename T::value_type>(bytes));
    }
    return value;
  } else if constexpr (IsStoredMatrix<T>) {
    const auto [rows, columns] = read_bytes<std::array<Eigen::Index, 2>>(bytes);
    T value;
    value.resize(rows, columns);
    read_row(bytes, value.data(), static_cast<std::size_t>(value.size()));
    return value;
  } else if constexpr (HasTupleSize<T>) {
    return [&]<std::size_t... k>(std::index_sequence<k...>) {
      return T{read_bytes<std::remove_cv_t<std::tuple_element_t<k, T>>>(bytes)...};
    }(std::make_index_sequence<std::tuple_size_v<T>>());
  } else {
    std::array<std::byte, sizeof(T)> memory;
    std::memcpy(memory.data(), bytes.data(), sizeof(T));
    bytes.remove_prefix(sizeof(T));
    return std::bit_cast<T>(memory);
  }
}

// What a motion threw, as it is known to all processes: by its message.
template <class R>
Kept<R> kept_by_message(const std::string& message) {
  return {{}, std::make_exception_ptr(Error(message))};
}

template <class R>
void write_kept(std::string& bytes, const Kept<R>& kept) {
  const auto head = bytes.size();
  const auto put = [&](const auto& what, bool completed) {
    bytes.resize(head);
    write_bytes(bytes, completed);
    write_bytes(bytes, std::uint64_t{0});
    const auto begin = bytes.size();
    write_bytes(bytes, what);
    const std::uint64_t size = bytes.size() - begin;  // a reader that cannot read it can skip to the next
    std::memcpy(bytes.data() + begin - sizeof size, &size, sizeof size);
  };
  try {
    if (kept.completed()) return put(*kept.value, true);
  } catch (...) {  // by to_bytes()
    return put(Kept<R>{{}, std::current_exception()}.message(), false);
  }
  put(kept.message(), false);
}

template <class R>
Kept<R> read_kept(std::string_view& bytes) {
  const bool completed = read_bytes<bool>(bytes);
  const auto size = static_cast<std::size_t>(read_bytes<std::uint64_t>(bytes));
  std::string_view own = bytes.substr(0, size);
  bytes.remove_prefix(size);
  if (!completed) return kept_by_message<R>(read_bytes<std::string>(own));
  try {
    return {read_bytes<R>(own), nullptr};
  } catch (...) {  // by from_bytes()
    return kept_by_message<R>(Kept<R>{{}, std::current_exception()}.message());
  }
}

template <class R>
constexpr void require_sendable() {
  static_assert(can_be_sent<R>(),
                "qdot: what a motion keeps is sent from process to process: it must be a number, a trivially copyable struct without pointers, a string, an Eigen vector, a State, a "
                "vector, pair or tuple of such, or a type R that can be default-constructed, with std::string to_bytes(const R&) and void from_bytes(std::string_view, R&) beside it");
}

}  // namespace qdot::detail
