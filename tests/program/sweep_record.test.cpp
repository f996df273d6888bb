// SPDX-License-Identifier: MIT
//
// Records of a sweep: what is written comes back to the bit, and what was cut short or changed is left out alone.
#include "program/sweep_record.hpp"

#include <bit>
#include <limits>
#include <string>
#include <vector>

#include "catch2_bridge.hpp"

using namespace qdot;
using program::RecordFormat;
using program::Row;

namespace {

const RecordFormat format(17, 2, 1000);

Row row(std::size_t i) {
  const double x = 0.1 * static_cast<double>(i);
  if (i % 3 == 1) return {{x, std::numeric_limits<double>::quiet_NaN()}, Outcome::refused_by_model, "number " + std::to_string(i)};
  return {{x, -x}};
}

/// A file with motions 0 … count − 1, and where each record begins; one more for the end.
std::string file(std::size_t count, std::vector<std::size_t>& begins) {
  std::string bytes = format.head();
  for (std::size_t i = 0; i < count; ++i) {
    begins.push_back(bytes.size());
    format.append(bytes, i, row(i));
  }
  begins.push_back(bytes.size());
  return bytes;
}

struct Found {
  std::vector<std::size_t> numbers;
  RecordFormat::Read read;
};

Found found(const std::string& bytes, const RecordFormat& by = format) {
  Found found;
  found.read = by.read(bytes, true, [&](std::size_t i, std::string_view) { found.numbers.push_back(i); });
  return found;
}

}  // namespace

TEST_CASE("a record comes back to the bit, with its outcome and message") {
  std::vector<std::size_t> begins;
  const std::string bytes = file(7, begins);
  std::size_t next = 0;
  const auto read = format.read(bytes, true, [&](std::size_t i, std::string_view record) {
    CHECK(i == next);
    const Row is = format.row(record), was = row(next++);
    for (std::size_t k = 0; k < 2; ++k) CHECK(std::bit_cast<std::uint64_t>(is.values[k]) == std::bit_cast<std::uint64_t>(was.values[k]));
    CHECK(is.outcome == was.outcome);
    CHECK(is.message == was.message);
  });
  CHECK(next == 7);
  CHECK(read.used == bytes.size());
  CHECK(read.damages == 0);
}

TEST_CASE("a file that ends anywhere gives the records that are whole, and the rest of it gives the others") {
  std::vector<std::size_t> begins;
  const std::string bytes = file(5, begins);
  for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
    const Found first = found(bytes.substr(0, cut));
    std::size_t whole = 0;
    while (whole < 5 && begins[whole + 1] <= cut) ++whole;
    if (first.numbers.size() != whole || first.read.damages != 0) FAIL("cut at byte " << cut);
    std::size_t others = 0;
    format.read(std::string_view(bytes).substr(first.read.used), first.read.used == 0, [&](std::size_t, std::string_view) { ++others; });
    if (others != 5 - whole) FAIL("read on from byte " << first.read.used);
  }
}

TEST_CASE("any bit that is changed in a record costs this record and no other") {
  std::vector<std::size_t> begins;
  const std::string bytes = file(3, begins);
  for (std::size_t bit = 8 * begins[1]; bit < 8 * begins[2]; ++bit) {
    std::string changed = bytes;
    changed[bit / 8] = static_cast<char>(changed[bit / 8] ^ (1 << bit % 8));
    const Found left = found(changed);
    if (left.numbers != std::vector<std::size_t>{0, 2} || left.read.damages != 1) FAIL("bit " << bit);
  }
  std::string zeros = bytes;  // as some file systems leave what had not come to the disk
  zeros.replace(begins[1], begins[2] - begins[1], begins[2] - begins[1], '\0');
  CHECK(found(zeros).numbers == std::vector<std::size_t>{0, 2});
  std::string head = bytes;
  head[3] = '?';
  CHECK(found(head).numbers == std::vector<std::size_t>{0, 1, 2});
}

TEST_CASE("a record of another sweep is none of this one") {
  std::vector<std::size_t> begins;
  const std::string bytes = file(4, begins);
  const RecordFormat other(18, 2, 1000), shorter(17, 2, 2);
  CHECK(other.is_foreign(bytes));
  CHECK(!format.is_foreign(bytes));
  CHECK(found(bytes, other).numbers.empty());
  CHECK(found(format.head() + bytes.substr(begins[0]), other).numbers.empty());
  CHECK(found(bytes, shorter).numbers == std::vector<std::size_t>{0, 1});  // there is no motion 2 in it
}
