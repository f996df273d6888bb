#pragma once
// SPDX-License-Identifier: MIT
//
// Finding the zeros of functions along one step.
//
// A step is a polynomial y(τ), so g(τ) = g(y(τ), τ) is evaluated anywhere in it without the model. g may be much faster than the
// motion, so the step is searched in panels. A panel has eight samples, spaced irregularly against aliasing, and is good if
//
//     E ≤ 10⁻⁴ max |g|      E: what polynomials through the other samples miss at an inner one (of degree 4, 4 and 6), or
//     E ≤ ⅛ min |g|         where all samples have one sign: what the samples do not show cannot reach zero, or
//     E ≲ rounding of g.
//
// Otherwise it is halved; behind a good panel the next one is twice as long. Chandrupatla's method narrows a change of sign to
// neighbouring doubles, and parabolas follow an extremum near zero. Samples prove nothing: an excursion much narrower than a
// fifth of a panel is missed. Where g is a formula, intervals decide about panels instead (integrate/driver/event_proof.hpp).
// Where the search gives up, the run's message reports it. Where g jumps or has a pole there is no root (crossing()).

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

#include "qdot/integrate/driver/watched_function.hpp"

namespace qdot::detail {

// Where a panel is sampled, as fractions of it.
inline constexpr std::array<double, 8> sample_points{0.0, 0.0297, 0.1853, 0.4127, 0.6241, 0.8278, 0.9731, 1.0};
inline constexpr std::size_t samples_in_panel = sample_points.size();
inline constexpr double ladder_ratio = 4.0, close_to_joint = 1e-4;
inline constexpr long most_panels = 100'000;  // in one step
inline constexpr int most_rough_panels = 16;  // in a row
inline constexpr double many_roundings = 16;  // sum of the weights of the samples in E, and a margin

// Weights that give what the polynomial through the samples first … last, without the one at `left_out`, misses there.
constexpr std::array<double, samples_in_panel> miss_weights(std::size_t first, std::size_t last, std::size_t left_out) {
  std::array<double, samples_in_panel> weights{};
  weights[left_out] = 1.0;
  for (std::size_t j = first; j <= last; ++j) {
    if (j == left_out) continue;
    weights[j] = -1.0;
    for (std::size_t k = first; k <= last; ++k)
      if (k != j && k != left_out) weights[j] *= (sample_points[left_out] - sample_points[k]) / (sample_points[j] - sample_points[k]);
  }
  return weights;
}

// Whether samples of g, distances from zero, show all of it that matters for its zeros.
inline bool shows_all(const std::array<double, samples_in_panel>& g, double rounding) {
  constexpr std::array left = miss_weights(0, 5, 3), right = miss_weights(2, 7, 4), whole = miss_weights(0, 7, 3);
  double a = 0.0, b = 0.0, c = 0.0, lowest = g[0], highest = g[0];
  for (std::size_t k = 0; k < samples_in_panel; ++k) {
    a += left[k] * g[k];
    b += right[k] * g[k];
    c += whole[k] * g[k];
    lowest = std::min(lowest, g[k]);
    highest = std::max(highest, g[k]);
  }
  const double missed = std::max({std::abs(a), std::abs(b), std::abs(c)});
  return missed <= std::max(1e-4 * std::max(-lowest, highest), 0.125 * std::max(lowest, -highest)) || missed <= many_roundings * rounding;
}

// A function that lives elsewhere, so that one search is enough for all types of functions.
template <class Result, class... Arguments>
class FunctionElsewhere {
 public:
  template <class Function>
  explicit FunctionElsewhere(const Function& function)
      : function_(&function), call_([](const void* f, Arguments... arguments) -> Result { return (*static_cast<const Function*>(f))(arguments...); }) {}
  Result operator()(Arguments... arguments) const { return call_(function_, arguments...); }

 private:
  const void* function_;
  Result (*call_)(const void*, Arguments...);
};

// Searches [from, to] for the first root of one function; unit_of_t is a rounding unit. `at(t)` evaluates it, `decided(a, b)` proves that the
// ends of a panel tell all, and noise(t) is what the tolerance of the method leaves open of it.
class RootSearch {
 public:
  template <class Evaluate, class Decided, class Noise>
  RootSearch(Watch& watch, const Evaluate& at, const Decided& decided, const Noise& noise, double unit_of_t)
      : watch_(watch), at_(at), decided_(decided), noise_(noise), unit_(unit_of_t) {}

  // Notes the first root that counts in watch.root; known[k] are the values at the sample fractions.
  void run(double from, double to, const double* known) {
    watch_.root.reset();
    from_ = zero_ = left_ = t0_ = t1_ = from;
    to_ = to;
    g0_ = g1_ = watch_.value - watch_.level;
    if (watch_.is_kept && !watch_.off) {
      const double g_end = (known != nullptr ? known[samples_in_panel - 1] : at_(to)) - watch_.level;
      if (is_noise(from, g0_) && is_noise(to, g_end)) return void(watch_.value = g_end + watch_.level);
    }
    if (see_ladder()) return;
    length_ = known != nullptr ? std::abs(to - from) : std::min((watch_.is_formula ? 4 : 1) * watch_.panel, std::abs(to - from));
    known_ = t1_ == from ? known : nullptr;
    is_step_ = known_ != nullptr;
    indistinct_ = 64 * std::numeric_limits<double>::epsilon() * std::max({std::abs(from), std::abs(to), std::abs(to - from)});
    while (t1_ != to) {
      const double left = std::abs(to - t1_);
      const bool is_last = length_ >= left;
      const double b = is_last ? to : t1_ + std::copysign(length_, to - t1_);
      if (is_last) length_ = left;
      if (watch_.is_formula && !watch_.unproven && watch_.off ? decide_panel(b) : sample_panel(b)) return;
    }
    watch_.value = g1_ + watch_.level;
  }

  // True when a panel shows what there is, or nothing more can be done about it: it is short, for g jumps, or there are too many. Then the
  // samples that there are decide.
  bool is_good(const std::array<double, samples_in_panel>& g, bool is_short, bool is_step) {
    if (watch_.rough) return true;
    if (shows_all(g, 0.0)) {
      watch_.rough_panels = 0;
      return true;
    }
    if (shows_all(g, watch_.rounding)) {
      const auto [lowest, highest] = std::minmax_element(g.begin(), g.end());
      watch_.rough = is_step && std::max(-*lowest, *highest) <= many_roundings * watch_.rounding;  // nothing but rounding in all of the step
      return true;
    }
    watch_.rough = ++watch_.panels > most_panels || (is_short && ++watch_.rough_panels > most_rough_panels);
    return watch_.rough || is_short;
  }

  // True when the ends of a panel that t can hardly tell apart leave it open whether zero was touched between them.
  bool may_touch(double ga, double gb) const {
    const double nearest = std::min(std::abs(ga), std::abs(gb));
    return ga * gb >= 0.0 && (ga != 0.0 || gb != 0.0) && !(nearest > 8 * std::abs(gb - ga) && nearest > many_roundings * watch_.rounding);
  }

  // True when the parabola through three samples turns near a joint.
  static bool may_turn(const std::array<double, samples_in_panel>& g, std::size_t first, double joint) {
    const double x0 = sample_points[first], x1 = sample_points[first + 1], x2 = sample_points[first + 2];
    const double d01 = (g[first + 1] - g[first]) / (x1 - x0), d12 = (g[first + 2] - g[first + 1]) / (x2 - x1);
    const double curvature = (d12 - d01) / (x2 - x0), slope = d01 + curvature * (2 * joint - x0 - x1);
    return std::abs(slope) <= 0.2 * std::abs(curvature);
  }

  // A function at zero has moved from g_before to g: its first side.
  void leave_zero(double before, double g_before, double t, double g) {
    if (g_before == 0.0) zero_ = before, left_ = t;
    if (!(std::abs(g) > watch_.band) || is_noise(t, g)) return;
    const int side = g > 0 ? 1 : -1;
    watch_.lost = side == -watch_.home;
    if (watch_.lost || (watch_.barrier ? side < 0 : (!watch_.muted && watch_.counts(-side)))) {
      watch_.root = zero_ == from_ ? from_ : edge(left_, zero_);
      watch_.came_from = -side;
      watch_.stuck = watch_.muted;
    } else {
      watch_.side = side;
    }
  }

 private:
  // Takes in the next sample of the function; true when a root is found.
  bool see(double t2, double value) {
    const double g2 = value - watch_.level;
    if (watch_.side == 0) {
      leave_zero(t1_, g1_, t2, g2);
    } else if (g2 * watch_.side <= 0) {
      cross(t1_, g1_, t2, g2);
    } else if (watch_.off && t1_ != t0_ && g0_ * watch_.side > 0 && std::abs(g1_) <= std::abs(g0_) && std::abs(g1_) <= std::abs(g2)) {
      dip(t0_, g0_, t1_, g1_, t2, g2);
    }
    watch_.off = watch_.off || (std::abs(g2) > watch_.noise && !is_noise(t2, g2));
    t0_ = std::exchange(t1_, t2);
    g0_ = std::exchange(g1_, g2);
    return watch_.root.has_value();
  }

  // Samples the way out of zero at distances that grow by a ratio; true when a root is found.
  bool see_ladder() {
    const double way = to_ - from_, first = 4 * std::numeric_limits<double>::epsilon() * std::abs(from_);
    const auto is_at_zero = [this] { return watch_.side == 0 || (watch_.is_formula && !watch_.off); };
    for (double d = std::max(first, (watch_.passed ? 1e-9 : 1e-20) * std::abs(way)); is_at_zero() && d < std::abs(way); d *= ladder_ratio) {
      const double t = from_ + std::copysign(d, way);
      if (t != t1_ && see(t, at_(t))) return true;
    }
    return false;
  }

  // Passes the panel up to b by its ends where a proof allows it or the panel is too short to halve; true when a root is found.
  bool decide_panel(double b) {
    const double a = t1_;
    const bool proven = decided_(a, b);
    if (!proven && length_ > indistinct_) {
      length_ *= 0.5;
      watch_.unproven = watch_.unproven || ++watch_.panels > most_panels;
      return false;
    }
    const double gb = at_(b) - watch_.level;
    if (proven) watch_.panel = length_;
    else indistinct_ *= 2, watch_.rough = watch_.rough || (!(watch_.passed && a == from_) && may_touch(g1_, gb));
    if (see(b, gb + watch_.level)) return true;
    if (proven) t0_ = t1_;  // no dip to look for
    length_ *= 2;
    return false;
  }

  // Samples the panel up to b and looks through the samples if they show enough, else halves it; true when a root is found.
  bool sample_panel(double b) {
    const double a = t1_;
    const auto at = [&](std::size_t k) { return k + 1 == samples_in_panel ? b : a + sample_points[k] * (b - a); };
    std::array<double, samples_in_panel> g;
    g[0] = g1_;
    for (std::size_t k = 1; k < samples_in_panel; ++k) g[k] = (known_ != nullptr ? known_[k] : at_(at(k))) - watch_.level;
    known_ = nullptr;
    const double shortest = std::max(1e-9 * std::abs(to_ - from_), 1e3 * std::numeric_limits<double>::epsilon() * std::max(std::abs(a), std::abs(b)));
    if (!is_noise(b, largest(g)) && !is_good(g, length_ <= shortest, std::exchange(is_step_, false))) {
      length_ *= 0.5;
      return false;
    }
    watch_.panel = length_;
    const double near_a = a + close_to_joint * (b - a), near_b = b - close_to_joint * (b - a);
    if (may_turn(g, 0, 0.0) && see(near_a, at_(near_a))) return true;
    for (std::size_t k = 1; k < samples_in_panel; ++k) {
      if (k + 1 == samples_in_panel && may_turn(g, samples_in_panel - 3, 1.0) && see(near_b, at_(near_b))) return true;
      if (see(at(k), g[k] + watch_.level)) return true;
    }
    length_ = watch_.rough ? std::abs(to_ - from_) : 2 * length_;
    return false;
  }

  static double largest(const std::array<double, samples_in_panel>& g) {
    double size = 0.0;
    for (const double each : g) size = std::max(size, std::abs(each));
    return size;
  }

  // Whether g has no sign at t; noise is asked about again there.
  bool is_noise(double t, double g) {
    if (watch_.off || !watch_.judges) return false;
    watch_.noise = noise_(t);
    return std::abs(g) <= watch_.noise;
  }

  // The last double at which g is other than zero on the way from `off`, where it is, to `zero`.
  double edge(double off, double zero) const {
    for (double middle = 0.5 * (off + zero); middle != off && middle != zero; middle = 0.5 * (off + zero)) (at_(middle) == watch_.level ? zero : off) = middle;
    return off;
  }

  // g changes sign between two samples, or the second is zero itself.
  void cross(double a, double ga, double b, double gb) {
    if (is_noise(b, gb)) {
      if (gb != 0.0) watch_.side = -watch_.side;
      return;
    }
    std::optional<double> root;
    if (watch_.counts(watch_.side)) root = ga * watch_.side > 0.0 ? crossing(a, ga, b, gb) : a;
    if (root) {
      watch_.came_from = watch_.side;
      watch_.root = root;
    } else if (gb != 0.0) {
      watch_.side = -watch_.side;
    }
  }

  // far_side() unless g jumps there: over neighbouring doubles g changes by more than half as much as over ten thousand of them, a million
  // and more. A continuous g, steep as |τ|^(1/5) sgn τ, changes by a sixth of that; a rounded g by less where the way is longer. A jump
  // onto zero is a root.
  std::optional<double> crossing(double a, double ga, double b, double gb) const {
    const Bracket found = far_side(a, ga, b, gb);
    if (watch_.barrier || found.g_behind == 0.0) return found.behind;
    constexpr double least = 1e-6, most = 0.5;
    const double change = std::abs(found.g_behind - found.g_ahead);
    if (change <= least * std::max(std::abs(ga), std::abs(gb))) return found.behind;
    if (std::abs(found.behind - from_) <= 16 * unit_ && change <= 64 * watch_.rounding) return found.behind;
    const double first = std::min(from_, to_), last = std::max(from_, to_);
    for (const double many : {1e4, 1e6, 1e8, 1e10}) {
      const double way = many * (found.behind - found.ahead);
      const double around = std::abs(at_(std::clamp(found.behind + way, first, last)) - at_(std::clamp(found.ahead - way, first, last)));
      if (change <= most * around) return found.behind;
    }
    return std::nullopt;
  }

  // a, m, b of one sign, |g| smallest at m: looks for a point across zero.
  void dip(double a, double ga, double m, double gm, double b, double gb) {
    const double sign = watch_.side;
    const double start = a, g_start = ga, end = b, g_end = gb;
    ga *= sign, gm *= sign, gb *= sign;
    for (int k = 0; k < 30; ++k) {
      // Vertex of the parabola through the three points.
      const double u = (m - a) * (gm - gb), v = (m - b) * (gm - ga);
      double x = u == v ? m : m - 0.5 * ((m - a) * u - (m - b) * v) / (u - v);
      const bool inside = (x - a) * (x - b) < 0;
      const double least_move = 1e-3 * std::min(std::abs(m - a), std::abs(b - m));
      if (!inside || !(std::abs(x - m) > least_move)) {
        const double longer = std::abs(m - a) > std::abs(b - m) ? a : b;
        x = m + (inside ? 2e-3 : 0.382) * (longer - m);
      }
      if (x == m || x == a || x == b) return;
      const double g = sign * (at_(x) - watch_.level);
      if (g <= 0) {
        watch_.came_from = watch_.side;
        if (watch_.counts(watch_.side)) {
          watch_.root = crossing(start, g_start, x, sign * g);
        } else if (g < 0) {
          watch_.side = watch_.came_from = -watch_.side;
          watch_.root = crossing(x, sign * g, end, g_end);
        }
        return;
      }
      const bool settled = std::abs(g - gm) <= 1e-3 * std::min(g, gm) && k > 2;
      const bool left = (x - a) * (x - m) < 0;
      if (g <= gm) {
        (left ? b : a) = m, (left ? gb : ga) = gm;
        m = x, gm = g;
      } else {
        (left ? a : b) = x, (left ? ga : gb) = g;
      }
      if (settled) return;  // the extremum is known to a thousandth of its distance from zero
    }
  }

  struct Bracket {
    double ahead, g_ahead, behind, g_behind;
  };

  // A bracket of neighbouring doubles, whose end `behind` lies on b's side of the root, or is the first zero (Chandrupatla's method).
  Bracket far_side(double a, double ga, double b, double gb) const {
    constexpr double epsilon = std::numeric_limits<double>::epsilon();
    const double far_sign = ga > 0 ? -1.0 : 1.0;
    // x0, x1: the bracket, x0 the newer point; x2 the one before.
    double x0 = b, g0 = gb, x1 = a, g1 = ga, x2 = a, g2 = ga;
    double s = 0.5;
    if (gb != 0.0 && ga != 0.0) s = ga / (ga - gb), s = 1.0 - s;  // from x0 towards x1: a secant step first
    int zeros = gb == 0.0 ? 1 : 0;
    for (int k = 0; k < 200; ++k) {
      const double width = std::abs(x1 - x0);
      const double least = epsilon * std::max(std::abs(x0), std::abs(x1));
      if (width <= 2 * least && (zeros == 0 || width <= least)) break;
      const double floor = std::min(0.5, least / width);
      double x = x0 + std::clamp(s, floor, 1.0 - floor) * (x1 - x0);
      if (x == x0 || x == x1) x = 0.5 * (x0 + x1);
      if (x == x0 || x == x1) break;
      const double g = at_(x) - watch_.level;
      if (g == 0.0) ++zeros;
      const auto is_far = [far_sign](double value) { return value * far_sign >= 0.0; };
      if (is_far(g) == is_far(g0)) {
        x2 = x0, g2 = g0;
      } else {
        x2 = x1, g2 = g1;
        x1 = x0, g1 = g0;
      }
      x0 = x, g0 = g;
      const double xi = (x0 - x1) / (x2 - x1), phi = (g0 - g1) / (g2 - g1);
      s = 0.5;
      if (zeros == 1 && (g0 == 0.0 || g1 == 0.0)) s = g0 == 0.0 ? 0.0 : 1.0;  // most zeros stand alone
      else if (zeros == 0 && phi * phi < xi && (1 - phi) * (1 - phi) < 1 - xi)
        s = g0 / (g1 - g0) * g2 / (g1 - g2) + (x2 - x0) / (x1 - x0) * g0 / (g2 - g0) * g1 / (g2 - g1);
    }
    const bool newer_is_far = g0 * far_sign >= 0;
    return newer_is_far ? Bracket{x1, g1, x0, g0} : Bracket{x0, g0, x1, g1};
  }

  Watch& watch_;
  FunctionElsewhere<double, double> at_;
  FunctionElsewhere<bool, double, double> decided_;
  FunctionElsewhere<double, double> noise_;
  double from_ = 0.0, to_ = 0.0, unit_;  // what rounding of t may hide: behind a switch by time elapsed begins at zero, and t some units later
  double zero_ = 0.0, left_ = 0.0;  // the last sample that was exactly zero, and the one behind it
  double t0_ = 0.0, g0_ = 0.0, t1_ = 0.0, g1_ = 0.0;  // the last two samples
  double length_ = 0.0, indistinct_ = 0.0;  // of the next panel, and the length up to which an undecided one is not halved
  const double* known_ = nullptr;  // values at the sample fractions of the first panel, if they are known and not yet used
  bool is_step_ = false;           // the next panel is the whole step
};

// What a run asks of it, compiled once in a program, or in the library (qdot::compiled).
template <class Number = double>
void search_root(RootSearch& search, double from, double to, const Number* known) {
  search.run(from, to, known);
}

#ifdef QDOT_COMPILED
extern template void search_root<double>(RootSearch&, double, double, const double*);
#endif

}  // namespace qdot::detail
