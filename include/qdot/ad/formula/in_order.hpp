#pragma once
// SPDX-License-Identifier: MIT
//
// Sorting by little code.
//
// Every program that derives equations sorts lists of four or five types. std::sort is ten functions for each of them, and std::stable_sort more.
// The lists here are mostly in order already, or nearly so. Runs of 1, 2, 4, … elements are merged, as std::stable_sort does: elements that are
// alike keep their order.

#include <algorithm>
#include <cstddef>
#include <vector>

namespace qdot::formula {

/// Puts a list in order, elements that are alike in that in which they were.
template <class Element, class Before>
constexpr void put_in_order(std::vector<Element>& list, Before before) {
  const std::size_t size = list.size();
  std::size_t ordered = 1;
  while (ordered < size && !before(list[ordered], list[ordered - 1])) ++ordered;
  if (ordered >= size) return;
  std::vector<Element> merged(list);
  for (std::size_t run = 1; run < size; run *= 2, list.swap(merged))
    for (std::size_t first = 0; first < size; first += 2 * run) {
      const std::size_t middle = std::min(first + run, size), last = std::min(first + 2 * run, size);
      for (std::size_t k = first, a = first, b = middle; k < last; ++k)
        merged[k] = a < middle && (b == last || !before(list[b], list[a])) ? list[a++] : list[b++];
    }
}

}  // namespace qdot::formula
