#pragma once
// SPDX-License-Identifier: MIT
//
// What time brings: no step passes over a stretch of time that nobody looked at.
//
// A method evaluates forces at a few times of a step. A system at rest lets it choose any step, and a push that begins and ends between
// two of these times is never felt; no error estimate can know of it. So where a signature says that time enters, V(q, t),
// T(q, qdot, t) or an effect with t, steps are limited to what has been looked at.
//
// Formulas. T, V and what takes the time of the effects are run once with the scalar that writes down what is done to it. Their
// functions of time are then bounded over whole stretches of it, with their rates (ad/formula/time_bounds.hpp), and a stretch [t, t + L] says:
// here nothing of a length below s can happen. A step may be as long as s, or as L where nothing happens at all. Where L is large and s
// is not, because something happens somewhere in it, L is halved. So an oscillator at rest with a push of a thousandth at t = 8 is
// brought to the foot of the push in some twenty steps; from there the method sees it, and chooses for itself. Under a force sin Ωt
// one look at the beginning says that steps below 4/Ω are good for ever, and there are no longer ones.
//
// Other functors, those with a branch or a kink or that do not take every scalar, are looked at in samples: before a step longer
// than 1/256 of the run, the accelerations at the present state and at the times between are compared with those at its ends. What they
// do within less may be missed. Statistics::time_resolution is this length, and 0 where all was bounded. Stop times, or a
// max_step, are the remedy.
//
// Not covered: methods with a step of fixed length, which is the user's choice; systems of first order by themselves, whose signature
// says nothing; what happens in a place that is passed quickly, V(q) with a bump, where no time enters.
//
// Cost. Systems without time: none. Otherwise two comparisons per step, and a look of less than a microsecond where the last one does not
// reach far enough: under smooth drives every hundred steps or less.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/ad/formula/time_bounds.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/integrate/steps/recorded_motion.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot::detail {

// The formulas of a system into which time enters.
struct TimeFormulas {
  formula::Recording recording = {};
  std::vector<int> state = {};  // variables, in the order of y
  int t = -1;
  std::vector<int> roots = {};
  bool complete = true;  // false where there is something besides
};

// Runs a functor with the recording scalar, if it lets itself be recorded.
template <bool takes_every_scalar, class Record>
void record_part(TimeFormulas& found, const Record& record) {
  if constexpr (takes_every_scalar) {
    try {
      record();
      return;
    } catch (...) {  // not a formula, or not here; it is the method that finds out what is wrong with it
    }
  }
  found.complete = false;
}

// `count` components of the state, from `first` on, as numbers that write down what is done to them.
template <int n>
Vector<formula::Recorded, n> recorded_part(TimeFormulas& found, Eigen::Index first, Eigen::Index count) {
  const auto begin = found.state.begin() + first;
  return recorded_vector<n>(found.recording, std::vector<int>(begin, begin + count));
}

template <class F>
struct TimeOf {
  static constexpr bool enters = false;
};

template <class Sys>
struct TimeOf<FirstOrderForm<Sys>> {
  static constexpr int n = Sys::dof_at_compile_time;
  static constexpr bool enters = !Sys::autonomous;

  // T and V, and what the equations contain of them: ∂T/∂t, as momenta have, and derivatives by q and q̇.
  [[gnu::cold]] static void record_energies(TimeFormulas& found, const Sys& system) {
    constexpr bool can = RecordableEnergies<typename Sys::EnergiesType, n>;
    record_part<can>(found, [&] {
      if constexpr (can) {
        const auto q = recorded_part<n>(found, 0, system.dof()), v = recorded_part<n>(found, system.dof(), system.dof());
        const formula::Recorded t(found.recording, found.t);
        add(found, kinetic<n>(system.energies(), q, v, t), true, true);
        add(found, potential<n>(system.energies(), q, t), false, true);
      }
    });
  }

  // One result; with its derivatives by time and by state where the equations contain them.
  static void add(TimeFormulas& found, const formula::Recorded& result, bool by_time, bool by_state) {
    formula::Graph& graph = found.recording.graph;
    const int root = result.node_in(found.recording);
    found.roots.push_back(root);
    if (by_time) found.roots.push_back(graph.gradient(root, std::vector<int>{found.t})[0]);
    if (!by_state) return;
    const std::vector<int> slopes = graph.gradient(root, found.state);
    found.roots.insert(found.roots.end(), slopes.begin(), slopes.end());
  }

  static void record(TimeFormulas& found, const FirstOrderForm<Sys>& form) { record_energies(found, form.system()); }
};

// An effect whose functor takes the time; where it does not say, it may.
template <class E, int n>
consteval bool effect_takes_time() {
  if constexpr (requires { E::template takes_time<n>; }) {
    return E::template takes_time<n>;
  } else {
    return true;
  }
}

template <class Sys, class... Effects>
struct TimeOf<SceneForm<Scene<Sys, Effects...>>> {
  static constexpr int n = Sys::dof_at_compile_time;
  template <class E>
  static constexpr bool in_energies = LagrangianEffect<E, n> || PotentialEffect<E, n>;
  static constexpr bool energies_take_time = !Sys::autonomous || ((in_energies<Effects> && effect_takes_time<Effects, n>()) || ...);
  static constexpr bool enters = !Sys::autonomous || (effect_takes_time<Effects, n>() || ...);

  template <class Form>
  static void record(TimeFormulas& found, const Form& form) {
    const auto& system = form.scene().system();
    using Behind = TimeOf<FirstOrderForm<std::remove_cvref_t<decltype(system)>>>;
    if constexpr (energies_take_time) Behind::record_energies(found, system);
    Eigen::Index first = 2 * form.dof();
    const auto visit = [&]<class E>(const E& e) {
      if constexpr (effect_takes_time<E, n>()) record_effect(found, e, form.dof(), first);
      first += states_of<E>();
    };
    std::apply([&](const auto&... e) { (visit(e), ...); }, form.scene().effects());
  }

 private:
  template <class E>
  [[gnu::cold]] static void record_effect(TimeFormulas& found, const E& e, Eigen::Index dof, Eigen::Index first) {
    using S = formula::Recorded;
    constexpr int states = states_of<E>();
    const auto q = recorded_part<n>(found, 0, dof), v = recorded_part<n>(found, dof, dof);
    const S t(found.recording, found.t);
    const auto add = [&](const auto& rows, bool by_time) {
      for (Eigen::Index i = 0; i < rows.size(); ++i) TimeOf<FirstOrderForm<Sys>>::add(found, S(rows[i]), by_time, false);
    };
    if constexpr (HolonomicEffect<E, n>) {
      constexpr bool can = requires { e.phi(q, t); };
      record_part<can>(found, [&] {  // φ and its first two derivatives
        if constexpr (can) {
          for (const auto& row : as_rows(e.phi(q, t))) {
            const int rate = found.recording.graph.gradient(row.node_in(found.recording), std::vector<int>{found.t})[0];
            TimeOf<FirstOrderForm<Sys>>::add(found, row, false, true);
            TimeOf<FirstOrderForm<Sys>>::add(found, S(found.recording, rate), true, true);
          }
        }
      });
    } else if constexpr (NonholonomicEffect<E, n>) {
      constexpr bool can = requires { e.velocity_constraint(q, v, t); };
      record_part<can>(found, [&] {
        if constexpr (can) add(as_rows(e.velocity_constraint(q, v, t)), true);
      });
    }
    if constexpr (StateEffect<E> && !SwitchingEffect<E, n>) {
      const auto z = recorded_part<states>(found, first, states);
      constexpr bool can = requires { e.force(q, v, z, t), e.state_rate(q, v, z, t); };
      record_part<can>(found, [&] {
        if constexpr (can) add(e.force(q, v, z, t), false), add(e.state_rate(q, v, z, t), false);
      });
    } else if constexpr (ForceEffect<E, n>) {
      constexpr bool can = requires { e.force(q, v, t); };
      record_part<can>(found, [&] {
        if constexpr (can) add(e.force(q, v, t), false);
      });
    }
  }
};

/// Says how far the next step may go.
template <FirstOrderSystem F>
class TimeWatch {
 public:
  static constexpr bool watches = TimeOf<F>::enters;

  TimeWatch(const F& system, const Options& options) : system_(system), options_(options) {}

  /// Begins at a time: that of the start, or where something else begins, and a functor may have become another.
  [[gnu::cold]] void begin(double t) {
    TimeFormulas found;
    const Eigen::Index dof = qdot::detail::dof(system_);
    found.state = new_variables(found.recording, 0, 2 * dof);
    found.t = found.recording.graph.variable(static_cast<int>(2 * dof));
    for (const int z : new_variables(found.recording, 2 * dof + 1, system_.size() - 2 * dof)) found.state.push_back(z);
    TimeOf<F>::record(found, system_);
    t_seen_ = t;
    stale_ = 0;
    if (std::exchange(begun_, true) && same(found, formulas_)) return;  // behind an impact, mostly
    bounds_ = formula::TimeBounds(found.recording.graph, found.t, found.state, found.roots);
    bounded_ = bounds_.is_needed();
    is_complete_ = found.complete;
    formulas_ = std::move(found);
    begin_another(t);
  }

  /// Begins another motion with the functors as they were when one was begun.
  void begin_another(double t) {
    bounds_.forget();
    t_seen_ = reach_ = horizon_ = landing_ = t;
    wish_ = std::numeric_limits<double>::infinity();
    stale_ = 0;
  }

  /// Where a step from (t, y) towards `landing` must end at the latest.
  template <class Y>
  double reach(double t, const Y& y, double landing) {
    if (!bounded_ && is_complete_) return landing;
    const double left = std::abs(landing - t);
    if (landing_ != landing) set_out(t, y, landing);
    if (t != t_seen_) wish_ = (t == reach_ ? 4.0 : 2.0) * std::abs(t - t_seen_);
    t_seen_ = t;
    double room = left;
    if (bounded_) {
      if (std::abs(horizon_ - t) < std::min(wish_, left) || (--stale_ <= 0 && bounds_.depends_on_state())) look(t, y, landing);
      room = std::min(room, std::min(step_, std::abs(horizon_ - t)));
    }
    if (!is_complete_) room = std::min(room, sampled(t, y, landing));
    reach_ = room < left ? t + std::copysign(std::max(room, 64 * epsilon * std::abs(t)), landing - t) : landing;
    return reach_;
  }

  /// Time that may have been passed over without a look; 0: none.
  double resolution() const noexcept { return resolution_; }

 private:
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();
  static constexpr int samples = 256;       // of the way to the end or the next stop time, where there is no formula
  static constexpr double ahead = 64.0;     // steps that a look should be good for
  static constexpr int steps_of_state = 8;  // the same where the state matters as well
  static constexpr double shortest = 1e-10;  // of the way: what remains of a kink, where rates are infinite

  static bool same(const TimeFormulas& a, const TimeFormulas& b) {
    const auto& x = a.recording.graph.nodes();
    const auto& y = b.recording.graph.nodes();
    return a.roots == b.roots && a.complete == b.complete &&
           std::equal(x.begin(), x.end(), y.begin(), y.end(), [](const formula::Node& m, const formula::Node& n) {
             return m.kind == n.kind && m.function == n.function && m.a == n.a && m.b == n.b && m.ca == n.ca && m.cb == n.cb && m.c == n.c;
           });
  }

  // On a new way.
  template <class Y>
  void set_out(double t, const Y& y, double landing) {
    landing_ = landing;
    state_ = y;
    if (bounded_) bounds_.measure(t, landing, {state_.data(), static_cast<std::size_t>(state_.size())});
    if (!is_complete_) resolution_ = std::max(resolution_, spacing_ = std::abs(landing - t) / samples);
  }

  // Bounds the time before us: as far as possible, as long as steps remain as long as is wished.
  template <class Y>
  void look(double t, const Y& y, double landing) {
    const double left = landing - t, least = shortest * std::abs(left);
    rates_.resize(y.size());
    std::fill_n(rates_.data(), rates_.size(), 0.0);
    state_ = y;
    std::copy_n(state_.data() + dof(system_), dof(system_), rates_.data());
    double L = std::min(std::abs(left), (bounds_.depends_on_state() ? 2.0 * steps_of_state : ahead) * wish_);
    for (;; L *= 0.5) {
      const bool finite = bounds_.over(t, t + std::copysign(L, left), {state_.data(), static_cast<std::size_t>(state_.size())},
                                       {rates_.data(), static_cast<std::size_t>(rates_.size())});
      step_ = finite ? bounds_.longest_step(options_.rtol) : 0.0;
      if (step_ >= std::min(wish_, L)) break;
      if (L <= least) {
        step_ = L;
        break;
      }
    }
    horizon_ = t + std::copysign(L, left);
    stale_ = steps_of_state;
  }

  // The way along which samples of f at the present state show nothing that its end does not show.
  template <class Y>
  double sampled(double t, const Y& y, double landing) {
    if (std::isinf(wish_) || wish_ <= spacing_) return spacing_;
    state_ = y;
    rates_.resize(y.size());
    changed_.resize(y.size());
    const double direction = landing > t ? 1.0 : -1.0, way = std::min(wish_, std::abs(landing - t));
    int best = 1;
    double largest = 0.0;
    try {
      system_.derivative(t, state_, rates_);
      for (int j = 1; j <= samples && (j - 1) * spacing_ < way; ++j) {
        const double at = std::min(j * spacing_, way);
        system_.derivative(t + direction * at, state_, changed_);
        double most = 0.0;
        for (Eigen::Index i = 0; i < state_.size(); ++i)
          most = std::max(most, std::abs(changed_[i] - rates_[i]) * way / (options_.rtol * std::abs(state_[i]) + options_.atol[i]));
        largest = std::max(largest, most);
        if (largest <= 1.0 + 4.0 * most) best = j;
      }
    } catch (const Error&) {  // the method will find out by itself
    }
    return best * spacing_;
  }

  const F& system_;
  const Options& options_;
  bool begun_ = false;
  TimeFormulas formulas_;
  formula::TimeBounds bounds_;
  bool bounded_ = false, is_complete_ = true;  // there are formulas; there is nothing else
  double spacing_ = 0.0, resolution_ = 0.0;    // of samples, and the largest so far
  double t_seen_ = 0.0, reach_ = 0.0, landing_ = 0.0;  // of the last question
  double wish_ = 0.0;                          // the length of step that should be possible
  double step_ = 0.0, horizon_ = 0.0;          // that is possible, as far as this time
  int stale_ = 0;                              // steps until the state is another
  Eigen::VectorXd state_, rates_, changed_;
};

/// Stands for the same where no time enters.
struct NoTimeWatch {
  template <class F>
  NoTimeWatch(const F&, const Options&) {}
};

}  // namespace qdot::detail
