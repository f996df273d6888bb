#pragma once
// SPDX-License-Identifier: MIT
//
// An order of the unknowns that keeps the factors of a symmetric matrix sparse: Eigen's approximate minimum degree.
//
// It is apart from sparse_factors.hpp because Eigen's sparse matrices take longer to read than the factors themselves. Programs that link qdot::compiled
// do not read this file: the library has it.

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <cstddef>
#include <vector>

#include "qdot/mechanics/equations/sparse_factors.hpp"

namespace qdot::detail {

template <class Number>
[[gnu::cold]] void PatternFactors<Number>::order(const std::vector<int>& rows, const std::vector<int>& columns) {
  std::vector<Eigen::Triplet<Number>> entries;
  for (std::size_t k = 0; k < rows.size(); ++k) entries.emplace_back(rows[k], columns[k], Number(1.0));
  const auto n = static_cast<Eigen::Index>(size());
  Eigen::SparseMatrix<Number> pattern(n, n);
  pattern.setFromTriplets(entries.begin(), entries.end());
  using Index = typename Eigen::SparseMatrix<Number>::StorageIndex;
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, Index> old_of_new;
  Eigen::AMDOrdering<Index>()(pattern.template selfadjointView<Eigen::Lower>(), old_of_new);
  new_place_.resize(size());
  for (std::size_t i = 0; i < size(); ++i) new_place_[static_cast<std::size_t>(old_of_new.indices()[static_cast<Eigen::Index>(i)])] = i;
}

}  // namespace qdot::detail
