#pragma once
// SPDX-License-Identifier: MIT
//
// Where a simulator is (simulator.hpp), as a value and as bytes.
//
//     const SimulatorState before = plant.save();
//     write(file, serialized(before));   …   plant.restore(deserialized(read(file)));
//
// Bytes are t and y as they lie in memory behind a header of five words. These are a mark of the format, a number for the names of the
// components, their count, a checksum of it all, and the events that stopped it. A state that was cut short, changed on its way or taken
// from another system is refused by name, and nothing is changed by it.

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "qdot/error.hpp"

namespace qdot {

/// Where a Simulator is, all that its future depends on.
struct SimulatorState {
  double t = 0.0;                ///< time
  Eigen::VectorXd y;             ///< [q; q̇; z]
  std::uint64_t stopped_by = 0;  ///< events that stopped the last advance, a bit for each of the first 64
  std::uint64_t simulator = 0;   ///< a number for what the components are called, by which the state of another system is known
};

namespace detail {

// FNV-1a, 64 bits: noticed when a bit of some hundred bytes is another, not proof against malice.
inline std::uint64_t checksum(std::uint64_t sum, const void* data, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) sum = (sum ^ static_cast<const unsigned char*>(data)[i]) * 0x100000001b3u;
  return sum;
}
constexpr std::uint64_t empty_checksum = 0xcbf29ce484222325u;
constexpr std::uint64_t state_format = 0x3165746174737164u;  // "dqstate1" in this machine's byte order

}  // namespace detail

/// A saved state as bytes: it fits into a file or a message, and comes back with the same bits on any machine of the same byte order.
inline std::vector<std::byte> serialized(const SimulatorState& state) {
  const std::uint64_t header[5] = {detail::state_format, state.simulator, static_cast<std::uint64_t>(state.y.size()), 0, state.stopped_by};
  std::vector<std::byte> bytes(sizeof header + sizeof(double) * (1 + static_cast<std::size_t>(state.y.size())));
  std::memcpy(bytes.data(), header, sizeof header);
  std::memcpy(bytes.data() + sizeof header, &state.t, sizeof(double));
  if (state.y.size() > 0) std::memcpy(bytes.data() + sizeof header + sizeof(double), state.y.data(), sizeof(double) * static_cast<std::size_t>(state.y.size()));
  const std::uint64_t sum = detail::checksum(detail::empty_checksum, bytes.data(), bytes.size());
  std::memcpy(bytes.data() + 3 * sizeof(std::uint64_t), &sum, sizeof sum);
  return bytes;
}

/// The state that serialized() wrote.
///
/// @throws InvalidValue  bytes that serialized() did not write, cut short, or changed since
inline SimulatorState deserialized(std::span<const std::byte> bytes) {
  std::uint64_t header[5];
  std::vector<std::byte> copy(bytes.begin(), bytes.end());
  const auto refuse = [](const char* why) -> SimulatorState {
    throw InvalidValue(std::string("a saved state must be what serialized() wrote, but ") + why + "; take another copy");
  };
  if (bytes.size() < sizeof header + sizeof(double)) return refuse("it is cut short");
  std::memcpy(header, bytes.data(), sizeof header);
  if (header[0] != detail::state_format) return refuse("it does not begin like one");
  if (header[2] != (bytes.size() - sizeof header) / sizeof(double) - 1 || (bytes.size() - sizeof header) % sizeof(double) != 0)
    return refuse("it has another length");
  std::memset(copy.data() + 3 * sizeof(std::uint64_t), 0, sizeof(std::uint64_t));
  if (detail::checksum(detail::empty_checksum, copy.data(), copy.size()) != header[3]) return refuse("its checksum is wrong");
  SimulatorState state;
  state.simulator = header[1];
  state.stopped_by = header[4];
  state.y.resize(static_cast<Eigen::Index>(header[2]));
  std::memcpy(&state.t, bytes.data() + sizeof header, sizeof(double));
  if (state.y.size() > 0) std::memcpy(state.y.data(), bytes.data() + sizeof header + sizeof(double), sizeof(double) * static_cast<std::size_t>(state.y.size()));
  return state;
}

}  // namespace qdot
