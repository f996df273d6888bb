#pragma once
// SPDX-License-Identifier: MIT
//
// The end of a run in words: states with which none goes on, and the sentence that a run ends with.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "qdot/ad/vector.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/watch/driven_form.hpp"

namespace qdot::detail {

// What is wrong with a state: a component is not finite, or above the limit of all.
template <class Number = double>
[[gnu::cold]] Failure trouble_of_state(const DrivenForm& system, const Eigen::Ref<const Eigen::VectorXd>& y, double t, double limit) {
  for (Eigen::Index i = 0; i < y.size(); ++i)
    if (!std::isfinite(y[i])) return {Outcome::non_finite, sentence({system.component_name(i), " became ", y[i], " in the step to t = ", t})};
  const Eigen::Index worst = place_of_largest(y.data(), y.size());
  return {Outcome::state_limit, sentence({system.component_name(worst), " = ", y[worst], " exceeds state_norm_limit = ", limit})};
}

// What is wrong with a state after a step; nothing where it is sound.
inline std::optional<Failure> unsound_state(const DrivenForm& system, const Eigen::Ref<const Eigen::VectorXd>& y, double t, double limit) {
  // Asked after every step: each comparison by itself, for finding the largest they would wait for each other.
  const double most = std::min(limit, std::numeric_limits<double>::max());
  Eigen::Index sound = 0;
  while (sound < y.size() && std::abs(y[sound]) <= most) ++sound;
  if (sound == y.size()) return std::nullopt;
  return trouble_of_state(system, y, t, limit);
}

// Outcome, place, what is known about it, and advice where that is not advice already; a remark behind what was completed.
template <class Number = double>
[[gnu::cold]] std::string how_it_ended(Outcome outcome, const std::string& message, double t, long steps, const char* remark) {
  const std::string where = sentence({"t = ", t, " after ", steps, " steps"});
  if (outcome == Outcome::completed) return sentence({"reached ", where, remark});
  const bool advised = message.find(advice(outcome)) != std::string::npos;
  return sentence({name(outcome), " at ", where, ": ", message, advised ? "" : "; ", advised ? "" : advice(outcome)});
}

#ifdef QDOT_COMPILED
extern template Failure trouble_of_state<double>(const DrivenForm&, const Eigen::Ref<const Eigen::VectorXd>&, double, double);
extern template std::string how_it_ended<double>(Outcome, const std::string&, double, long, const char*);
#endif

}  // namespace qdot::detail
