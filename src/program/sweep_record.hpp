#pragma once
// SPDX-License-Identifier: MIT
//
// What came of one motion of a sweep, as a record in a file that grows while the sweep goes on.
//
//     file      "qdotrec1", a number for the sweep, record, record, …
//     record    a mark and a length, twice, once with its bits turned over | index | outcome | values | message | checksum
//
// A file ends wherever its writer was killed, and what comes out of a copy or off a disk is not always what went in. So a record is believed only
// where its checksum is right, which begins with the sweep's number: that of another sweep is none of this one. Behind one that is not believed the
// reader looks for the next mark, and loses no other. Numbers are bits as they lie in memory: no digit is lost, and files are read by machines of the
// same byte order.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/simulator_state.hpp"

namespace qdot::program {

/// What came of one motion.
struct Row {
  std::vector<double> values;
  Outcome outcome = Outcome::completed;
  std::string message = {};
};

class RecordFormat {
 public:
  static constexpr std::size_t head_size = 16;

  /// @param sweep   a number for the sweep
  /// @param width   values in each record
  /// @param count   of motions
  RecordFormat(std::uint64_t sweep, std::size_t width, std::size_t count) : sweep_(sweep), width_(width), count_(count) {}

  /// What a file begins with.
  std::string head() const {
    std::string bytes(head_size, '\0');
    std::memcpy(bytes.data(), &magic, sizeof magic);
    std::memcpy(bytes.data() + sizeof magic, &sweep_, sizeof sweep_);
    return bytes;
  }

  /// Whether a file that begins like this is of another sweep.
  bool is_foreign(std::string_view bytes) const {
    return bytes.size() >= head_size && at<std::uint64_t>(bytes, 0) == magic && at<std::uint64_t>(bytes, sizeof magic) != sweep_;
  }

  void append(std::string& bytes, std::size_t index, const Row& row) const {
    const std::size_t begin = bytes.size(), message = std::min(row.message.size(), longest_message);
    const auto put = [&](const auto& x) { bytes.append(reinterpret_cast<const char*>(&x), sizeof x); };
    const auto size = static_cast<std::uint32_t>(smallest() + message);
    put(mark);
    put(size);
    put(~size);
    put(static_cast<std::uint32_t>(row.outcome));
    put(static_cast<std::uint64_t>(index));
    for (std::size_t k = 0; k < width_; ++k) put(k < row.values.size() ? row.values[k] : std::numeric_limits<double>::quiet_NaN());
    bytes.append(row.message, 0, message);
    put(sum_of(std::string_view(bytes).substr(begin)));
  }

  /// The row of a record that read() has handed out.
  Row row(std::string_view record) const {
    Row row{.values = std::vector<double>(width_), .outcome = static_cast<Outcome>(at<std::uint32_t>(record, 12))};
    if (width_ > 0) std::memcpy(row.values.data(), record.data() + front, width_ * sizeof(double));
    row.message = record.substr(front + width_ * sizeof(double), record.size() - smallest());
    return row;
  }

  struct Read {
    std::size_t used = 0;     // bytes; a record that is still being written may follow them
    std::size_t damages = 0;  // places at which something was left out
  };

  /// Hands out the records in some bytes of a file, see(index, record), from its beginning or from where it was read to before.
  ///
  /// @param at_head  whether they are the file's first
  template <class See>
  Read read(std::string_view bytes, bool at_head, const See& see) const {
    Read read;
    if (at_head) {
      if (bytes.size() < head_size) return read;
      if (bytes.substr(0, head_size) == head()) read.used = head_size;
    }
    bool believed = true;
    while (read.used < bytes.size()) {
      const std::string_view rest = bytes.substr(read.used);
      const std::optional<std::size_t> size = size_of(rest);
      if (size && *size > rest.size()) break;  // not all of it is there
      if (size && *size > 0) {
        believed = true;
        see(static_cast<std::size_t>(at<std::uint64_t>(rest, 16)), rest.substr(0, *size));
        read.used += *size;
        continue;
      }
      if (std::exchange(believed, false)) ++read.damages;
      const std::size_t next = bytes.find(std::string_view(reinterpret_cast<const char*>(&mark), sizeof mark), read.used + 1);
      read.used = next != std::string_view::npos ? next : bytes.size();
    }
    return read;
  }

 private:
  static constexpr std::uint64_t magic = 0x31636572746f6471u;  // "qdotrec1" where the low byte is the first
  static constexpr std::uint32_t mark = 0xb1c5a37du;
  static constexpr std::size_t front = 24, longest_message = 1'000'000;

  template <class T>
  static T at(std::string_view bytes, std::size_t place) {
    T x;
    std::memcpy(&x, bytes.data() + place, sizeof x);
    return x;
  }

  std::size_t smallest() const { return front + width_ * sizeof(double) + sizeof(std::uint64_t); }

  std::uint64_t sum_of(std::string_view record) const {
    return qdot::detail::checksum(qdot::detail::empty_checksum ^ sweep_, record.data(), record.size());
  }

  // Bytes of the record that these begin with, which may be more than there are; nothing where they do not begin with one.
  std::optional<std::size_t> size_of(std::string_view rest) const {
    if (rest.size() < front) return at_mark(rest) ? std::optional<std::size_t>(front) : std::nullopt;
    const auto size = at<std::uint32_t>(rest, 4);
    if (!at_mark(rest) || size != static_cast<std::uint32_t>(~at<std::uint32_t>(rest, 8))) return {};
    if (size < smallest() || size > smallest() + longest_message) return {};
    if (size > rest.size()) return size;
    const std::size_t summed = size - sizeof(std::uint64_t);
    if (sum_of(rest.substr(0, summed)) != at<std::uint64_t>(rest, summed) || at<std::uint64_t>(rest, 16) >= count_) return {};
    return size;
  }

  static bool at_mark(std::string_view rest) {
    const std::string_view wanted(reinterpret_cast<const char*>(&mark), sizeof mark);
    return rest.substr(0, sizeof mark) == wanted.substr(0, std::min(rest.size(), sizeof mark));
  }

  std::uint64_t sweep_;
  std::size_t width_, count_;
};

}  // namespace qdot::program
