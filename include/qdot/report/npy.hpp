#pragma once
// SPDX-License-Identifier: MIT
//
// NumPy's own formats: NPY (one array) and NPZ (a ZIP archive of NPY members, stored without compression).
//
//   NPY 1.0:  "\x93NUMPY" 1 0 | header length, 2 bytes | {'descr': '<f8', 'fortran_order': False, 'shape': (3, 2), }
//             padded with blanks to a multiple of 64 and ended by "\n" | the numbers, little-endian, row by row
//   NPZ:      per member  local header, name, bytes;  then the central directory;  then its end record
//
// numpy.load("x.npz")["q"] reads them without pickle. Sources: numpy.lib.format; PKWARE APPNOTE 6.3.

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "qdot/error.hpp"

namespace qdot::report {

/// A named array of doubles in row-major order; shape {rows} or {rows, columns}.
struct Array {
  std::string name;                ///< in the archive
  std::vector<std::size_t> shape;  ///< rows, or rows and columns
  std::vector<double> values;      ///< row by row
};

namespace detail {

/// Appends the lowest `bytes` bytes of an unsigned integer, lowest first.
inline void append_little_endian(std::string& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out += static_cast<char>(static_cast<unsigned char>(value >> (8 * i)));
}

inline std::string npy_header(const std::vector<std::size_t>& shape) {
  std::string text = "{'descr': '<f8', 'fortran_order': False, 'shape': (";
  for (const std::size_t extent : shape) text += std::to_string(extent) + ", ";
  if (shape.size() > 1) text.erase(text.size() - 2);  // (3, 2), but (3,) for a single extent
  if (shape.size() == 1) text.pop_back();
  text += "), }";
  constexpr std::size_t fixed = 10;  // magic, version, length
  text.append(63 - (fixed + text.size()) % 64, ' ');
  text += '\n';
  std::string header = "\x93NUMPY";
  header += '\x01';
  header += '\x00';
  append_little_endian(header, text.size(), 2);
  return header + text;
}

inline constexpr std::array<std::uint32_t, 256> crc32_table = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t n = 0; n < 256; ++n) {
    std::uint32_t c = n;
    for (int k = 0; k < 8; ++k) c = (c & 1U) != 0 ? 0xEDB88320U ^ (c >> 1) : c >> 1;
    table[n] = c;
  }
  return table;
}();

}  // namespace detail

/// The cyclic redundancy check of ZIP, PNG and Ethernet (polynomial 0xEDB88320, reflected).
inline std::uint32_t crc32(const std::string& bytes) {
  std::uint32_t c = 0xFFFFFFFFU;
  for (const char byte : bytes) {
    c = detail::crc32_table[(c ^ static_cast<unsigned char>(byte)) & 0xFFU] ^ (c >> 8);
  }
  return c ^ 0xFFFFFFFFU;
}

/// The bytes of an NPY file.
///
/// @throws DimensionError  when the shape's product is not the number of values
inline std::string npy(const Array& array) {
  std::size_t count = 1;
  for (const std::size_t extent : array.shape) count *= extent;
  if (count != array.values.size()) {
    throw DimensionError("array \"" + array.name + "\"", static_cast<long>(count),
                         static_cast<long>(array.values.size()), "give as many values as the shape says");
  }
  std::string bytes = detail::npy_header(array.shape);
  bytes.reserve(bytes.size() + 8 * count);
  for (const double x : array.values) detail::append_little_endian(bytes, std::bit_cast<std::uint64_t>(x), 8);
  return bytes;
}

/// The bytes of a ZIP archive that stores its members uncompressed, dated 1980-01-01 so that equal input gives equal bytes.
///
/// @param members  names and contents
/// @throws InvalidValue  beyond the format's 4 GiB
inline std::string stored_zip(const std::vector<std::pair<std::string, std::string>>& members) {
  constexpr std::uint64_t version = 20;
  constexpr std::uint64_t first_of_january_1980 = 0x0021;
  std::string archive;
  std::string directory;
  for (const auto& [name, bytes] : members) {
    std::string common;  // the part that the local header and the directory share
    detail::append_little_endian(common, version, 2);
    detail::append_little_endian(common, 0x0800, 2);  // names are UTF-8
    detail::append_little_endian(common, 0, 2);       // stored
    detail::append_little_endian(common, 0, 2);       // midnight
    detail::append_little_endian(common, first_of_january_1980, 2);
    detail::append_little_endian(common, crc32(bytes), 4);
    detail::append_little_endian(common, bytes.size(), 4);
    detail::append_little_endian(common, bytes.size(), 4);
    detail::append_little_endian(common, name.size(), 2);
    detail::append_little_endian(common, 0, 2);  // no extra field

    directory += "PK\x01\x02";
    detail::append_little_endian(directory, version, 2);
    directory += common;
    directory.append(2 + 2 + 2 + 4, '\0');  // comment, disk, internal and external attributes
    detail::append_little_endian(directory, archive.size(), 4);
    directory += name;

    archive += "PK\x03\x04" + common + name + bytes;
  }
  const std::size_t start = archive.size();
  if (start + directory.size() > 0xFFFFFFFFULL || members.size() > 0xFFFFULL) {
    throw InvalidValue("a plain ZIP archive holds less than 4 GiB and 65536 members; " + std::to_string(start) +
                       " bytes were given; write fewer samples");
  }
  archive += directory;
  archive += "PK\x05\x06";
  archive.append(2 + 2, '\0');
  detail::append_little_endian(archive, members.size(), 2);
  detail::append_little_endian(archive, members.size(), 2);
  detail::append_little_endian(archive, directory.size(), 4);
  detail::append_little_endian(archive, start, 4);
  archive.append(2, '\0');
  return archive;
}

/// The bytes of an NPZ file: every array becomes the member NAME.npy.
inline std::string npz(const std::vector<Array>& arrays) {
  std::vector<std::pair<std::string, std::string>> members;
  for (const Array& array : arrays) members.emplace_back(array.name + ".npy", npy(array));
  return stored_zip(members);
}

}  // namespace qdot::report
