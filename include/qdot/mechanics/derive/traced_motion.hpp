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
// An irregular case, a pivot that is too small or a number that is not finite, is left to the general evaluation, which handles and names it. An object
// has numbers of its own, so one thread at a time may ask it; copies are independent and share the lines.

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
#include "qdot/mechanics/derive/recordable_form.hpp"
#include "qdot/mechanics/derive/traced.hpp"
#include "qdot/mechanics/derive/traced_equations.hpp"
#include "qdot/mechanics/equations/solve.hpp"
#include "qdot/mechanics/equations/sparse_factors.hpp"

namespace qdot::formula {
template <class Coefficient>
class LineWriter;  // of ad/formula/line_writer.hpp
}  // namespace qdot::formula

namespace qdot::detail {

struct ConstrainedAcceleration;  // of mechanics/derive/solution_lines.hpp

inline void append(std::vector<int>& all, const std::vector<int>& more) { all.insert(all.end(), more.begin(), more.end()); }

// The rows of J, one behind the other; −1 is zero.
[[gnu::cold]] inline std::vector<int> rows_of_constraints(const SparseEntries& J, std::size_t n) {
  std::vector<int> all(J.rows() * n, -1);
  for (std::size_t k = 0; k < J.rows(); ++k)
    for (const SparseEntries::Entry& e : J.row(k)) all[k * n + static_cast<std::size_t>(e.column)] = e.what;
  return all;
}

// The lower triangle of M, row by row; −1 is zero.
[[gnu::cold]] inline std::vector<int> lower_triangle(const SparseEntries& mass) {
  std::vector<int> all;
  for (std::size_t i = 0; i < mass.rows(); ++i)
    for (int j = 0; j <= static_cast<int>(i); ++j) {
      const auto found = std::ranges::find(mass.row(i), j, &SparseEntries::Entry::column);
      all.push_back(found == mass.row(i).end() ? -1 : found->what);
    }
  return all;
}

/// Lines of a traced object, which copies share, and the numbers on which they are carried out.
template <class Number = double>
class TracedLines {
 public:
  explicit TracedLines(TracedEquations<Number> equations);

  const TracedEquations<Number>& equations() const { return shared_->equations; }
  TracedEquations<Number>& equations() { return shared_->equations; }
  std::shared_ptr<const TracedEquations<Number>> shared_equations() const { return {shared_, &shared_->equations}; }

  /// Lines of what `outputs` need beyond what is written already. All are written before the first evaluation.
  std::shared_ptr<const formula::LineEvaluator> written(const std::vector<int>& outputs);
  /// Lines of x = M⁻¹ b, of M⁻¹ times each column, which may ask for x as the variables q̈, and of `others`, which may not. Nothing where M has a zero on
  /// its diagonal, a constant pivot that is not above a fraction `least` of it, or more than `most` numbers. In the lists −1 stands for zero; of columns one
  /// stands behind the other. These lines have their constants, and go with any vector of so many numbers.
  struct Solved {
    std::shared_ptr<formula::LineEvaluator> lines;
    std::vector<int> x, columns;              ///< numbers of the solutions
    std::vector<std::pair<int, int>> pivots, row_pivots;  ///< numbers of which the first of each pair must be above a fraction of the second
    std::vector<std::pair<int, Requirement>> required{};
    std::vector<formula::Guard> sides{};  ///< the guards of a branch, with numbers for nodes

    /// Carries the lines out; false where the functors have no value there, or a pivot is not above its limit.
    [[gnu::always_inline]] bool evaluate(double* numbers, const LimitsOfPivots& limits) const {
      (*lines)(numbers);
      const bool is_here = is_on_branch(numbers);
      return has_values(numbers, limits) && is_here;
    }
    /// Whether functors have values at the numbers of the last evaluation, on their branch or as it goes on beyond its guards, and pivots are large enough.
    [[gnu::always_inline]] bool has_values(const double* numbers, const LimitsOfPivots& limits) const {
      bool good = true;
      for (const auto& [number, requirement] : required) good &= requirement.holds(numbers[number]);
      for (const auto& [pivot, whole] : pivots) good &= numbers[pivot] > limits.singular * numbers[whole];
      for (const auto& [pivot, whole] : row_pivots) good &= numbers[pivot] > limits.dependent * numbers[whole];
      return good;
    }
    /// Whether the numbers of the last evaluation are on the branch that was recorded.
    [[gnu::always_inline]] bool is_on_branch(const double* numbers) const {
      bool all = true;
      for (const formula::Guard& side : sides) all &= side.has(numbers[side.node]);
      return all;
    }
  };
  Solved solved(const std::vector<int>& mass, const std::vector<int>& b, const std::vector<int>& columns, const std::vector<int>& others, double least,
                std::size_t most);
  /// Lines of q̈ and ż, with the elimination of M and of the rows of constraints; and of λ, as columns.
  Solved solved_rates(const LimitsOfPivots& limits, std::size_t most, bool with_multipliers = false);
  /// Lines of δq = −M⁻¹Jᵀ (J M⁻¹ Jᵀ)⁻¹ φ, of δq̇ for J q̇ + ∂φ/∂t in the place of φ, as columns, and of φ, J q̇ + ∂φ/∂t and J.
  Solved solved_projection(const LimitsOfPivots& limits, std::size_t most);
  /// Whether the functors are what was traced.
  bool still_holds(const RecordableForm& form) {
    const std::lock_guard lock(shared_->again);
    return is_unchanged(shared_->equations.motion, form);
  }
  /// Where the values of nodes are.
  std::vector<int> numbers(const std::vector<int>& nodes) const;

  /// Nodes that are looked at: those of requirements, then of guards.
  std::vector<int> required() const {
    std::vector<int> nodes;
    for (const Requirement& r : equations().requirements) nodes.push_back(r.node);
    for (const formula::Guard& g : equations().guards) nodes.push_back(g.node);
    return nodes;
  }
  /// Whether the functors have values where the numbers are.
  bool hold_requirements() {
    const std::vector<Requirement>& all = equations().requirements;
    if (required_.size() != all.size()) {
      required_ = numbers(required());
      required_.resize(all.size());
    }
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
  Solved solved_in_graph(ConstrainedAcceleration found, const std::vector<int>& columns, const std::vector<int>& others, const LimitsOfPivots& limits,
                         std::size_t most);
  Solved evaluated(formula::LineTable table, Solved found, const std::vector<int>& others, std::size_t most);
  std::vector<std::pair<int, int>> numbers_of_pivots(std::vector<std::pair<int, int>> nodes) const;
  bool keep_variable(std::vector<std::pair<int, int>>& pivots, double least);

  std::shared_ptr<Shared> shared_;
  std::vector<double> x_;
  std::vector<int> required_;
};

/// q̈ and ż of a system, or of a scene without constraints.
template <class Number = double>
class TracedMotion final : public TracedRates {
 public:
  explicit TracedMotion(TracedEquations<Number> equations);

  bool is_known() const override { return is_known_; }
  std::unique_ptr<Traced> copy() const override { return std::make_unique<TracedMotion>(*this); }
  bool still_holds(const RecordableForm& form) override { return lines_.still_holds(form); }
  bool mass_is_constant() const override { return lines_.equations().mass_is_constant; }
  bool are_native() const override { return lines_.are_native(); }
  bool are_long() const override { return lines_.are_long(); }

  bool write(const double* q, const double* qdot, double t, const double* z, double* a, double* zdot) override {
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

/// A recording of a form, in the phases of what switches; on the branch of a state where one is given.
[[gnu::cold]] inline TracedEquations<double> recorded_form(const RecordableForm& form, std::span<const double> phases, std::vector<char>& holonomic,
                                                           formula::Branches* branches = nullptr) {
  TracedEquations<double> e(form.dof, form.states);
  e.begins = machine_code_begins(form.by);
  e.motion.phases.assign(phases.begin(), phases.end());
  e.motion.recording.branches = branches;
  form.run(form.form, e.motion, &holonomic);
  e.motion.recording.branches = nullptr;
  return e;
}
/// The equations of a form.
[[gnu::cold]] inline TracedEquations<double> traced_equations(const RecordableForm& form, std::span<const double> phases = {}) {
  std::vector<char> holonomic;
  TracedEquations<double> e = recorded_form(form, phases, holonomic);
  e.derive(form.has_forces, holonomic);
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
extern template TracedLines<double>::Solved TracedLines<double>::solved_rates(const LimitsOfPivots&, std::size_t, bool);
extern template TracedLines<double>::Solved TracedLines<double>::solved_projection(const LimitsOfPivots&, std::size_t);
extern template TracedMotion<double>::TracedMotion(TracedEquations<double>);
}  // namespace qdot::detail
#else
#include "qdot/mechanics/derive/traced_motion.ipp"
#endif
