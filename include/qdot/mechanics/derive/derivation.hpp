#pragma once
// SPDX-License-Identifier: MIT
//
// One derivation of T and V: what was recorded, the lines that came of it, and where and for which functors they hold.
//
// A derivation holds as long as T and V are the same formulas. That is checked by a hash of what they do (ad/formula/hashed.hpp): another captured number,
// sign or threshold gives another.
//
// Functors that compare numbers are derived for one branch at a time. The recording knows the state and notes the guards on which its branch depends
// (ad/formula/branches.hpp); their sides are lines, and the same answers to comparisons lead the hash through the same branch.

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "qdot/ad/formula/hashed.hpp"
#include "qdot/mechanics/derive/lines.hpp"

namespace qdot::detail {

enum class Assumptions { refused, checked };  // that a number is never another, where functors ask whether they are equal
// What was recorded, T, V and perhaps forces, what has been derived of it, and its lines.
template <class Number = double>
struct Derivation {
  RecordedMotion recorded;
  DerivedJacobian derived;
  std::optional<DerivedLineWriter<Number>> writer;
  DerivedLines lines;

  void derive(RecordedMotion motion, const formula::Branches* branches = nullptr, Assumptions assumptions = Assumptions::refused,
              std::size_t parameters = 0);
  void derive_slopes();
};

template <class Number>
[[gnu::cold]] void Derivation<Number>::derive(RecordedMotion motion, const formula::Branches* branches, Assumptions assumptions, std::size_t parameters) {
  if (assumptions == Assumptions::refused && !motion.recording.assumptions.empty()) return;
  recorded = std::move(motion);
  GraphEquations e = equations_by_graph(recorded.recording.graph, static_cast<int>(recorded.q.size()), recorded.returned[0], recorded.returned[1]);
  for (std::size_t i = 0; i < recorded.q.size() && recorded.returned.size() > 2; ++i)  // forces
    e.right[i] = recorded.recording.graph.sum(e.right[i], recorded.returned[2 + i]);
  derived = {std::move(e.mass), std::move(e.right), {}};
  writer.emplace(recorded.recording.graph, recorded.q.size(), std::size_t(4), parameters);
  std::vector<int> nonzero;
  for (const auto& assumption : recorded.recording.assumptions) nonzero.push_back(assumption.node);
  writer->write_equations(derived, branches ? branches->met : std::vector<formula::Guard>(), nonzero, lines);
}

template <class Number>
[[gnu::cold]] void Derivation<Number>::derive_slopes() {
  differentiate(recorded.recording.graph, static_cast<int>(recorded.q.size()), derived);
  writer->write_slopes(derived, lines);
}

#ifdef QDOT_COMPILED
extern template struct Derivation<double>;
#endif

/// Hashes of T, of V and of what they compare; nothing where they are no formulas on a branch.
using Fingerprint = std::optional<std::array<std::uint64_t, 3>>;

// The fingerprint of energies, on the branch with these answers.
template <int n, class E>
[[gnu::noinline]] Fingerprint fingerprint(const E& e, int size, const std::vector<formula::Guard>* answers = nullptr) {
  using S = formula::Hashed;
  formula::HashedComparisons comparisons{answers};
  Vector<S, n> q(size), qdot(size);
  for (int i = 0; i < size; ++i) {
    q.data()[i] = S(comparisons, i);
    qdot.data()[i] = S(comparisons, size + i);
  }
  const S t(comparisons, 2 * size);
  try {
    const S T = kinetic<n>(e, q, qdot, t), V = potential<n>(e, q, t);
    if (!answers || comparisons.next == answers->size()) return std::array{T.bits(), V.bits(), comparisons.hash};
  } catch (...) {  // what functors throw they throw again, where they are asked for values
  }
  return std::nullopt;
}

// The number of coordinates at a state.
template <int n>
constexpr int size_at(const AtState& at) {
  return n == Dynamic ? at.size : n;
}

/// A derivation, where it holds, and slopes on request. May be asked by several threads.
class KeptDerivation {
 public:
  explicit KeptDerivation(By by = By::fastest) { derivation_.lines.begins = machine_code_begins(by); }

  /// Of functors without comparisons.
  template <int n, class E>
  void derive(const E& e, int size) {
    size_ = size;
    try {
      derivation_.derive(recorded_motion<n>(e, size));
      print_ = fingerprint<n>(e, size);
    } catch (...) {  // likewise
    }
  }
  /// Of the branch at a state.
  template <int n, class E>
  [[gnu::cold, gnu::noinline]] void derive_branch(const E& e, const AtState& at) {
    size_ = size_at<n>(at);
    branches_ = std::make_unique<formula::Branches>();
    branches_->variables.resize(static_cast<std::size_t>(2 * size_ + 1));
    copy_state(at, branches_->variables.data());
    try {
      RecordedMotion recorded = recorded_motion<n>(e, size_, branches_.get());
      if (branches_->read_values) return;
      derivation_.derive(std::move(recorded), branches_.get());
      write_guards(static_cast<std::size_t>(size_));
      print_ = fingerprint<n>(e, size_, &branches_->met);
    } catch (...) {  // likewise
    }
  }

  const Fingerprint& print() const { return print_; }
  /// The lines; null where T and V are no formulas, or too long.
  const DerivedLines* lines() const { return derivation_.lines.exist() ? &derivation_.lines : nullptr; }
  /// The lines with slopes; null where these are too long.
  const DerivedLines* lines_with_slopes() {
    if (!lines()) return nullptr;
    if (!is_asked_for_slopes_.load(std::memory_order_acquire)) {
      const std::lock_guard lock(mutex_);
      if (!is_asked_for_slopes_.load(std::memory_order_relaxed)) derivation_.derive_slopes();
      is_asked_for_slopes_.store(true, std::memory_order_release);
    }
    return derivation_.lines.have_slopes() ? &derivation_.lines : nullptr;
  }

  /// The lines with those that go on to q̈ for lanes; null where there are none.
  const DerivedLines* lines_for_lanes() {
    if (!lines()) return nullptr;
    if (size_ > straight_line_limit && !is_asked_for_lanes_.load(std::memory_order_acquire)) {
      const std::lock_guard lock(mutex_);
      if (!is_asked_for_lanes_.load(std::memory_order_relaxed)) derivation_.writer->write_solutions(derivation_.lines);
      is_asked_for_lanes_.store(true, std::memory_order_release);
    }
    return derivation_.lines.solution[0].accelerations.empty() ? nullptr : &derivation_.lines;
  }

  /// Whether a state is on the branch that was recorded.
  template <int n>
  bool holds_at(const AtState& at) const {
    if (guards_.empty()) return true;
    double x[DerivedLines::most(n == Dynamic ? static_cast<std::size_t>(block_limit<n>) : static_cast<std::size_t>(n))];
    copy_state(at, x);
    guard_lines_(x);
    for (std::size_t i = 0; i < guards_.size(); ++i)
      if (!branches_->met[i].has(x[guards_[i]])) return false;
    return true;
  }
  /// Whether the functors are those that were derived.
  template <int n, class E>
  bool is_of(const E& e) const {
    return print_ && fingerprint<n>(e, size_, branches_ ? &branches_->met : nullptr) == print_;
  }

 private:
  void copy_state(const AtState& at, double* x) const {
    std::copy_n(at.q, size_, x);
    std::copy_n(at.qdot, size_, x + size_);
    x[2 * size_] = at.t;
  }
  void write_guards(std::size_t n) {
    if (!lines() || branches_->met.empty()) return;
    std::vector<int> nodes;
    for (const formula::Guard& guard : branches_->met) nodes.push_back(guard.node);
    formula::LineTable table;
    formula::LineWriter<double> writer(derivation_.recorded.recording.graph, 2 * n + 1);
    writer.write(nodes, table);
    table.lines.push_back(formula::Line{});
    guard_lines_.set(std::move(table), writer.count(), derivation_.lines.begins);
    guards_ = writer.numbers(nodes);
    guard_lines_.add_read(guards_);
    if (writer.count() > DerivedLines::most(n)) derivation_.lines = {};
  }

  int size_ = 0;
  Fingerprint print_{};
  std::unique_ptr<formula::Branches> branches_{};
  formula::LineEvaluator guard_lines_{};
  std::vector<int> guards_{};
  std::mutex mutex_{};
  std::atomic<bool> is_asked_for_slopes_{false}, is_asked_for_lanes_{false};
  Derivation<> derivation_{};
};

}  // namespace qdot::detail
