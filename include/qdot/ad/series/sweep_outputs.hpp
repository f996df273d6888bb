#pragma once
// SPDX-License-Identifier: MIT
//
// What is asked of a sweep (ad/series/sweep.hpp): nodes of a graph, and how an order of their series follows from the one before.

#include <vector>

#include "qdot/ad/formula/graph.hpp"
#include "qdot/ad/formula/lines.hpp"

namespace qdot::taylor {

// The formulas that are swept.
using formula::Function, formula::Graph, formula::Kind, formula::Line, formula::Node, formula::value_of;

/// How an order of the variables follows from the one before: x_k = τ/k · (rate of x)_{k−1}, and late ones v from M₀ v_k = τ/k · F_{k−1} − p_k.
///
/// With rows c_k = 0, whose derivative with v is W, also their multipliers: M₀ v_k − W₀ᵀ μ = τ/k · (F + Σ_{j≥1} W_jᵀ λ_{k−1−j}) − p_k, W₀ v_k = −c_k,
/// μ = τ/k · λ_{k−1}; p_k and c_k are made with v_k = 0.
struct Recurrence {
  std::vector<int> variables = {}, rates = {};               ///< nodes
  std::vector<int> late = {}, forces = {}, momenta = {};     ///< nodes of v, F and p
  std::vector<int> mass = {};                                ///< of the lower triangle of M, row by row
  std::vector<int> rows = {}, jacobian = {};                 ///< of c, and of W row by row
  int time = -1;                                             ///< a variable whose rate is one
};

/// What a sweep computes.
struct SweepOutputs {
  std::vector<int> early;    ///< nodes needed before the late variables' coefficient is known
  std::vector<int> series;   ///< nodes needed after
  std::vector<int> values;   ///< nodes needed at order 0 only
  std::vector<int> late;     ///< variables whose coefficient is known late
  Recurrence recurrence = {};  ///< empty where the caller sets the variables
};

}  // namespace qdot::taylor
