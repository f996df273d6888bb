#pragma once
// SPDX-License-Identifier: MIT
//
// Motions in quadruple precision: Gragg's extrapolation of the modified midpoint rule, order 12, at a local tolerance of 1e-17, with
// an event that is found by regula falsi. Two neighbours run along, 1e-12 away at the start: how far apart they come is the gain that errors have.
//
// Reference: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, II.9.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <vector>

#include "oracle.hpp"

namespace fuzz {

using Rate = std::function<Quads(quad t, const Quads& y)>;

/// ẏ of y = [q; q̇; z].
inline Rate rate_of(const Model& model) {
  return [&model](quad t, const Quads& y) {
    const auto n = static_cast<std::ptrdiff_t>(model.n);
    const Instant at{Quads(y.begin(), y.begin() + n), Quads(y.begin() + n, y.begin() + 2 * n), t, Quads(y.begin() + 2 * n, y.end())};
    Quads rate = at.qdot;
    const Quads a = accelerations_of(model, at);
    rate.insert(rate.end(), a.begin(), a.end());
    if (model.state_rate) {
      const Quads z = model.state_rate(at.q, at.qdot, at.z, t);
      rate.insert(rate.end(), z.begin(), z.end());
    }
    return rate;
  };
}

/// A step of extrapolation and its error.
inline Quads extrapolated(const Rate& f, quad t, const Quads& y, const Quads& f0, quad h, double& error) {
  constexpr std::size_t columns = 6;
  std::vector<Quads> row, before;
  for (std::size_t k = 0; k < columns; ++k) {
    const auto steps = static_cast<int>(2 * (k + 1));
    const quad each = h / steps;
    Quads low = y, high = y;
    for (std::size_t i = 0; i < y.size(); ++i) high[i] += each * f0[i];
    for (int j = 1; j < steps; ++j) {
      const Quads slope = f(t + j * each, high);
      for (std::size_t i = 0; i < y.size(); ++i) low[i] += 2 * each * slope[i];
      std::swap(low, high);
    }
    before = row;
    row.assign(1, high);
    for (std::size_t j = 1; j <= k; ++j) {
      const quad ratio = quad(k + 1) / quad(k + 1 - j);
      Quads next = row[j - 1];
      for (std::size_t i = 0; i < y.size(); ++i) next[i] += (row[j - 1][i] - before[j - 1][i]) / (ratio * ratio - 1);
      row.push_back(next);
    }
  }
  error = 0.0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const double size = static_cast<double>(magnitude(y[i])) + 1e-3, off = static_cast<double>(magnitude(row[columns - 1][i] - row[columns - 2][i]));
    error = std::isfinite(off) ? std::max(error, off / size) : std::numeric_limits<double>::infinity();
  }
  return row.back();
}

/// Something that happens once, where g crosses zero.
struct Happening {
  std::function<quad(quad t, const Quads& y)> g = {};
  std::function<void(Quads& y)> action = {};  // may change what the model reads
  quad at = std::numeric_limits<double>::infinity();  // the time, where that is known: g is not asked then
};

struct Reference {
  bool arrived = false;
  Quads y, largest;  // at the end; of each component, on the way
  quad happened = std::numeric_limits<double>::infinity();
  double gain = 1.0;
};

/// One motion from t₀ to t₁. `breaks`: times between which it is smooth on the scale of their distances.
inline Reference one_reference(const Rate& f, quad t, Quads y, quad t_end, const Happening* happening, std::vector<quad> breaks) {
  constexpr double tolerance = 1e-17;
  constexpr int most_steps = 3000;
  Reference r{false, y, y};
  for (quad& x : r.largest) x = magnitude(x);
  bool waiting = happening != nullptr;
  if (waiting && happening->at < t_end) breaks.push_back(happening->at);
  breaks.push_back(t_end);
  std::sort(breaks.begin(), breaks.end());
  quad h = std::min(quad(0.05), (t_end - t) / 8);
  int steps = 0;
  for (const quad stop : breaks) {
    if (!(stop > t) || stop > t_end) continue;
    h = std::min(h, (stop - t) / 2);
    while (t < stop) {
      if (++steps > most_steps) return r;
      const bool last = t + h >= stop;
      const quad step = last ? stop - t : h;
      const Quads f0 = f(t, y);
      double error;
      Quads next = extrapolated(f, t, y, f0, step, error);
      if (!(error <= tolerance)) {
        h = step * (std::isfinite(error) ? std::max(0.1, 0.8 * std::pow(tolerance / error, 1.0 / 11)) : 0.1);
        if (!(h > quad(1e-9))) return r;
        continue;
      }
      bool acted = false;
      quad taken = step;
      if (waiting && happening->g && !(happening->at <= t_end)) {
        const quad g0 = happening->g(t, y);
        quad low = 0, high = step, g_low = g0, g_high = happening->g(t + step, next);
        if (g0 != 0 && (g0 < 0) != (g_high < 0)) {
          for (int k = 0; k < 60 && high - low > quad(1e-20); ++k) {
            quad middle = low - g_low * (high - low) / (g_high - g_low);
            if (k % 3 == 2) middle = (low + high) / 2;
            const Quads there = extrapolated(f, t, y, f0, middle, error);
            const quad g = happening->g(t + middle, there);
            if ((g < 0) == (g0 < 0)) low = middle, g_low = g;
            else high = middle, g_high = g, next = there;
            if (magnitude(g) < quad(1e-22)) {
              next = there, high = middle;
              break;
            }
          }
          taken = high;
          acted = true;
        }
      }
      y = next;
      t = last && taken == step ? stop : t + taken;
      if (waiting && happening->at == t) acted = true;
      for (std::size_t i = 0; i < y.size(); ++i) r.largest[i] = std::max(r.largest[i], magnitude(y[i]));
      if (acted) {
        waiting = false;
        r.happened = t;
        happening->action(y);
      }
      const quad longest = happening != nullptr && happening->g ? quad(0.05) : quad(1);
      if (!last) h = std::min(longest, h * std::min(3.0, 0.8 * std::pow(tolerance / std::max(error, 1e-40), 1.0 / 11)));
      else h = std::min(longest, h * 4);
      for (const quad x : y)
        if (!(magnitude(x) < quad(1e4))) return r;
    }
  }
  r.arrived = true;
  r.y = y;
  return r;
}

/// The same with its gain. `prepare` puts what the model reads into the state of the start.
inline Reference reference_motion(const Model& model, quad t, const Quads& y, quad t_end, const Happening* happening, const std::vector<quad>& breaks,
                                  const std::function<void()>& prepare, Dice dice) {
  constexpr double apart = 1e-12;
  const Rate f = rate_of(model);
  prepare();
  Reference r = one_reference(f, t, y, t_end, happening, breaks);
  if (!r.arrived) return r;
  for (int neighbour = 0; neighbour < 2; ++neighbour) {
    Quads near = y;
    for (quad& x : near) x += quad(apart * dice.between(-1.0, 1.0));
    prepare();
    const Reference other = one_reference(f, t, near, t_end, happening, breaks);
    if (!other.arrived || (other.happened > t_end) != (r.happened > t_end)) return {};
    for (std::size_t i = 0; i < y.size(); ++i) r.gain = std::max(r.gain, static_cast<double>(magnitude(other.y[i] - r.y[i])) / apart);
  }
  prepare();
  return r;
}

}  // namespace fuzz
