#pragma once
// SPDX-License-Identifier: MIT
//
// Is the right-hand side a function?
//
// Methods take it for granted: that f(t, y) is the same whenever it is asked for. A stage of the last step is the first of the
// next, a multistep method believes its past, a power series is made from what was recorded, a step is rejected and taken anew. A
// force that reads a variable which an observer writes to, or that counts its own calls, is no such f, and what comes out
// depends on the method and on its steps. So f is asked twice. Where a leg begins (the start, a stop time, an event that changes
// the state) and at each look its values at (t, y) are kept; at the next look it is evaluated *there* again:
//
//     rates          q̈ and ż, by the equations of motion themselves: without recordings or factors that somebody keeps
//     constraints    φ and φ̇, since a projection follows φ where φ̈ shows nothing
//     guards         gaps, and what holds friction back
//
// It is compared with the values of a look before, and at every fourth look with those of the leg's begin as well: the first sees
// what had no influence where the leg began, the second what creeps. Values are kept anew at the first seven looks and then
// at every fourth, so that a look costs one evaluation and a half. Where a leg begins T and V are asked twice, one call behind the other:
// those that count their calls show it then.
//
// Tolerance. The same instructions on the same numbers give the same bits, however stiff, near to singular, huge or tiny
// the system is, so an honest one is not judged at all. Bits that differ may still be rounding, where the order of a sum depends on
// threads or on the alignment of memory, or a functor iterates from where it stopped before. So a difference δ in component i
// is a change of the model only if rounding does not explain it,
//
//     |δ| > Σⱼ |fᵢ(y + 2⁻³⁶ yⱼ eⱼ) − fᵢ(y)|   and   |δ| > 2⁻³⁶ |fᵢ| ,          2⁻³⁶ = 1.5e-11 ,
//
// a hundred thousand times what rounding of y does, with all the bad condition that f has there; and, for rates, if it
// matters to the accuracy that was asked for: |δ| times the time since the leg began > rtol |yᵢ| + atolᵢ.
//
// A state where f cannot be evaluated is not compared: the method itself will meet that.
//
// What is asked for depends on the form's type, and is little; how it is compared does not.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "qdot/ad/vector.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/integrate/watch/energy_slope.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot::detail {

/// The values of a first-order system at a state: rates, then constraints, then guards.
template <FirstOrderSystem F>
class ModelValues {
 public:
  explicit ModelValues(const F& system) : system_(system) {}

  /// out ← all of them. False where they cannot be evaluated, or are not finite.
  [[gnu::noinline]] bool at(double t, const Eigen::VectorXd& y, Eigen::VectorXd& out) const {
    try {
      write(t, y, out);
    } catch (...) {
      return false;
    }
    return all_finite(out.data(), out.size());
  }

  /// What T and V are; NaN where there are none.
  [[gnu::cold, gnu::noinline]] std::array<double, 2> energies([[maybe_unused]] double t, [[maybe_unused]] const Eigen::VectorXd& y) const {
    std::array<double, 2> found{std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
    const auto ask = [&](const auto& system) {
      const EnergyAt energy = energy_at(system, t, y);
      found = {energy.T, energy.V};
    };
    try {
      if constexpr (is_scene) ask(system_.scene().system());
      else if constexpr (requires { system_.system().energies(); }) ask(system_.system());
    } catch (...) {  // they will throw again
    }
    return found;
  }

  Eigen::Index rates() const { return system_.size(); }
  /// In words.
  std::string name(Eigen::Index i) const {
    if (i < rates()) return sentence({"the rate of ", system_.component_name(i)});
    if constexpr (has_constraints) {
      const auto names = constraint_names(system_.scene());
      const auto rows = static_cast<Eigen::Index>(names.size()), k = i - rates();
      if (k < 2 * rows) return sentence({k < rows ? "the constraint '" : "the velocity of the constraint '", names[static_cast<std::size_t>(k % rows)], "'"});
    }
    return "the gap of a contact or the limit of a friction";
  }

 private:
  static constexpr bool has_constraints = requires { requires F::has_constraints; };
  static constexpr bool is_scene = requires(const F& f) { f.scene().effects(); };

  KeptLines* kept_lines() const {
    if constexpr (is_scene) return system_.scene().system().kept_lines();
    else if constexpr (requires { system_.system().kept_lines(); }) return system_.system().kept_lines();
    else return nullptr;
  }

  // Allocates nothing where n is fixed and out has been written to before.
  void write(double t, const Eigen::VectorXd& y, Eigen::VectorXd& out) const {
    const KeptLines::Aside aside(kept_lines());  // but lines that it keeps are asked for no values here
    const Eigen::Index size = system_.size();
    Eigen::Index guards = 0;
    if constexpr (SwitchingSystem<F>) guards = system_.guard_count();
    if constexpr (has_constraints) {
      constexpr int n = F::dof_at_compile_time;
      const Eigen::Index k = system_.dof();
      using Q = Vector<double, n>;
      using Z = Vector<double, std::remove_cvref_t<decltype(system_.scene())>::states_at_compile_time>;
      const Q q = Eigen::Map<const Q>(y.data(), k), qdot = Eigen::Map<const Q>(y.data() + k, k);
      const Z z = Eigen::Map<const Z>(y.data() + 2 * k, size - 2 * k);
      const auto phi = constraint_residual(system_.scene(), q, t, z), velocity = constraint_velocity(system_.scene(), q, qdot, t, z);
      out.resize(size + 2 * phi.size() + guards);
      std::copy_n(velocity.data(), velocity.size(), std::copy_n(phi.data(), phi.size(), out.data() + size));
    } else {
      out.resize(size + guards);
    }
    if constexpr (requires { system_.system().energies(); }) {
      const State<dof_at_compile_time<F>()> at = system_.state(t, y);
      const auto a = acceleration(system_.system(), at.q, at.qdot, t);  // with no factors of M that the form keeps
      std::copy_n(a.data(), a.size(), std::copy_n(at.qdot.data(), at.qdot.size(), out.data()));
    } else {
      system_.derivative(t, y, Eigen::Map<Eigen::VectorXd>(out.data(), size));
    }
    if constexpr (SwitchingSystem<F>) system_.guards(t, y, Eigen::Map<Eigen::VectorXd>(out.data() + out.size() - guards, guards));
  }

  const F& system_;
};

// The trouble with what has been recorded or read of functors, and is something else by now.
inline Failure other_formula() {
  return {Outcome::model_changed, "between events and stop times functors must depend on nothing but their arguments, but T, V or an effect has "
                                  "become another formula, or the same with another constant"};
}
// ModelValues without the type of the form, which outlives this.
struct AnyModelValues {
  const void* form;
  Eigen::Index rates;
  bool (*write)(const void*, double, const Eigen::VectorXd&, Eigen::VectorXd&);
  std::string (*named)(const void*, Eigen::Index);
  std::array<double, 2> (*energies)(const void*, double, const Eigen::VectorXd&);

  template <FirstOrderSystem F>
  explicit AnyModelValues(const F& of)
      : form(&of), rates(of.size()),
        write([](const void* f, double t, const Eigen::VectorXd& y, Eigen::VectorXd& out) { return ModelValues(*static_cast<const F*>(f)).at(t, y, out); }),
        named([](const void* f, Eigen::Index i) { return ModelValues(*static_cast<const F*>(f)).name(i); }),
        energies([](const void* f, double t, const Eigen::VectorXd& y) { return ModelValues(*static_cast<const F*>(f)).energies(t, y); }) {}

  bool at(double t, const Eigen::VectorXd& y, Eigen::VectorXd& out) const { return write(form, t, y, out); }
};

/// Compares a run's right-hand side with what it was.
template <class Number = double>
class BasicChangeWatch {
 public:
  BasicChangeWatch(const AnyModelValues& values, const Options& options) : values_(values), options_(options) {}

  /// Begins a leg: whatever changed before was allowed to.
  void begin(double t, const Eigen::VectorXd& y);

  /// Keeps the values at a state for the next look.
  void remember(double t, const Eigen::VectorXd& y) {
    if (looks_ < 8 || looks_ % thinned == 0) keep(latest_, t, y);
  }

  /// What is not as it was, if something is.
  std::optional<Failure> look(double t);

 private:
  static constexpr double rounding = 0x1p-36;
  static constexpr long thinned = 4;

  struct Seen {
    bool is_known = false;
    double t = 0.0;
    Eigen::VectorXd y, values;
  };

  void keep(Seen& seen, double t, const Eigen::VectorXd& y);

  bool is_same(const Seen& seen) const {
    return now_.size() == seen.values.size() &&
           std::memcmp(now_.data(), seen.values.data(), static_cast<std::size_t>(now_.size()) * sizeof(double)) == 0;
  }

  // The component that changed most, of those whose change rounding does not explain.
  std::optional<Eigen::Index> changed(const Seen& seen, double duration);

  Failure failure(const Seen& seen, Eigen::Index i, double t) const;

  AnyModelValues values_;
  const Options& options_;
  Seen first_, latest_;
  long looks_ = 0;  // in this leg
  Eigen::VectorXd now_;
  std::array<double, 4> at_once_{};  // T, T again, V, V again where a leg begins
};

template <class Number>
void BasicChangeWatch<Number>::begin(double t, const Eigen::VectorXd& y) {
  keep(first_, t, y);
  const auto once = values_.energies(values_.form, t, y), again = values_.energies(values_.form, t, y);
  at_once_ = {once[0], again[0], once[1], again[1]};
  latest_.is_known = false;
  looks_ = 0;
}

template <class Number>
std::optional<Failure> BasicChangeWatch<Number>::look(double t) {
  for (const std::size_t i : {0U, 2U})
    if (std::abs(at_once_[i] - at_once_[i + 1]) > rounding * (std::abs(at_once_[i]) + std::abs(at_once_[i + 1])))
      return Failure{Outcome::model_changed,
                     sentence({"functors must depend on nothing but their arguments, but ", i == 0 ? "T" : "V", " at t = ", first_.t, " was ",
                               at_once_[i], " and, asked once more at the same state, ", at_once_[i + 1]})};
  const bool both = ++looks_ % thinned == 0 || !latest_.is_known;
  for (const Seen* seen : {&latest_, &first_})
    if (seen->is_known && (seen == &latest_ || both) && values_.at(seen->t, seen->y, now_) && !is_same(*seen))
      if (const std::optional<Eigen::Index> i =
              changed(*seen, std::abs(t - first_.t) + 4 * std::numeric_limits<double>::epsilon() * std::abs(t)))
        return failure(*seen, *i, t);
  return std::nullopt;
}

template <class Number>
void BasicChangeWatch<Number>::keep(Seen& seen, double t, const Eigen::VectorXd& y) {
  seen.t = t;
  seen.y = y;
  seen.is_known = values_.at(t, y, seen.values);
}

template <class Number>
[[gnu::cold, gnu::noinline]] std::optional<Eigen::Index> BasicChangeWatch<Number>::changed(const Seen& seen, double duration) {
  const Eigen::Index size = std::min(now_.size(), seen.values.size());
  Eigen::VectorXd explained(now_.size()), moved = seen.y, there;
  for (Eigen::Index i = 0; i < now_.size(); ++i) explained[i] = rounding * std::abs(now_[i]);
  for (Eigen::Index j = 0; j < moved.size(); ++j) {
    moved[j] += rounding * moved[j];
    if (moved[j] != seen.y[j] && values_.at(seen.t, moved, there) && there.size() == now_.size())
      for (Eigen::Index i = 0; i < now_.size(); ++i) explained[i] += std::abs(there[i] - now_[i]);
    moved[j] = seen.y[j];
  }
  std::optional<Eigen::Index> worst;
  double largest = 0.0;
  for (Eigen::Index i = 0; i < size; ++i) {
    const double change = std::abs(now_[i] - seen.values[i]);
    if (!(change > explained[i])) continue;
    if (i < values_.rates && !(change * duration > options_.rtol * std::abs(seen.y[i]) + options_.atol[i])) continue;
    const double part = change / std::max(std::abs(now_[i]), std::abs(seen.values[i]));
    if (part > largest) {
      largest = part;
      worst = i;
    }
  }
  return worst;
}

template <class Number>
[[gnu::cold, gnu::noinline]] Failure BasicChangeWatch<Number>::failure(const Seen& seen, Eigen::Index i, double t) const {
  return {Outcome::model_changed,
          sentence({"between events and stop times functors must depend on nothing but their arguments, but ", values_.named(values_.form, i), " at t = ",
                    seen.t, " was ", seen.values[i], " and is ", now_[i], " when it is evaluated there again at t = ", t})};
}
using ChangeWatch = BasicChangeWatch<>;

#ifdef QDOT_COMPILED
extern template class BasicChangeWatch<double>;
#endif

}  // namespace qdot::detail
