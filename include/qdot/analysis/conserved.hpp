#pragma once
// SPDX-License-Identifier: MIT
//
// What is conserved
// =================
//
//     d/dt ∂L/∂q̇_k = ∂L/∂q_k + Q_k + (Jᵀλ)_k         p_k stays where q_k is cyclic (not in L) and no effect pushes along it
//     d/dt h = −∂L/∂t + q̇·Q − λ·∂φ/∂t                h = q̇·p − L stays where t is not in L, no force does work, and no
//                                                    constraint is moved from outside
// h is the energy T + V where T is a quadratic form of the velocities, for then q̇·p = 2T. On a hoop that a motor turns
// it is not: Jacobi's integral h stays, T + V does not. T, V and effects are run once on a scalar that records its
// operations, and a coordinate that does not occur is cyclic. Where one occurs, its slope may still cancel; it is
// evaluated at scattered points (analysis/symmetry/vanishing.hpp). A sum of momenta may stay where none of them does
// (analysis/symmetry/common_shifts.hpp). "Not found" does not mean "not conserved". A rotation in Cartesian coordinates
// is no shift of them (see noether_integral()). A T that branches on the state has no formula, and what actions of
// events do is not seen.

#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "qdot/analysis/symmetry/common_shifts.hpp"
#include "qdot/analysis/symmetry/recorded_scene.hpp"
#include "qdot/analysis/symmetry/vanishing.hpp"
#include "qdot/error.hpp"

namespace qdot {

/// A quantity, and whether it was found to be conserved.
struct Conservation {
  std::string name;    ///< "p_phi", "h", "T + V"
  bool found = false;  ///< false: not found, which is not the same as not conserved
  std::string reason;  ///< why, or what is in the way
};

/// A sum of momenta that is conserved though they are not, such as the total momentum: Σ coefficients_k p_k.
struct ConservedSum {
  std::string name;              ///< "p_x1 + p_x2"
  std::string reason;            ///< why
  Eigen::VectorXd coefficients;  ///< n, zero for momenta that are conserved themselves
};

/// What conserved_quantities() has found.
struct ConservedQuantities {
  std::vector<Conservation> momenta;  ///< of each coordinate, in their order; their values are conjugate_momenta()
  std::vector<ConservedSum> sums;     ///< of momenta that are not conserved one by one
  Conservation jacobi;                ///< h = q̇·p − L, which is jacobi_energy()
  Conservation energy;                ///< T + V, which is energy(); the same as h where T is a quadratic form of the velocities

  /// Numbers of the coordinates whose momenta are conserved: what routh_reduction() can leave out.
  std::vector<int> cyclic() const {
    std::vector<int> numbers;
    for (std::size_t i = 0; i < momenta.size(); ++i)
      if (momenta[i].found) numbers.push_back(static_cast<int>(i));
    return numbers;
  }
};

namespace detail {

template <class = void>  // compiled only where it is made
class ConservedSearch {
 public:
  explicit ConservedSearch(RecordedScene scene) : scene_(std::move(scene)), graph_(scene_.motion.recording.graph) {
    if (scene_.unreadable.empty()) L_ = graph_.difference(scene_.T, scene_.V);
  }

  ConservedQuantities quantities() {
    ConservedQuantities all;
    for (std::size_t k = 0; k < scene_.names.size(); ++k) all.momenta.push_back(momentum(k));
    all.sums = sums(all);
    all.jacobi = jacobi();
    all.energy = {"T + V", false, all.jacobi.reason};
    if (!all.jacobi.found) return all;
    if (!scene_.unreadable.empty()) {
      all.energy.reason = scene_.unreadable + ", so it is not known whether T is a quadratic form of the velocities";
      return all;
    }
    std::vector<int> excess;  // 2T − q̇·p
    for (const int term : summands(graph_, scene_.T)) {
      const std::vector<int> p = graph_.gradient(term, scene_.motion.qdot);
      int of_term = graph_.scaled(term, 2.0);
      for (std::size_t i = 0; i < p.size(); ++i) of_term = graph_.difference(of_term, graph_.product(p[i], scene_.motion.qdot[i]));
      excess.push_back(of_term);
    }
    all.energy.found = sum_vanishes(graph_, excess, scene_.variables);
    all.energy.reason = all.energy.found ? all.jacobi.reason + ", and T is a quadratic form of the velocities"
                                         : "T is no quadratic form of the velocities, so that h is another quantity than T + V";
    return all;
  }

 private:
  bool occurs(int variable, int node) const {
    return node >= variable && graph_.dependence(node, std::vector<int>{variable})[static_cast<std::size_t>(node)] != 0;
  }
  bool is_zero(int node) { return sum_vanishes(graph_, summands(graph_, node), scene_.variables); }

  // Whether ∂L/∂x is zero though x occurs, term by term of L.
  bool cancels(int variable) {
    if (!is_zero(graph_.gradient(L_, std::vector<int>{variable})[0])) return false;
    std::vector<int> slopes;
    for (const int term : summands(graph_, L_))
      if (occurs(variable, term)) slopes.push_back(graph_.gradient(term, std::vector<int>{variable})[0]);
    return sum_vanishes(graph_, slopes, scene_.variables);
  }

  // Whether L does not depend on a variable, and why; `found` and `reason` are set.
  void ask_lagrangian(Conservation& c, int variable, const std::string& name) {
    const bool in_T = occurs(variable, scene_.T), in_V = occurs(variable, scene_.V);
    c.found = true;
    if (!in_T && !in_V) {
      c.reason = name + " does not occur in L";
    } else if (cancels(variable)) {
      c.reason = name + " cancels in L: dL/d" + name + " is zero to rounding at scattered points";
    } else {
      c.found = false;
      c.reason = name + " occurs in " + (in_T && in_V ? "T and V" : in_T ? "T" : "V");
    }
  }

  Conservation momentum(std::size_t k) {
    Conservation c{"p_" + scene_.names[k], false, scene_.unreadable};
    if (!scene_.unreadable.empty()) return c;
    ask_lagrangian(c, scene_.motion.q[k], scene_.names[k]);
    const std::size_t n = scene_.names.size();
    for (const RecordedEffect& e : scene_.effects) {
      if (!c.found) break;
      if (!e.unreadable.empty()) {
        c = {c.name, false, e.name + " " + e.unreadable + ", so it is not known whether it acts on " + scene_.names[k]};
        break;
      }
      for (std::size_t i = k; i < e.force.size(); i += n)
        if (c.found && !is_zero(e.force[i])) c = {c.name, false, "the force of " + e.name + " acts on " + scene_.names[k]};
      for (std::size_t i = k; i < e.J.size(); i += n)
        if (c.found && !is_zero(e.J[i])) c = {c.name, false, "the constraint " + e.name + " acts on " + scene_.names[k]};
    }
    if (c.found && !scene_.effects.empty()) c.reason += ", and no effect acts on it";
    return c;
  }

  // The entries of a vector of n that belong to coordinates `open`.
  static std::vector<int> entries(const std::vector<int>& vector, std::size_t first, const std::vector<std::size_t>& open) {
    std::vector<int> chosen;
    for (const std::size_t k : open) chosen.push_back(vector[first + k]);
    return chosen;
  }

  std::vector<ConservedSum> sums(const ConservedQuantities& all) {
    std::vector<std::size_t> open;
    for (std::size_t k = 0; k < all.momenta.size(); ++k)
      if (!all.momenta[k].found) open.push_back(k);
    bool is_readable = scene_.unreadable.empty();
    for (const RecordedEffect& e : scene_.effects) is_readable = is_readable && e.unreadable.empty();
    if (!is_readable || open.size() < 2) return {};
    const std::size_t n = scene_.names.size();
    std::vector<std::vector<int>> pushes, slopes{entries(graph_.gradient(L_, scene_.motion.q), 0, open)};
    for (const RecordedEffect& e : scene_.effects)
      for (const std::vector<int>* list : {&e.force, &e.J})
        for (std::size_t first = 0; first + n <= list->size(); first += n) pushes.push_back(entries(*list, first, open));
    slopes.insert(slopes.end(), pushes.begin(), pushes.end());
    const Eigen::MatrixXd shifts = common_shifts(graph_, slopes, scene_.variables);
    std::vector<ConservedSum> found;
    for (Eigen::Index row = 0; row < shifts.rows(); ++row) {
      const auto along = [&](const std::vector<int>& g) {  // d·g
        int sum = graph_.constant(0.0);
        for (std::size_t i = 0; i < g.size(); ++i) sum = graph_.sum(sum, graph_.scaled(g[i], shifts(row, static_cast<Eigen::Index>(i))));
        return sum;
      };
      std::vector<int> terms;
      for (const int term : summands(graph_, L_)) terms.push_back(along(entries(graph_.gradient(term, scene_.motion.q), 0, open)));
      bool is_right = sum_vanishes(graph_, terms, scene_.variables);
      for (const std::vector<int>& g : pushes) is_right = is_right && is_zero(along(g));
      if (!is_right) continue;
      ConservedSum sum{
          "", std::string("L stays the same where these are shifted together") + (pushes.empty() ? "" : ", and no effect acts along that"),
          Eigen::VectorXd::Zero(static_cast<Eigen::Index>(n))};
      for (std::size_t i = 0; i < open.size(); ++i) {
        const double c = shifts(row, static_cast<Eigen::Index>(i));
        if (c == 0.0) continue;
        sum.coefficients[static_cast<Eigen::Index>(open[i])] = c;
        sum.name += sum.name.empty() ? (c < 0.0 ? "-" : "") : (c < 0.0 ? " - " : " + ");
        if (std::abs(c) != 1.0) sum.name += sentence({{std::abs(c), 6}, " "});
        sum.name += "p_" + scene_.names[open[i]];
      }
      found.push_back(sum);
    }
    return found;
  }

  Conservation jacobi() {
    Conservation c{"h", false, ""};
    if (scene_.unreadable.empty()) {
      ask_lagrangian(c, scene_.motion.t, "t");
    } else {
      c.found = scene_.autonomous;
      c.reason = scene_.autonomous ? "neither T nor V takes the time" : scene_.unreadable + ", so it is not known whether t occurs in L";
    }
    const std::size_t n = scene_.names.size();
    for (const RecordedEffect& e : scene_.effects) {
      if (!c.found) break;
      if (!e.unreadable.empty()) {
        c = {c.name, false, e.name + " " + e.unreadable + ", so it is not known whether it does work"};
        break;
      }
      if (*e.takes != 0) c = {c.name, false, e.name + ": " + e.takes};
      for (std::size_t first = 0; first + n <= e.force.size(); first += n) {
        std::vector<int> power;
        for (std::size_t i = 0; i < n; ++i)
          for (const int term : summands(graph_, e.force[first + i])) power.push_back(graph_.product(term, scene_.motion.qdot[i]));
        if (c.found && !sum_vanishes(graph_, power, scene_.variables)) c = {c.name, false, "the force of " + e.name + " does work"};
      }
      for (const int drift : e.drift)
        if (c.found && !is_zero(drift)) c = {c.name, false, "the constraint " + e.name + " is moved from outside, which does work"};
    }
    if (c.found && !scene_.effects.empty()) c.reason += ", and no effect does work";
    return c;
  }

  RecordedScene scene_;
  formula::Graph& graph_;
  int L_ = -1;
};

template <class = void>  // compiled only where it is called
ConservedQuantities quantities_of(RecordedScene scene) {
  return ConservedSearch(std::move(scene)).quantities();
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template ConservedQuantities quantities_of<void>(RecordedScene);
#endif

}  // namespace detail

/// Which momenta are conserved, whether h = q̇·p − L is, and whether it is the energy T + V; with the reasons.
///
/// In a scene terms of effects in T and V are in L, and a force or a constraint takes away what it acts on.
/// Runs T and V once on a scalar that records, and derives what is asked for as formulas: 0.1 ms for a few coordinates, 50 ms for a
/// hundred.
/// What is not seen is "not found" with what is in the way; nothing is thrown for it.
///
/// @param model  a system or scene
template <class Model>
ConservedQuantities conserved_quantities(const Model& model) {
  return detail::quantities_of(detail::recorded_scene(scene(model)));
}

}  // namespace qdot
