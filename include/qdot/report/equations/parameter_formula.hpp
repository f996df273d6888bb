#pragma once
// SPDX-License-Identifier: MIT
//
// A number as a formula of parameters.
//
//     c(p) = Σ k p₁ᵃ p₂ᵇ …        k: numbers,   a, b: whole or half,    or sin p, cos p in place of a power,
//
// or one over such a sum, or its root. A number can only be evaluated for given parameters. By trying one parameter at a time, with all others
// held, one finds of which powers it is a sum. Then k is the solution of a small linear system for each parameter. What was found is tried at
// values that nothing was found from. Numbers k that are quotients of small whole numbers, or have few digits, are made exact.

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "qdot/ad/formula/analytic_function.hpp"

namespace qdot::report::detail {

/// p^exponent, sin p or cos p.
struct ParameterFactor {
  formula::Function function = formula::Function::none;
  double exponent = 0.0;

  double value(double p) const { return function == formula::Function::none ? std::pow(p, exponent) : formula::value_of(function, p); }
  bool is_one() const { return function == formula::Function::none && exponent == 0.0; }
};

struct ParameterTerm {
  double k = 0.0;
  std::vector<ParameterFactor> factors;  // one for each parameter
};

/// What becomes a sum of terms: the number itself, one over it, or its square.
enum class ParameterRoot { none, reciprocal, root };

struct ParameterFormula {
  ParameterRoot root = ParameterRoot::none;
  bool negative = false;  // of a root
  std::vector<ParameterTerm> terms;

  bool is_constant() const {
    return std::all_of(terms.begin(), terms.end(), [](const ParameterTerm& t) {
      return std::all_of(t.factors.begin(), t.factors.end(), [](const ParameterFactor& f) { return f.is_one(); });
    });
  }
};

/// The nearest quotient of small whole numbers, or number of twelve digits, if x is that but for an error; otherwise x.
inline double tidy(double x, double error) {
  for (int q = 1; q <= 1000; ++q) {
    const double p = std::round(x * q);
    if (std::abs(p) <= 1e6 && p != 0.0 && std::abs(x * q - p) <= error * std::abs(p)) return p / q;
  }
  if (x == 0.0) return x;
  const double digits = std::pow(10.0, 11.0 - std::floor(std::log10(std::abs(x))));
  const double rounded = std::isfinite(digits) && digits > 0.0 ? std::round(x * digits) / digits : x;
  return std::abs(rounded - x) <= error * std::abs(x) ? rounded : x;
}

/// Where parameters are when a number is asked for: node numbers from 0, −1 for the value in the middle, below that others.
using ParameterNodes = std::vector<int>;
inline constexpr int nodes_per_parameter = 9;

/// Finds the formula of one number.
template <class = void>  // compiled only where it is made
class ParameterFit {
 public:
  /// @param number  at some nodes of the parameters
  /// @param value   of parameter j at one of its nodes
  /// @param named   parameters that are letters; the others are never moved
  ParameterFit(std::function<double(const ParameterNodes&)> number, std::function<double(std::size_t, int)> value, const std::vector<bool>& named)
      : number_(std::move(number)), value_(std::move(value)), named_(named), middle_(named.size(), -1) {}

  /// False when there is none.
  bool find(ParameterFormula& f) {
    unfit_.assign(named_.size(), false);
    for (const ParameterRoot root : {ParameterRoot::none, ParameterRoot::reciprocal, ParameterRoot::root}) {
      f = {.root = root, .negative = root == ParameterRoot::root && number_(middle_) < 0.0, .terms = {}};
      if (find_sum(f)) return true;
    }
    return false;
  }

  /// After a find() in vain: the parameters that enter in no such way, if it is some of them.
  const std::vector<bool>& unfit() const { return unfit_; }

 private:
  double transformed(const ParameterNodes& at, ParameterRoot root) const {
    const double c = number_(at);
    return root == ParameterRoot::reciprocal ? 1.0 / c : root == ParameterRoot::root ? c * c : c;
  }

  bool find_sum(ParameterFormula& f) {
    sets_.assign(named_.size(), {ParameterFactor{}});
    std::size_t runs = 1;
    bool fits = true;
    for (std::size_t j = 0; j < named_.size(); ++j) {
      if (named_[j] && !find_factors(j, f.root, sets_[j])) {
        if (f.root == ParameterRoot::none) unfit_[j] = true;
        fits = false;
      }
      runs *= sets_[j].size();
    }
    constexpr std::size_t most_runs = 3000;
    if (!fits || runs > most_runs) return false;
    ParameterNodes at = middle_;
    f.terms = terms_from(0, f.root, at);
    double largest = 0.0;
    for (const ParameterTerm& t : f.terms) largest = std::max(largest, std::abs(value_of(t, middle_)));
    std::erase_if(f.terms, [&](const ParameterTerm& t) { return t.k == 0.0 || std::abs(value_of(t, middle_)) <= rounding_of_k * largest; });
    for (ParameterTerm& t : f.terms) t.k = tidy(t.k, f.is_constant() ? rounding : f.terms.size() == 1 ? rounding_of_quotient : rounding_of_fit);
    for (int trial = -2; trial >= -4; --trial) {
      const ParameterNodes fresh(named_.size(), trial);
      double sum = 0.0, size = 0.0;
      for (const ParameterTerm& t : f.terms) {
        const double value = value_of(t, fresh);
        sum += value;
        size += std::abs(value);
      }
      if (!(std::abs(sum - transformed(fresh, f.root)) <= misfit * size)) return false;
    }
    return true;
  }

  // The fewest functions of parameter j that the number is a sum of, the others held.
  bool find_factors(std::size_t j, ParameterRoot root, std::vector<ParameterFactor>& factors) const {
    static const std::vector<ParameterFactor> all = [] {
      std::vector<ParameterFactor> list;
      for (const double e : {0.0, 1.0, 2.0, -1.0, 3.0, -2.0, 0.5, -0.5, 4.0, -3.0, 1.5, -1.5, 5.0}) list.push_back({formula::Function::none, e});
      list.push_back({formula::Function::sin, 0.0});
      list.push_back({formula::Function::cos, 0.0});
      return list;
    }();
    ParameterNodes at = middle_;
    Eigen::VectorXd x(nodes_per_parameter), y(nodes_per_parameter);
    for (int k = 0; k < nodes_per_parameter; ++k) {
      at[j] = k;
      x[k] = value_(j, k);
      y[k] = transformed(at, root);
    }
    if (!y.allFinite()) return false;
    const auto fits = [&](const std::vector<ParameterFactor>& set) {
      const auto size = static_cast<int>(set.size());
      Eigen::MatrixXd A(nodes_per_parameter, size), few(size, size);
      Eigen::VectorXd b(size);
      for (int e = 0; e < size; ++e)
        for (int k = 0; k < nodes_per_parameter; ++k) A(k, e) = set[static_cast<std::size_t>(e)].value(x[k]);
      for (int k = 0; k < size; ++k) {
        few.row(k) = A.row(chosen(k, size));
        b[k] = y[chosen(k, size)];
      }
      return (A * few.fullPivLu().solve(b) - y).cwiseAbs().maxCoeff() <= misfit * y.cwiseAbs().maxCoeff();
    };
    for (std::size_t a = 0; a < all.size(); ++a)
      if (fits(factors = {all[a]})) return true;
    for (std::size_t a = 0; a < all.size(); ++a)
      for (std::size_t b = a + 1; b < all.size(); ++b)
        if (fits(factors = {all[a], all[b]})) return true;
    for (std::size_t a = 0; a < all.size(); ++a)
      for (std::size_t b = a + 1; b < all.size(); ++b)
        for (std::size_t c = b + 1; c < all.size(); ++c)
          if (fits(factors = {all[a], all[b], all[c]})) return true;
    return false;
  }

  // As many nodes as unknowns, far from each other.
  static int chosen(int k, int size) { return size == 1 ? nodes_per_parameter / 2 : k * (nodes_per_parameter - 1) / (size - 1); }

  double value_of(const ParameterTerm& t, const ParameterNodes& at) const {
    double value = t.k;
    for (std::size_t j = 0; j < t.factors.size(); ++j) value *= t.factors[j].value(value_(j, at[j]));
    return value;
  }

  // Terms in the parameters from j on, those before at given nodes.
  std::vector<ParameterTerm> terms_from(std::size_t j, ParameterRoot root, ParameterNodes& at) const {
    if (j == named_.size()) return {{transformed(at, root), {}}};
    const std::vector<ParameterFactor>& set = sets_[j];
    const auto size = static_cast<int>(set.size());
    Eigen::MatrixXd A(size, size), b;
    std::vector<ParameterTerm> rest;
    for (int k = 0; k < size; ++k) {
      at[j] = size == 1 && set[0].is_one() ? -1 : chosen(k, size);
      for (int e = 0; e < size; ++e) A(k, e) = set[static_cast<std::size_t>(e)].value(value_(j, at[j]));
      rest = terms_from(j + 1, root, at);
      if (k == 0) b.resize(size, static_cast<int>(rest.size()));
      for (std::size_t m = 0; m < rest.size(); ++m) b(k, static_cast<int>(m)) = rest[m].k;
    }
    at[j] = -1;
    const Eigen::MatrixXd solved = size == 1 ? Eigen::MatrixXd(b / A(0, 0)) : Eigen::MatrixXd(A.fullPivLu().solve(b));
    std::vector<ParameterTerm> terms;
    for (int e = 0; e < size; ++e)
      for (std::size_t m = 0; m < rest.size(); ++m) {
        terms.push_back({solved(e, static_cast<int>(m)), rest[m].factors});
        terms.back().factors.insert(terms.back().factors.begin(), set[static_cast<std::size_t>(e)]);
      }
    return terms;
  }

  static constexpr double misfit = 2e-12;         // rounding of some ten operations, larger where three unknowns are solved for
  static constexpr double rounding = 4e-16, rounding_of_quotient = 2e-14, rounding_of_fit = 1e-12;
  static constexpr double rounding_of_k = 1e-9;  // of terms that are not there

  std::function<double(const ParameterNodes&)> number_;
  std::function<double(std::size_t, int)> value_;
  const std::vector<bool>& named_;
  std::vector<bool> unfit_;
  ParameterNodes middle_;
  std::vector<std::vector<ParameterFactor>> sets_;
};

}  // namespace qdot::report::detail
