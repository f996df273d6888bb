#pragma once
// SPDX-License-Identifier: MIT
//
// One derivation of T and V: their equations, the lines that came of these, and where and for which functors they hold.
//
// Where a run has derived q̈ of the same functors already (mechanics/derive/kept_rates.hpp), its equations are taken, and only lines are written.
//
// A derivation holds as long as T and V are the same formulas. That is checked by a hash of what they do (ad/formula/hashed.hpp): another captured number,
// sign or threshold gives another.
//
// Functors that compare numbers are derived for one branch at a time. The recording knows the state and notes the guards on which its branch depends
// (ad/formula/branches.hpp). Their signs are lines. The hash follows the same branch, since comparisons get the same answers.

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "qdot/mechanics/derive/derived_equations.hpp"
#include "qdot/mechanics/derive/fingerprint.hpp"
#include "qdot/mechanics/derive/lines.hpp"

namespace qdot::detail {

template <class Number>
class TracedEquations;  // mechanics/derive/traced_equations.hpp

// Equations of T, V and perhaps forces, and their lines; of a branch the guards that tell it from others, too.
template <class Number = double>
struct Derivation {
  std::shared_ptr<const TracedEquations<Number>> equations;
  DerivedLines lines;
  formula::LineEvaluator sides;  // lines of the guards of a branch
  std::vector<int> guards;       // and their numbers

  explicit Derivation(By by = By::fastest);
  ~Derivation();

  /// Derives what has been recorded, which no other derivation knows.
  void derive(TracedEquations<Number> recorded);
  /// Derives T, V and perhaps forces that have been recorded, with so many parameters as variables.
  void derive_motion(RecordedMotion recorded, int parameters);
  /// Writes lines of equations that have been derived.
  void write(std::shared_ptr<const TracedEquations<Number>> derived);
  /// Writes lines of M alone.
  void write_mass(DerivedLines& mass) const;
  void derive_slopes();
  void derive_solution();
  void write_sides();
};

// The number of coordinates at a state.
template <int n>
constexpr int size_at(const AtState& at) {
  return n == Dynamic ? at.size : n;
}

/// T and V of an object that outlives this, without its type: for what is asked of them seldom.
struct RecordableFunctors {
  const void* energies;
  int size;
  void (*run)(const void*, RecordedMotion&);
  Fingerprint (*print)(const void*, int, const Answers*);

  template <int n, class E>
  static RecordableFunctors of(const E& e, int size) {
    return {&e, size, [](const void* it, RecordedMotion& m) { run_energies<n>(m, *static_cast<const E*>(it)); },
            [](const void* it, int count, const Answers* answers) { return fingerprint<n>(*static_cast<const E*>(it), count, answers); }};
  }
};

/// A derivation, where it holds, and slopes on request. May be asked by several threads.
template <class Number = double>
class BasicKeptDerivation {
 public:
  explicit BasicKeptDerivation(By by = By::fastest);
  ~BasicKeptDerivation();

  /// Of functors without comparisons, or of their branch at a state.
  void derive(const RecordableFunctors& functors, const AtState* at = nullptr);
  /// Of functors with this fingerprint, which compare nothing and whose equations are known.
  void take(std::shared_ptr<const TracedEquations<Number>> equations, Fingerprint print);

  Fingerprint print() const { return print_; }
  /// Whether the functors compare numbers, so that there is no fingerprint without answers.
  bool is_asked() const { return !answers_.empty(); }
  /// The lines; null where T and V are no formulas, or too long.
  const DerivedLines* lines() {
    if (!is_written_.load(std::memory_order_acquire)) write();
    return derivation_.lines.exist() ? &derivation_.lines : nullptr;
  }
  /// Lines of M alone; null where T and V are no formulas, or too long.
  const DerivedLines* lines_of_mass() {
    if (!is_asked_for_mass_.load(std::memory_order_acquire)) write_mass();
    return mass_.exist() ? &mass_ : nullptr;
  }
  /// The lines with slopes; null where these are too long.
  const DerivedLines* lines_with_slopes() {
    if (lines() && !is_asked_for_slopes_.load(std::memory_order_acquire)) derive_slopes();
    return derivation_.lines.have_slopes() ? &derivation_.lines : nullptr;
  }
  /// The lines with those that go on to q̈ for lanes; null where there are none.
  const DerivedLines* lines_for_lanes() {
    if (lines() && !is_asked_for_lanes_.load(std::memory_order_acquire)) derive_solution();
    return lines() && !derivation_.lines.solution.accelerations.empty() ? &derivation_.lines : nullptr;
  }

  /// Whether a state is on the branch that was recorded.
  bool holds_at(const AtState& at) const { return derivation_.guards.empty() || is_beside_guards(at); }
  /// Whether the functors are those that were derived.
  bool is_of(const RecordableFunctors& functors) const;

 private:
  void write();
  void write_mass();
  void derive_slopes();
  void derive_solution();
  bool is_beside_guards(const AtState& at) const;
  template <std::size_t room>
  bool holds_with(const AtState& at) const;

  int size_ = 0;
  Answers answers_{};
  Fingerprint print_ = 0;
  std::mutex mutex_{};
  std::atomic<bool> is_written_{true}, is_asked_for_mass_{false}, is_asked_for_slopes_{false}, is_asked_for_lanes_{false};
  Derivation<Number> derivation_;
  DerivedLines mass_;
};
using KeptDerivation = BasicKeptDerivation<>;

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template struct Derivation<double>;
extern template class BasicKeptDerivation<double>;
}  // namespace qdot::detail
#else
#include "qdot/mechanics/derive/derivation.ipp"
#endif
