#pragma once
// SPDX-License-Identifier: MIT
//
// Of thousands of bodies a picture shows some, and names have numbers.

#include <algorithm>
#include <string>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

/// Numbers from `first` to `last`, both of them and at most `most` in all, evenly spread.
inline std::vector<int> shown(int first, int last, int most = 240) {
  const int count = std::min(most, last - first + 1);
  std::vector<int> numbers;
  for (int i = 0; i < count; ++i) numbers.push_back(count == 1 ? first : first + static_cast<int>(static_cast<long>(last - first) * i / (count - 1)));
  return numbers;
}

/// 0, 1, … count − 1: the points of a line.
inline std::vector<int> in_a_row(std::size_t count) {
  std::vector<int> numbers(count);
  for (std::size_t i = 0; i < count; ++i) numbers[i] = static_cast<int>(i);
  return numbers;
}

/// x1, y1, x2, y2, … of `count` bodies.
inline std::vector<Coordinate> numbered(int count, const std::vector<Coordinate>& of_one) {
  std::vector<Coordinate> all;
  for (int i = 1; i <= count; ++i)
    for (const Coordinate& c : of_one) all.push_back({c.name + std::to_string(i), c.unit});
  return all;
}

}  // namespace qdot::scenes
