#pragma once
// SPDX-License-Identifier: MIT
//
// q̈ of many coordinates from the equations that were traced when a run began.
//
// A form of first order with n known at run time writes T and V down once (mechanics/derive/traced_equations.hpp) and goes through the lines of M and
// r at every evaluation (ad/formula/lines.hpp). Equal bodies are loops over arrays there, so a mass of a million costs what it costs by hand.
//
//     M diagonal      q̈_i = r_i / M_ii are lines themselves
//     M constant      factored once
//     other M         factored at every evaluation, with a pattern that is known (mechanics/equations/sparse_factors.hpp)
//
// Whatever is not as it should be, a pivot that is too small, a number that is not finite, is left to the general way, which knows what to do and how to
// name it. An object has numbers of its own, so one thread at a time may ask it; copies are independent and share the lines.

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "qdot/ad/native/line_evaluator.hpp"
#include "qdot/mechanics/derive/traced_equations.hpp"
#include "qdot/mechanics/equations/solve.hpp"
#include "qdot/mechanics/equations/sparse_factors.hpp"

namespace qdot::formula {
template <class Coefficient>
class LineWriter;  // of ad/formula/line_writer.hpp
}  // namespace qdot::formula

namespace qdot::detail {

inline void append(std::vector<int>& all, const std::vector<int>& more) { all.insert(all.end(), more.begin(), more.end()); }

/// Lines of a traced object, which copies share, and the numbers on which they are carried out.
template <class Number = double>
class TracedLines {
 public:
  explicit TracedLines(TracedEquations<Number> equations);

  const TracedEquations<Number>& equations() const { return shared_->equations; }
  TracedEquations<Number>& equations() { return shared_->equations; }

  /// Lines of what `outputs` need beyond what is written already. All are written before the first evaluation.
  std::shared_ptr<const formula::LineEvaluator> written(const std::vector<int>& outputs);
  /// Lines of x = M⁻¹ b, of M⁻¹ times each column, which may ask for x as the variables q̈, and of `others`, which may not. Nothing where M has a zero on
  /// its diagonal, a constant pivot that is not above a fraction `least` of it, or more than `most` numbers. In the lists −1 stands for zero; of columns one
  /// stands behind the other. These lines have their constants, and go with any vector of so many numbers.
  struct Solved {
    std::shared_ptr<formula::LineEvaluator> lines;
    std::vector<int> x, columns;              ///< numbers of the solutions
    std::vector<std::pair<int, int>> pivots;  ///< numbers of which the first of each pair must be above a fraction of the second
  };
  Solved solved(const std::vector<int>& mass, const std::vector<int>& b, const std::vector<int>& columns, const std::vector<int>& others, double least,
                std::size_t most);
  /// Those of x alone, of many rows, whose constants are not folded.
  Solved solved_in_order(const std::vector<int>& mass, const std::vector<int>& b, const std::vector<int>& others, std::size_t most);
  /// Whether the functors are what was traced: run(motion) runs them again.
  template <class Run>
  bool still_holds(const Run& run) {
    const std::lock_guard lock(shared_->again);
    return is_unchanged(shared_->equations.motion, run);
  }
  /// Where the values of nodes are.
  std::vector<int> numbers(const std::vector<int>& nodes) const;

  /// Nodes that hold_requirements() looks at, for written().
  std::vector<int> required() const {
    std::vector<int> nodes;
    for (const Requirement& r : equations().requirements) nodes.push_back(r.node);
    return nodes;
  }
  /// Whether the functors have values where the numbers are.
  bool hold_requirements() {
    const std::vector<Requirement>& all = equations().requirements;
    if (required_.size() != all.size()) required_ = numbers(required());
    bool hold = true;
    for (std::size_t k = 0; k < all.size(); ++k) hold = hold && all[k].holds((*this)[required_[k]]);
    return hold;
  }

  /// Sets the state.
  void set(const double* q, const double* qdot, double t, const double* z) {
    const std::size_t n = equations().n();
    double* to = std::copy_n(q, n, x_.data());
    to = std::copy_n(qdot, n, to);
    *to++ = t;
    if (equations().states() > 0) std::copy_n(z, equations().states(), to);
  }
  /// q, q̇, t, z, then q̈, parameters and λ.
  double* inputs() { return x_.data(); }
  void set_accelerations(const double* a) { std::copy_n(a, equations().n(), inputs() + 2 * equations().n() + 1 + equations().states()); }
  double* multipliers() { return inputs() + 3 * equations().n() + 1 + equations().states() + equations().parameters.size(); }
  void carry_out(const formula::LineEvaluator& lines) { lines(x_.data()); }
  double operator[](int number) const { return x_[static_cast<std::size_t>(number)]; }
  bool are_native() const { return !shared_->written.empty() && shared_->written.front()->is_native(); }
  bool are_long() const { return x_.size() > formula::longest_native_lines; }

 private:
  struct Shared {
    TracedEquations<Number> equations;
    std::size_t inputs;
    std::shared_ptr<formula::LineWriter<Number>> writer;
    std::vector<std::shared_ptr<formula::LineEvaluator>> written;
    std::mutex again;  // copies in several threads may run the functors again
    explicit Shared(TracedEquations<Number> e)
        : equations(std::move(e)), inputs(3 * equations.n() + 1 + equations.states() + equations.parameters.size() + equations.rows()) {}
    Shared(const Shared&) = delete;
  };

  std::shared_ptr<formula::LineEvaluator> evaluator(formula::LineTable table);
  template <class ToNumber>
  Solved evaluated(formula::LineTable table, Solved found, const std::vector<int>& others, const ToNumber& number, std::size_t most);

  std::shared_ptr<Shared> shared_;
  std::vector<double> x_;
  std::vector<int> required_;
};

/// q̈ and ż of a system, or of a scene without constraints.
template <class Number = double>
class TracedMotion {
 public:
  explicit TracedMotion(TracedEquations<Number> equations);

  /// Whether there are equations to go through.
  bool is_known() const { return is_known_; }
  bool mass_is_constant() const { return lines_.equations().mass_is_constant; }
  const TracedLines<Number>& lines() const { return lines_; }

  /// q̈, and ż where there are states; false where the general way must see to it.
  bool write(const double* q, const double* qdot, double t, const double* z, double* a, double* zdot) {
    lines_.set(q, qdot, t, z);
    lines_.carry_out(*table_);
    if (!lines_.hold_requirements()) return false;
    double zero = 0.0;
    for (std::size_t i = 0; i < right_.size(); ++i) {
      a[i] = lines_[right_[i]];
      zero += a[i] - a[i];
    }
    for (std::size_t k = 0; k < zdot_.size(); ++k) {
      zdot[k] = lines_[zdot_[k]];
      zero += zdot[k] - zdot[k];
    }
    if (!mass_.empty()) {
      for (std::size_t k = 0; k < mass_.size(); ++k) {
        values_[k] = lines_[mass_[k]];
        zero += values_[k] - values_[k];
      }
      if (factors_) {
        if (!factored()) return false;
      } else {
        for (const double m : values_)
          if (!(m > 0.0)) return false;
      }
    }
    if (!(zero == 0.0)) return false;
    if (factors_) {
      factors_->solve(a);
      for (std::size_t i = 0; i < right_.size(); ++i) zero += a[i] - a[i];
    }
    return zero == 0.0;
  }

  template <class Run>
  bool still_holds(const Run& run) {
    return lines_.still_holds(run);
  }

 private:
  bool factored() {
    return factors_->compute([&](std::size_t k) { return values_[k]; }, singular_pivot<double>(static_cast<Eigen::Index>(right_.size())));
  }

  TracedLines<Number> lines_;
  std::shared_ptr<const formula::LineEvaluator> table_;
  std::vector<int> right_, zdot_, mass_;
  std::optional<PatternFactors<Number>> factors_;
  std::vector<double> values_;
  bool is_known_ = false;
};

/// A lock that is held for some nanoseconds, or once for what is derived, and hardly ever waited for.
class ShortLock {
 public:
  void lock() noexcept {
    while (is_held_.test_and_set(std::memory_order_acquire)) is_held_.wait(true, std::memory_order_relaxed);
  }
  void unlock() noexcept {
    is_held_.clear(std::memory_order_release);
    is_held_.notify_one();
  }

 private:
  std::atomic_flag is_held_;
};

/// Traced motions that a form keeps, one for each combination of phases: made when they are first asked for, and again where a method begins and the functors
/// are others by then.
///
/// Nothing is there where they are no formulas, or where it does not pay. Copies share what one of them has made, and work by themselves; each is asked by
/// one thread at a time, others wait.
template <class Motion>
class KeptMotion {
 public:
  using Phases = std::span<const double>;

  KeptMotion() = default;
  KeptMotion(const KeptMotion& other) : made_(other.made()) {}
  KeptMotion& operator=(const KeptMotion& other) {
    auto theirs = other.made();
    const std::lock_guard lock(lock_);
    made_ = std::move(theirs);
    own_.clear();
    return *this;
  }

  /// use(motion), which says whether it did; false where there is none.
  template <class Make, class Use>
  bool use(Phases phases, const Make& make, const Use& use) const {
    const std::lock_guard lock(lock_);
    InPhases* own = in(own_, phases);
    if (!made_) made_ = std::make_shared<Made>();
    if (!own) own = &added(own_, made_->made_or(phases, make));
    return own->motion && use(*own->motion);
  }
  template <class Make, class Use>
  bool use(const Make& make, const Use& use) const {
    return this->use({}, make, use);
  }

  /// Looks whether the functors are the same still; run(motion) runs them. If not, all is forgotten.
  template <class Run>
  void renew(const Run& run) {
    const std::lock_guard lock(lock_);
    if (!made_) return;
    made_->add_missing(own_);
    try {
      if (std::ranges::all_of(own_, [&](InPhases& own) { return own.motion && own.motion->still_holds(run); })) return;
    } catch (...) {  // no formulas any more
    }
    made_.reset();
    own_.clear();
  }

 private:
  struct InPhases {
    std::vector<double> phases;
    std::unique_ptr<Motion> motion;

    InPhases copy() const { return {phases, motion ? std::make_unique<Motion>(*motion) : nullptr}; }
  };
  static constexpr std::size_t most = 16;

  static InPhases* in(std::vector<InPhases>& all, Phases phases) {
    for (InPhases& one : all)
      if (std::ranges::equal(one.phases, phases)) return &one;
    return nullptr;
  }
  static InPhases& added(std::vector<InPhases>& all, InPhases one) {
    if (all.size() == most) all.erase(all.begin());
    all.push_back(std::move(one));
    return all.back();
  }

  // What copies share.
  class Made {
   public:
    template <class Make>
    InPhases made_or(Phases phases, const Make& make) {
      const std::lock_guard lock(mutex_);
      if (const InPhases* one = in(all_, phases)) return one->copy();
      InPhases& made = added(all_, {{phases.begin(), phases.end()}, {}});
      try {
        made.motion.reset(new Motion(make()));
        if (!made.motion->is_known()) made.motion.reset();
      } catch (...) {  // what functors throw they throw again, where the general way asks them
        made.motion.reset();
      }
      return made.copy();
    }
    void add_missing(std::vector<InPhases>& own) {
      const std::lock_guard lock(mutex_);
      for (const InPhases& one : all_)
        if (!in(own, one.phases)) added(own, one.copy());
    }

   private:
    std::mutex mutex_;
    std::vector<InPhases> all_;
  };
  std::shared_ptr<Made> made() const {
    const std::lock_guard lock(lock_);
    return made_;
  }

  mutable ShortLock lock_;
  mutable std::shared_ptr<Made> made_;  // null until the first use
  mutable std::vector<InPhases> own_;
};

// Which systems are traced.
template <class Sys>
concept TracedSystem = Sys::dof_at_compile_time == Dynamic && Sys::inertia == Inertia::positive_definite &&
                       RecordableEnergies<typename Sys::EnergiesType, Dynamic>;

template <class Sys>
  requires RecordableEnergies<typename Sys::EnergiesType, Sys::dof_at_compile_time>
TracedEquations<> traced_equations(const Sys& system) {
  TracedEquations<> e(system.dof(), 0);
  e.begins = machine_code_begins(system.kept_lines()->by());
  run_energies<Sys::dof_at_compile_time>(e.motion, system.energies());
  e.derive(false, {});
  return e;
}

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template TracedLines<double>::TracedLines(TracedEquations<double>);
extern template std::vector<int> TracedLines<double>::numbers(const std::vector<int>&) const;
extern template std::shared_ptr<const formula::LineEvaluator> TracedLines<double>::written(const std::vector<int>&);
extern template TracedLines<double>::Solved TracedLines<double>::solved(const std::vector<int>&, const std::vector<int>&, const std::vector<int>&,
                                                                        const std::vector<int>&, double, std::size_t);
extern template TracedLines<double>::Solved TracedLines<double>::solved_in_order(const std::vector<int>&, const std::vector<int>&, const std::vector<int>&,
                                                                                 std::size_t);
extern template TracedMotion<double>::TracedMotion(TracedEquations<double>);
}  // namespace qdot::detail
#else
#include "qdot/mechanics/derive/traced_lines.hpp"
#endif
