#pragma once
// SPDX-License-Identifier: MIT
//
// How far apart two runs of the same motion are.
//
// The error of component i is measured against the largest value that this component takes in the whole run,
//
//     |δyᵢ(t)| / Yᵢ ,       Yᵢ = max |yᵢ| over the run,
//
// and the error of the run is the largest over all components and output times. It has no unit, stays finite where yᵢ passes
// through zero, and a large component does not hide the error of a small one.
//
// In symmetric motion a component that is zero on paper is 1e-17 in the computer, and has no digits to compare. With δẏᵢ the
// change of ẏᵢ when each yⱼ changes by a relative 2⁻²⁶, a component below 10⁴ ε · 2²⁶ |δẏᵢ| · duration is taken for zero.
//
// At an impact the velocity jumps, at times that differ a little between the runs. Output times between them are left out;
// the difference of the two times, divided by the duration of the run, counts as an error instead.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/integrate/event.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot::detail {

// What is compared of a run.
struct Motion {
  double t_begin = 0.0;
  std::vector<double> t;  // output times as far as the run came, then its end
  Eigen::MatrixXd y;      // a column for each
  Eigen::VectorXd sizes;  // max |yᵢ| over the start and all steps
  std::vector<RecordedEvent> events;

  double duration() const { return t.empty() ? 0.0 : std::abs(t.back() - t_begin); }
};

// The largest difference of two motions, and where it is.
struct MotionDifference {
  double relative = 0.0;
  Eigen::Index component = -1;  // −1: none is different, or it is the time of an event
  double t = 0.0;
  double event_time = 0.0;  // largest difference of an event's time
};

// The sizes of the components, and which of them are zero but for rounding.
struct ComponentSizes {
  Eigen::VectorXd sizes;    // Yᵢ, or what rounding can make of the component where that is more
  std::vector<bool> zero;

  // Absolute tolerances that go with a relative one, for components that are worth no less than `scale`; what is zero but for
  // rounding is not asked for digits.
  Eigen::VectorXd tolerances(double relative, const Eigen::VectorXd& scale) const {
    constexpr double of_zero = 1e-2;
    Eigen::VectorXd each = relative * scale;
    for (std::size_t i = 0; i < zero.size(); ++i)
      if (zero[i]) each[static_cast<Eigen::Index>(i)] = of_zero * sizes[static_cast<Eigen::Index>(i)];
    return each.cwiseMax(std::numeric_limits<double>::min());
  }
};

// Gives what is smaller beside its like than `least` a size: positions beside positions, velocities beside velocities, else all.
inline void lend_sizes(Eigen::VectorXd& sizes, Eigen::Index dof, double least) {
  const double all = sizes.size() > 0 ? sizes.maxCoeff() : 0.0;
  const auto lend = [&](Eigen::Index begin, Eigen::Index count) {
    if (count == 0) return;
    const double alike = sizes.segment(begin, count).maxCoeff(), known = alike > 0 ? alike : all > 0 ? all : 1.0;
    for (Eigen::Index i = begin; i < begin + count; ++i)
      sizes[i] = sizes[i] > 0 ? std::max(sizes[i], least * known) : known;
  };
  lend(0, dof);
  lend(dof, dof);
  lend(2 * dof, sizes.size() - 2 * dof);
}

// What rounding can make of each component, seen from states (columns of y at times t); dof 0 for a system without coordinates.
template <class F>
Eigen::VectorXd rounding_sizes(const F& system, Eigen::Index dof, const std::vector<double>& t, const Eigen::MatrixXd& states,
                               double duration) {
  constexpr double change = 1.0 / (1 << 26);
  constexpr double margin = 1e4 * std::numeric_limits<double>::epsilon();
  constexpr int most_states = 4, patterns = 4;
  const Eigen::Index size = states.rows();
  Eigen::VectorXd rate = Eigen::VectorXd::Zero(size), f(size), f_changed(size), y(size), y_changed(size);
  for (int s = 0; s < most_states; ++s) {
    const Eigen::Index column = (states.cols() - 1) * s / (most_states - 1);
    const double time = t[static_cast<std::size_t>(column)];
    y = states.col(column);
    try {
      system.derivative(time, y, f);
      for (int pattern = 0; pattern < patterns; ++pattern) {
        unsigned signs = 2654435761u * static_cast<unsigned>(1 + pattern + patterns * s);
        for (Eigen::Index j = 0; j < size; ++j) {
          const bool moves = dof == 0 || j < 2 * dof;  // behind the velocities there may be phases, which are whole numbers
          y_changed[j] = moves ? y[j] * (1 + ((signs >> 16) % 2 == 0 ? change : -change)) : y[j];
          signs = signs * 1664525u + 1013904223u;
        }
        system.derivative(time, y_changed, f_changed);
        const Eigen::VectorXd difference = (f_changed - f).cwiseAbs() / change;
        if (difference.allFinite()) rate = rate.cwiseMax(difference);
      }
    } catch (const Error&) {  // a state that the model refuses says nothing
    }
  }
  Eigen::VectorXd result = margin * duration * rate;
  for (Eigen::Index i = 0; i < dof; ++i) result[i] = std::max(result[i], duration * result[dof + i]);
  return result;
}

// The sizes that were seen, corrected where one is so small beside the others that it may be rounding.
template <class F>
ComponentSizes component_sizes(const F& system, Eigen::Index dof, const Eigen::VectorXd& seen, const std::vector<double>& t,
                               const Eigen::MatrixXd& states, double duration) {
  constexpr double suspicious = 1e-9;
  ComponentSizes result{seen, std::vector<bool>(static_cast<std::size_t>(seen.size()), false)};
  const auto alike = [&](Eigen::Index begin, Eigen::Index count) {  // a velocity beside velocities: units of time say nothing
    const auto part = seen.segment(begin, count);  // where all are zero, they have no size
    return count == 0 || (part.minCoeff() > 0.0 && part.minCoeff() >= suspicious * part.maxCoeff());
  };
  if (alike(0, dof) && alike(dof, dof) && alike(2 * dof, seen.size() - 2 * dof)) return result;
  const Eigen::VectorXd rounding = rounding_sizes(system, dof, t, states, duration);
  for (Eigen::Index i = 0; i < seen.size(); ++i) {
    result.zero[static_cast<std::size_t>(i)] = seen[i] <= rounding[i] && rounding[i] > 0;
    result.sizes[i] = std::max(seen[i], rounding[i]);
  }
  lend_sizes(result.sizes, dof, 0.0);  // what is exactly zero all the time, and what came near it owes nothing to rounding
  return result;
}

// Compares as far as both came.
inline MotionDifference difference(const Motion& a, const Motion& b, const ComponentSizes& components) {
  const Eigen::VectorXd& sizes = components.sizes;
  MotionDifference result;
  const double duration = std::max(a.duration(), b.duration());
  const auto see = [&](double relative, Eigen::Index component, double t) {
    if (relative <= result.relative) return;
    result.relative = std::isfinite(relative) ? relative : std::numeric_limits<double>::infinity();
    result.component = component;
    result.t = t;
  };
  std::vector<std::pair<double, double>> apart;  // between the two times of an event
  for (std::size_t k = 0; k < std::min(a.events.size(), b.events.size()); ++k) {
    if (a.events[k].name != b.events[k].name) break;
    const auto [early, late] = std::minmax(a.events[k].t, b.events[k].t);
    apart.emplace_back(early, late);
    result.event_time = std::max(result.event_time, late - early);
    if (duration > 0) see((late - early) / duration, -1, late);
  }
  const auto compare = [&](Eigen::Index ka, Eigen::Index kb, double t) {
    for (Eigen::Index i = 0; i < sizes.size(); ++i) {
      const double d = std::abs(a.y(i, ka) - b.y(i, kb));
      if (d == 0.0 || (components.zero[static_cast<std::size_t>(i)] && d < sizes[i])) continue;
      see(std::isnan(d) ? std::numeric_limits<double>::infinity() : d / sizes[i], i, t);
    }
  };
  const std::size_t common = std::min(a.t.size(), b.t.size());
  for (std::size_t k = 0; k < common && a.t[k] == b.t[k]; ++k) {
    const bool between = std::any_of(apart.begin(), apart.end(),
                                     [&](const auto& p) { return p.first <= a.t[k] && a.t[k] <= p.second; });
    if (!between) compare(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(k), a.t[k]);
  }
  if (common > 0 && a.t.back() != b.t.back()) compare(a.y.cols() - 1, b.y.cols() - 1, b.t.back());
  return result;
}

}  // namespace qdot::detail
