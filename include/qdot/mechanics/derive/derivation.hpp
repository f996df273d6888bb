#pragma once
// SPDX-License-Identifier: MIT
//
// One derivation of T and V: what was recorded, the lines that came of it, and where and for which functors they hold.
//
// A derivation holds as long as T and V compute the same. That is checked by T and V as numbers at a probe state: the same functors give the same bits
// there, and another captured number gives others.
//
// Functors that compare numbers are derived for one branch at a time. The recording knows the state and notes the guards on which its branch depends
// (ad/formula/branches.hpp). The probe of such a derivation lies on its branch; since a threshold may change that no formula of the branch contains, T and V
// are compared with their lines at the state as well.

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "qdot/mechanics/derive/lines.hpp"

namespace qdot::detail {

// What was recorded, what has been derived of it, and its lines.
template <class Number = double>
struct Derivation {
  RecordedMotion recorded;
  DerivedJacobian derived;
  std::optional<DerivedLineWriter<Number>> writer;
  DerivedLines lines;

  void derive(RecordedMotion motion, const formula::Branches* branches = nullptr);
  void derive_slopes();
};

template <class Number>
[[gnu::cold]] void Derivation<Number>::derive(RecordedMotion motion, const formula::Branches* branches) {
  if (!motion.recording.assumptions.empty()) return;
  recorded = std::move(motion);
  GraphEquations e = equations_by_graph(recorded.recording.graph, static_cast<int>(recorded.q.size()), recorded.returned[0], recorded.returned[1]);
  derived = {std::move(e.mass), std::move(e.right), {}};
  writer.emplace(recorded.recording.graph, recorded.q.size(), std::size_t(4));
  writer->write_equations(derived, branches ? branches->met : std::vector<formula::Guard>(), lines);
}

template <class Number>
[[gnu::cold]] void Derivation<Number>::derive_slopes() {
  differentiate(recorded.recording.graph, static_cast<int>(recorded.q.size()), derived);
  writer->write_slopes(derived, lines);
}

#ifdef QDOT_COMPILED
extern template struct Derivation<double>;
#endif

/// T and V at a probe state, bit by bit; nothing where they have no finite value there.
using Fingerprint = std::optional<std::array<std::uint64_t, 2>>;

// The largest number of coordinates that may have lines.
inline constexpr int most_with_lines = 64;

// Coordinates in (0.2, 1.2), velocities in (-0.5, 0.5) and a time, without order: multiples of the golden section.
constexpr double probe_number(int i, double first) {
  const double x = 0.6180339887498949 * (i + 1);
  return x - static_cast<double>(static_cast<long>(x)) + first;
}
constexpr void write_probe(int n, double* x) {
  for (int i = 0; i < 2 * n + 1; ++i) x[i] = probe_number(i, i < n ? 0.2 : -0.5);
}
template <int n>
inline constexpr std::array<double, 2 * n + 1> probe_state = [] {
  std::array<double, 2 * n + 1> x{};
  write_probe(n, x.data());
  return x;
}();

// The number of coordinates at a state.
template <int n>
constexpr int size_at(const AtState& at) {
  return n == Dynamic ? at.size : n;
}
// How many numbers the lines of n coordinates may have.
template <int n>
inline constexpr std::size_t most_numbers = DerivedLines::most(n == Dynamic ? most_with_lines : static_cast<std::size_t>(n));

// A plain number, for functors that compile for numbers with derivatives only.
struct OfProbe;
using Value = Dual<double, 0, OfProbe>;

// T and V at x = [q, q̇, t].
template <int n, class E>
[[gnu::noinline]] std::array<double, 2> energies_at(const E& e, int size, const double* x) {
  Vector<Value, n> q(size), qdot(size);
  for (int i = 0; i < size; ++i) {
    q.data()[i].value = x[i];
    qdot.data()[i].value = x[size + i];
  }
  const Value t(x[2 * size]);
  return {kinetic<n>(e, q, qdot, t).value, potential<n>(e, q, t).value};
}
template <int n, class E>
Fingerprint fingerprint(const E& e, int size, const double* probe) {
  try {
    const auto [T, V] = energies_at<n>(e, size, probe);
    if (std::isfinite(T + V)) return std::array{std::bit_cast<std::uint64_t>(T), std::bit_cast<std::uint64_t>(V)};
  } catch (...) {  // what functors throw they throw again, where they are asked for values
  }
  return std::nullopt;
}
// The same at the usual probe.
template <int n, class E>
Fingerprint fingerprint(const E& e, int size) {
  if constexpr (n == Dynamic) {
    double probe[2 * most_with_lines + 1];
    write_probe(size, probe);
    return fingerprint<n>(e, size, probe);
  } else {
    return fingerprint<n>(e, size, probe_state<n>.data());
  }
}

/// A derivation, where it holds, and slopes on request. May be asked by several threads.
class KeptDerivation {
 public:
  /// Of functors without comparisons, which are known again by their fingerprint.
  template <int n, class E>
  void derive(const E& e, int size, const Fingerprint& print) {
    size_ = size;
    print_ = print;
    try {
      derivation_.derive(recorded_motion<n>(e, size));
    } catch (...) {  // likewise
    }
  }
  /// Of the branch at a state.
  template <int n, class E>
  [[gnu::cold, gnu::noinline]] void derive_branch(const E& e, const AtState& at) {
    branches_ = std::make_unique<formula::Branches>();
    size_ = size_at<n>(at);
    branches_->variables.resize(static_cast<std::size_t>(2 * size_ + 1));
    copy_state(at, branches_->variables.data());
    try {
      RecordedMotion recorded = recorded_motion<n>(e, size_, branches_.get());
      if (!branches_->read_values) derivation_.derive(std::move(recorded), branches_.get());
    } catch (...) {  // likewise
    }
    if (!lines()) return;
    write_guards(static_cast<std::size_t>(size_));
    find_probe<n>(e);
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

  /// Whether a state is on the branch that was recorded.
  template <int n>
  bool holds_at(const AtState& at) const {
    double x[most_numbers<n>];
    copy_state(at, x);
    return holds_on(x);
  }

  /// Whether a state is on this branch and the functors are still those of the branch, at the probe and at the state.
  template <int n, class E>
  bool agrees_at(const E& e, const AtState& at) {
    double x[most_numbers<n>];
    copy_state(at, x);
    if (!print_ || !holds_on(x) || fingerprint<n>(e, size_, probe_.data()) != print_) return false;
    const std::array<double, 2> found = energies_at<n>(e, size_, x);
    const auto agrees = [&](std::size_t i) { return std::abs(found[i] - x[energies_[i]]) <= 1e-12 * std::abs(found[i]); };  // sums of some 1000 roundings
    return (agrees(0) && agrees(1)) || is_recorded_again<n>(e);
  }

  /// Whether the functors are still those that were derived.
  template <int n, class E>
  [[gnu::cold, gnu::noinline]] bool still_holds(const E& e) {
    if (!lines()) return true;
    if (print_ && !branches_) return fingerprint<n>(e, size_) == print_;
    return is_recorded_again<n>(e);
  }

 private:
  void copy_state(const AtState& at, double* x) const {
    std::copy_n(at.q, size_, x);
    std::copy_n(at.qdot, size_, x + size_);
    x[2 * size_] = at.t;
  }
  // x = [q, q̇, t], and room for the numbers of lines.
  bool holds_on(double* x) const {
    guard_lines_(x);
    for (std::size_t i = 0; i < guards_.size(); ++i)
      if (!branches_->met[i].has(x[guards_[i]])) return false;
    return true;
  }

  // Lines of the guards, T and V.
  void write_guards(std::size_t n) {
    std::vector<int> nodes;
    for (const formula::Guard& guard : branches_->met) nodes.push_back(guard.node);
    nodes.insert(nodes.end(), derivation_.recorded.returned.begin(), derivation_.recorded.returned.begin() + 2);
    formula::LineTable table;
    formula::LineWriter<double> writer(derivation_.recorded.recording.graph, 2 * n + 1);
    writer.write(nodes, table);
    table.lines.push_back(formula::Line{});
    guard_lines_.set(std::move(table), writer.count());
    guards_ = writer.numbers(nodes);
    guard_lines_.add_read(guards_);
    energies_ = {guards_[guards_.size() - 2], guards_.back()};
    guards_.resize(guards_.size() - 2);
    if (writer.count() > DerivedLines::most(n)) derivation_.lines = {};
  }

  // A probe on the branch: the usual one, or one nearer and nearer to the state that was recorded.
  template <int n, class E>
  void find_probe(const E& e) {
    if (!lines()) return;
    constexpr int halvings = 20;
    double x[most_numbers<n>];
    probe_.resize(branches_->variables.size());
    write_probe(size_, probe_.data());
    const std::vector<double> usual = probe_;
    for (int k = 0; k <= halvings && !print_; ++k) {
      for (std::size_t i = 0; i < probe_.size(); ++i) x[i] = probe_[i] = branches_->variables[i] + std::ldexp(usual[i] - branches_->variables[i], -k);
      if (holds_on(x)) print_ = fingerprint<n>(e, size_, probe_.data());
    }
  }

  // Whether T and V, recorded once more with the same answers to comparisons, are the same formulas with the same guards.
  template <int n, class E>
  [[gnu::cold, gnu::noinline]] bool is_recorded_again(const E& e) {
    const std::lock_guard lock(mutex_);
    const auto run = [&](RecordedMotion& m) { run_energies<n>(m, e); };
    if (!branches_) return is_unchanged(derivation_.recorded, run);
    const std::vector<formula::Guard> met = branches_->met;
    branches_->answers = &met;
    branches_->met.clear();
    bool same = is_unchanged(derivation_.recorded, run) && branches_->met.size() == met.size();
    for (std::size_t i = 0; same && i < met.size(); ++i) same = met[i].is_same(branches_->met[i]);
    branches_->answers = nullptr;
    branches_->met = met;
    return same;
  }

  int size_ = 0;
  Fingerprint print_{};
  std::vector<double> probe_{};
  std::unique_ptr<formula::Branches> branches_{};
  formula::LineEvaluator guard_lines_{};
  std::vector<int> guards_{};
  std::array<int, 2> energies_{};
  std::mutex mutex_{};
  std::atomic<bool> is_asked_for_slopes_{false};
  Derivation<> derivation_{};
};

}  // namespace qdot::detail
