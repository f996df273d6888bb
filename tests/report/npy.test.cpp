// SPDX-License-Identifier: MIT
#include "qdot/report/npy.hpp"

#include <bit>
#include <cstdint>
#include <string>

#include "catch2_bridge.hpp"

using namespace qdot::report;

namespace {

std::uint64_t little_endian(const std::string& bytes, std::size_t at, int count) {
  std::uint64_t value = 0;
  for (int i = 0; i < count; ++i) {
    value |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[at + static_cast<std::size_t>(i)])) << (8 * i);
  }
  return value;
}

}  // namespace

TEST_CASE("the CRC-32 is the one of ZIP and PNG") {
  // Check values of the catalogue of parametrised CRC algorithms (CRC-32/ISO-HDLC) and of RFC 3720's "The quick brown fox".
  CHECK(crc32("123456789") == 0xCBF43926U);
  CHECK(crc32("The quick brown fox jumps over the lazy dog") == 0x414FA339U);
  CHECK(crc32("") == 0U);
}

TEST_CASE("an NPY file begins with NumPy's magic, and its numbers begin at a multiple of 64") {
  const std::string bytes = npy({"q", {3, 2}, {1, 2, 3, 4, 5, 6}});
  REQUIRE(bytes.substr(0, 6) == "\x93NUMPY");
  CHECK(bytes[6] == 1);
  CHECK(bytes[7] == 0);
  const std::size_t length = little_endian(bytes, 8, 2);
  CHECK((10 + length) % 64 == 0);
  CHECK(bytes[10 + length - 1] == '\n');
  CHECK(bytes.substr(10, 61) == "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 2), }  ");
  REQUIRE(bytes.size() == 10 + length + 6 * 8);
  CHECK(std::bit_cast<double>(little_endian(bytes, 10 + length + 3 * 8, 8)) == 4.0);
}

TEST_CASE("the shape of an NPY file is a Python tuple at every rank") {
  CHECK(npy({"a", {3}, {1, 2, 3}}).find("'shape': (3,), }") != std::string::npos);
  CHECK(npy({"a", {}, {1}}).find("'shape': (), }") != std::string::npos);
  CHECK(npy({"a", {0, 2}, {}}).find("'shape': (0, 2), }") != std::string::npos);
}

TEST_CASE("a shape that disagrees with the number of values is refused") {
  CHECK_THROWS_AS(npy({"q", {2, 2}, {1, 2, 3}}), qdot::DimensionError);
}

TEST_CASE("an NPZ file's directory points at its members") {
  const std::string bytes = npz({{"t", {2}, {0.0, 0.5}}, {"q", {2}, {1.0, 2.0}}});
  REQUIRE(bytes.size() > 22);
  const std::size_t end = bytes.size() - 22;
  REQUIRE(bytes.substr(end, 4) == "PK\x05\x06");
  CHECK(little_endian(bytes, end + 10, 2) == 2);
  const std::size_t directory = little_endian(bytes, end + 16, 4);
  CHECK(directory + little_endian(bytes, end + 12, 4) == end);
  REQUIRE(bytes.substr(directory, 4) == "PK\x01\x02");
  const std::size_t member = little_endian(bytes, directory + 42, 4);
  REQUIRE(bytes.substr(member, 4) == "PK\x03\x04");
  CHECK(bytes.substr(member + 30, 5) == "t.npy");
  const std::string content = npy({"t", {2}, {0.0, 0.5}});
  CHECK(bytes.substr(member + 35, content.size()) == content);
  CHECK(little_endian(bytes, member + 14, 4) == crc32(content));
}
