#pragma once
// SPDX-License-Identifier: MIT
//
// Explicit Runge–Kutta steps of several motions at once, one in each lane of a pack.
//
// The motions share their equations and the table of coefficients and nothing else. A step of the pack is an attempt in all of its
// lanes. A lane whose error is too large keeps its state and tries again with a shorter step, while the others go on:
//
//     lane 0   ├────┼──────┼─────────┼────┤  done: the lane takes the next motion
//     lane 1   ├──┼─╳┼─┼──┼───┼────┼──────     ╳ an attempt that failed
//
// Steps are those of integrate/runge_kutta.hpp. Only exp and ln of the controller, and sine and cosine of the equations, are those
// of ad/pack_math.hpp, which may differ in the last bit. No lane depends on its neighbours, so a motion has the same bits in every
// lane of every pack.
//
// A lane in which M is singular or something is not finite *leaves*, in the state from before the step. So does one in which the
// caller sees something that needs more, such as an event. Where time enters, the caller limits each step by head_for().

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "qdot/error.hpp"
#include "qdot/integrate/lanes/lane_events.hpp"
#include "qdot/integrate/lanes/lane_sums.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/steps/first_step.hpp"
#include "qdot/integrate/steps/runge_kutta_coefficients.hpp"
#include "qdot/integrate/steps/runge_kutta_sums.hpp"

namespace qdot::detail {

// Dop853 or Dopri5 for n coordinates in the lanes of packs P; `timed` where the equations depend on t.
template <class C, int n, class P, bool timed>
class RungeKuttaLanes {
  static constexpr int lanes = P::size;
  using Mask = typename P::Mask;
  static constexpr int N = 2 * n;

 public:
  explicit RungeKuttaLanes(const Options& options)
      : rtol_(options.rtol), max_step_(options.max_step), initial_step_(options.initial_step), share_(options.rtol < 1e-14 ? 64.0 : 1.0) {
    for (int i = 0; i < N; ++i) {
      atol_[i] = positive_atol(options.atol[i]);
      y_[i] = y_new_[i] = lost_[i] = lost_new_[i] = 0.0;
      f_[i] = 0.0;
      for (auto& row : k_) row[i] = 0.0;
    }
    origin_ = length_ = limit_ = elapsed_ = h_ = t_limit_ = t_last_ = 0.0;
    error_before_ = 1e-4;
    active_ = rejected_ = false;
  }

  // Takes the absolute tolerances of a lane's next motion.
  void tolerate(int lane, const Eigen::VectorXd& atol) {
    for (int i = 0; i < N; ++i) set_lane(atol_[i], lane, atol[i]);
  }

  // Gives a lane a motion: y and its rate f at t0, the way to go with its sign, and how far the first step may go.
  template <class Form>
  void load(int lane, const Form& form, double t0, double way, double limit, const Eigen::VectorXd& y, const Eigen::VectorXd& f) {
    const double room = limit - t0;
    set_lane(origin_, lane, t0);
    set_lane(length_, lane, way);
    set_lane(elapsed_, lane, 0.0);
    head_for(lane, limit);
    set_lane(h_, lane, std::copysign(first_step(lane, form, t0, room, y, f), way));
    set_lane(error_before_, lane, 1e-4);
    for (int i = 0; i < N; ++i) {
      set_lane(y_[i], lane, y[i]);
      set_lane(lost_[i], lane, 0.0);
      set_lane(k_[0][i], lane, f[i]);
    }
    set_lane(active_, lane, true);
    set_lane(rejected_, lane, false);
    steps_[lane] = 0;
    evaluations_[lane] = initial_step_ > 0.0 ? 1 : 2;
  }

  // Lets the next step of a lane go no further than to this time.
  void head_for(int lane, double t_limit) {
    const double origin = origin_[lane];
    set_lane(limit_, lane, t_limit - origin);
    set_lane(t_limit_, lane, t_limit);
    set_lane(t_last_, lane, std::nextafter(t_limit, origin));
  }

  void unload(int lane) {
    set_lane(length_, lane, 0.0);
    set_lane(limit_, lane, 0.0);
    set_lane(elapsed_, lane, 0.0);
    set_lane(h_, lane, 0.0);
    set_lane(active_, lane, false);
  }

  bool is_active(int lane) const { return active_[lane]; }
  const Mask& active() const { return active_; }
  long steps(int lane) const { return steps_[lane]; }
  long evaluations(int lane) const { return evaluations_[lane]; }
  double t(int lane) const { return timed && elapsed_[lane] == limit_[lane] ? t_limit_[lane] : origin_[lane] + elapsed_[lane]; }
  double y(int i, int lane) const { return y_[i][lane]; }

  // The step that was just made and is not taken yet, for callers that look at it: at both ends q, q̇ and q̈ are known. Through these there is one
  // polynomial of order 5, within h⁶ of the motion.
  static constexpr int parts = 4;
  StepPlaces<n, P, parts> places() const {
    StepPlaces<n, P, parts> found;
    const P h = taken_;
    for (int k = 0; k <= parts; ++k) found.t[k] = origin_ + elapsed_ + (static_cast<double>(k) / parts) * h;
    for (int i = 0; i < n; ++i) {  // q₀ + v₀ s + a₀ s² + c₃ s³ + c₄ s⁴ + c₅ s⁵
      const P q0 = y_[i], q1 = y_new_[i], v0 = h * y_[n + i], v1 = h * y_new_[n + i];
      const P a0 = 0.5 * h * h * k_[0][n + i], a1 = 0.5 * h * h * f_[n + i];
      const P d = q1 - q0 - v0 - a0, e = v1 - v0 - 2.0 * a0, f = a1 - a0;
      const P c3 = 10.0 * d - 4.0 * e + f, c4 = -15.0 * d + 7.0 * e - 2.0 * f, c5 = 6.0 * d - 3.0 * e + f;
      found.q[0][i] = q0;
      found.qdot[0][i] = y_[n + i];
      for (int k = 1; k < parts; ++k) {
        const double s = static_cast<double>(k) / parts;
        found.q[k][i] = q0 + s * (v0 + s * (a0 + s * (c3 + s * (c4 + s * c5))));
        found.qdot[k][i] = (v0 + s * (2.0 * a0 + s * (3.0 * c3 + s * (4.0 * c4 + s * (5.0 * c5))))) / h;
      }
      found.q[parts][i] = q1;
      found.qdot[parts][i] = y_new_[n + i];
    }
    return found;
  }

  // One attempt in every lane. accelerations(q, q̇, t, q̈) → mask of good lanes; seen() → mask of lanes that the caller wants to leave.
  // Returns which lanes have something to tell: they arrived, or leave.
  template <class Accelerations, class Seen>
  Mask step(const Accelerations& accelerations, const Seen& seen) {
    const P distance = limit_ - elapsed_;
    const Mask lands = abs(h_) * (1 + 1e-3) >= abs(distance);
    P end = elapsed_ + h_;
    const P on_the_clock = (origin_ + end) - origin_;
    end = select(abs(on_the_clock - end) <= 1e-3 * abs(h_), on_the_clock, end);
    end = select(lands, limit_, end);
    taken_ = end - elapsed_;
    const Mask good = attempted(accelerations);
    const P error = weighted_error();
    const Mask accepted = good & active_ & (error <= 1.0);
    leaves_ = active_ & !good;
    seen_ = false;
    Mask takes = accepted;
    if (accepted.any()) {
      const Mask good_end = evaluated(accelerations, end, y_new_, f_);
      leaves_ |= accepted & !good_end;
      takes &= good_end;
      seen_ = takes & seen();
      leaves_ |= seen_;
      takes &= !seen_;
    }
    plan(select(lands, abs(distance), abs(h_)), error, takes, good);
    const Mask short_of = active_ & !takes & (abs(h_) <= least_step());
    leaves_ |= short_of;
    count(takes);
    elapsed_ = select(takes, end, elapsed_);
    for (int i = 0; i < N; ++i) {
      y_[i] = select(takes, y_new_[i], y_[i]);
      lost_[i] = select(takes, lost_new_[i], lost_[i]);
      k_[0][i] = select(takes, f_[i], k_[0][i]);
    }
    arrived_ = takes & (elapsed_ == length_);
    took_ = takes;
    return arrived_ | leaves_;
  }

  // Gives up the attempt in which something was thrown: every lane that moves leaves.
  Mask abandoned() {
    arrived_ = seen_ = took_ = false;
    return leaves_ = active_;
  }

  bool has_arrived(int lane) const { return arrived_[lane]; }
  bool took(int lane) const { return took_[lane]; }
  bool was_seen(int lane) const { return seen_[lane]; }
  double last_step(int lane) const { return taken_[lane]; }

 private:
  // Where the compiler may use four or eight doubles to an instruction it writes the sums itself, with weights that it knows.
  static constexpr bool are_compiled = register_lanes >= 4;
  static constexpr double beta = 0.2 / C::order;
  static constexpr double exponent = 1.0 / C::order - 0.75 * beta;

  // The first `count` stages after k₁, with their weights.
  template <class Weights>
  LaneTerms terms_of(const Weights& weights, int count) const {
    LaneTerms terms;
    for (int j = 1; j <= count; ++j) terms.add(weights[static_cast<std::size_t>(j)], doubles(k_[j]));
    return terms;
  }
  static const double* doubles(const P* numbers) { return reinterpret_cast<const double*>(numbers); }
  // Σ wⱼ (kⱼ − k₁) of component i over the first `count` stages after k₁.
  template <class Row, int count>
  [[gnu::always_inline]] P sum_of(int i) const {
    P sum = 0.0;
    unroll<count>([&](auto j) __attribute__((always_inline)) {
      if constexpr (Row::weights[j + 1] != 0.0) sum += Row::weights[j + 1] * k_[j + 1][i];
    });
    return sum;
  }
  // Of each component over all stages.
  template <class Row>
  void put_sums(P* to) const {
    if constexpr (are_compiled) {
      for (int i = 0; i < N; ++i) to[i] = sum_of<Row, C::stages - 1>(i);
    } else {
      sums_(reinterpret_cast<double*>(to), static_cast<std::size_t>(N), terms_of(Row::weights, C::stages - 1), nullptr);
    }
  }

  template <class Form>
  double first_step(int lane, const Form& form, double t0, double room, const Eigen::VectorXd& y, const Eigen::VectorXd& f) const {
    if (initial_step_ > 0.0) return std::min(initial_step_, std::abs(room));
    Eigen::VectorXd later(N);
    const auto weight = [&](Eigen::Index i) { return atol_[i][lane] + rtol_ * std::abs(y[i]); };
    return detail::first_step(C::order, N, y.data(), f.data(), weight, std::min(max_step_, std::abs(room)), [&](double h) -> const double* {
      h = std::copysign(h, room);
      try {
        form.derivative(t0 + h, y + h * f, later);
        return later.data();
      } catch (const Error&) {
        return nullptr;
      }
    });
  }

  // t for functors, on this side of the limit (integrate/time_point.hpp).
  P shown(const P& elapsed) const {
    if constexpr (!timed) return origin_ + elapsed;
    const P t = origin_ + select(length_ > 0.0, min(elapsed, limit_), max(elapsed, limit_));
    return select(t == t_limit_, t_last_, t);
  }

  template <class A>
  Mask evaluated(const A& accelerations, const P& elapsed, const P* y, P* f) {
    if constexpr (are_compiled) {
      for (int i = 0; i < n; ++i) f[i] = y[n + i];
    } else {
      LaneTerms velocities;
      velocities.add(1.0, doubles(y + n));
      sums_(reinterpret_cast<double*>(f), static_cast<std::size_t>(n), velocities, nullptr);
    }
    return accelerations(y, y + n, shown(elapsed), f + n);
  }

  // The state at which stage `row` is evaluated, into stage_.
  template <int row>
  [[gnu::always_inline]] void put_state() {
    constexpr double c = C::c[static_cast<std::size_t>(row)];
    for (int i = 0; i < N; ++i) stage_[i] = y_[i] + (taken_ * (c * k_[0][i] + sum_of<StageRow<C, row>, row - 1>(i)) + lost_[i]);
  }
  void put_state(int row) {
    LaneTerms terms = terms_of(C::a[static_cast<std::size_t>(row)], row - 1);
    terms.add(C::c[static_cast<std::size_t>(row)], doubles(k_[0]));
    const LaneStage from{doubles(y_), doubles(&taken_), doubles(lost_)};
    sums_(reinterpret_cast<double*>(stage_), static_cast<std::size_t>(N), terms, &from);
  }

  template <class A>
  Mask stage(const A& accelerations, int row) {
    const Mask good = evaluated(accelerations, elapsed_ + C::c[static_cast<std::size_t>(row)] * taken_, stage_, f_);
    if constexpr (are_compiled) {
      for (int i = 0; i < N; ++i) k_[row][i] = f_[i] - k_[0][i];
    } else {
      LaneTerms difference;
      difference.add(1.0, doubles(f_));
      difference.add(-1.0, doubles(k_[0]));
      sums_(reinterpret_cast<double*>(k_[row]), static_cast<std::size_t>(N), difference, nullptr);
    }
    return good;
  }

  // The stages and the new state; false in lanes where an evaluation was none.
  template <class A>
  Mask attempted(const A& accelerations) {
    Mask good = true;
    if constexpr (are_compiled) {
      [&]<std::size_t... i>(std::index_sequence<i...>) {
        ((put_state<static_cast<int>(i) + 1>(), good &= stage(accelerations, static_cast<int>(i) + 1)), ...);
      }(std::make_index_sequence<static_cast<std::size_t>(C::stages - 1)>{});
    } else {
      for (int row = 1; row < C::stages; ++row) {
        put_state(row);
        good &= stage(accelerations, row);
      }
    }
    put_sums<StageRow<C, C::stages>>(stage_);
    for (int i = 0; i < N; ++i) {
      const P bend = stage_[i] + C::half_defect * k_[C::stages - 1][i];
      y_new_[i] = y_[i];
      lost_new_[i] = lost_[i];
      add_compensated(y_new_[i], lost_new_[i], taken_ * (k_[0][i] + bend));
    }
    return good;
  }

  P weighted_error() {
    P sum = 0.0, low = 0.0, errors[N], low_errors[N];
    put_sums<ErrorRow<C>>(errors);
    put_sums<LowErrorRow<C>>(low_errors);
    for (int i = 0; i < N; ++i) {
      const P scale = 1.0 / (atol_[i] + rtol_ * max(abs(y_[i]), abs(y_new_[i])));
      const P e = errors[i] * scale;
      const P e_low = low_errors[i] * scale;
      sum += e * e;
      low += e_low * e_low;
    }
    const P both = sum + 0.01 * low;
    return select(both == P(0.0), P(0.0), share_ * abs(taken_) * sum / sqrt(static_cast<double>(N) * both));
  }

  // The next h of each lane, after an attempt of length `size`.
  void plan(const P& size, const P& error, const Mask& takes, const Mask& good) {
    const P known = max(error, P(1e-10));
    const P power = fast_exp(-exponent * fast_log(known));  // NaN where the error is none
    const P before = fast_exp(beta * fast_log(error_before_));
    P factor = 0.9 * power * before;
    factor = max(P(1.0 / 3.0), min(factor, select(rejected_, P(1.0), P(6.0))));
    const P planned = abs(h_);
    P next = select(size < planned, max(planned, size * factor), size * factor);
    next = min(next, P(max_step_));
    const P shorter = select(good & (error == error), size * max(P(0.2), 0.9 * power), 0.25 * size);
    const P sign = select(h_ < P(0.0), P(-1.0), P(1.0));
    h_ = select(active_, sign * select(takes, next, shorter), P(0.0));
    error_before_ = select(takes, max(error, P(1e-4)), error_before_);
    rejected_ = active_ & !takes;
  }

  P least_step() const {
    return 16 * std::numeric_limits<double>::epsilon() * max(abs(elapsed_), min(abs(origin_ + elapsed_), abs(limit_ - elapsed_)));
  }

  void count(const Mask& takes) {
    for (int lane = 0; lane < lanes; ++lane) {
      if (!active_[lane]) continue;
      evaluations_[lane] += C::stages - 1;
      if (takes[lane]) ++steps_[lane], ++evaluations_[lane];
    }
  }

  decltype(fastest_lane_sums()) sums_ = fastest_lane_sums();
  double rtol_, max_step_, initial_step_, share_;
  P atol_[N];
  P origin_, length_, elapsed_, h_, error_before_, taken_;
  P limit_, t_limit_, t_last_;  // of the next step
  Mask active_, rejected_, leaves_, arrived_, seen_, took_;
  P y_[N], y_new_[N], lost_[N], lost_new_[N], stage_[N], f_[N];
  P k_[C::stages][N];  // k₁; less k₁: k₂ … k_s
  long steps_[lanes] = {}, evaluations_[lanes] = {};
};

}  // namespace qdot::detail
