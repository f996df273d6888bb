#pragma once
// SPDX-License-Identifier: MIT
//
// Steps are looked at along the guards of their branch (integrate/watch/branch_watch.hpp says what is looked for).
//
// Programs that link qdot::compiled do not read this header: the library has it.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "qdot/ad/formula/interval.hpp"
#include "qdot/integrate/steps/neighbouring_branches.hpp"
#include "qdot/integrate/watch/branch_crossing.hpp"
#include "qdot/integrate/watch/sides_of_branch.hpp"
#include "qdot/integrate/watch/watched_form.hpp"

namespace qdot::detail {

/// Looks at the steps of a run.
template <class Number = double>
class BranchSteps {
 public:
  BranchSteps(const WatchedForm& form, double rtol) : form_(form), size_(form.size()), dof_(form.dof()), rtol_(rtol) {}

  void forget() { here_.reset(), goes_on_from_.reset(); }
  Passage passage(const Clock& clock, const PolynomialView& step, double from, double to);
  /// Where a step that was held on the branch of its beginning leaves it.
  Passage held(const Clock& clock, const PolynomialView& step, double from, double to);
  /// What is met where a step begins that lies on one branch.
  Passage beginning(const Clock& clock, const PolynomialView& step, double from, double to);

 private:
  static constexpr int places = 16, halvings = 30, finer = 24, most_retaken = 1000;
  static constexpr double noise = 1e-12;  // of what a guard is along a step

  // What the state is at a fraction of the step.
  void move_to(double fraction) {
    const double elapsed = fraction == 1.0 ? to_ : from_ + fraction * (to_ - from_);
    y_all_.resize(step_.size);
    step_.at(elapsed, y_all_);
    y_ = y_all_.head(size_);
    t_ = clock_.shown(elapsed);
  }
  int left_at(SidesOfBranch<>& sides, double fraction) { return move_to(fraction), sides.move_to(dof_, t_, y_); }
  // As left_at() of a place, and notes how far inside of each guard it is.
  int left_at_place(int k) {
    const int left = left_at(*here_, fraction_of(k));
    const std::size_t guards = here_->branch().branches.met.size();
    for (std::size_t i = 0; i < guards; ++i) inside_[static_cast<std::size_t>(k) * guards + i] = here_->inside(i);
    return left;
  }
  std::optional<Passage> undecided_at_place(int k, int left) {
    auto unknown = left >= 0 ? undecided(*here_, left) : std::nullopt;
    if (!unknown) return std::nullopt;
    return Passage{{}, std::move(unknown), from_ + fraction_of(std::max(k - 1, 0)) * (to_ - from_)};
  }
  std::unique_ptr<SidesOfBranch<>> sides_at(double fraction) {
    return move_to(fraction), std::make_unique<SidesOfBranch<>>(recorded_branch(dof_, t_, y_, [&](RecordedBranch& branch) { form_.record_branch(branch); }));
  }
  // Fractions between which sides end: they hold at the first, and not at the second.
  struct Edge {
    double holds, is_left;
  };
  Edge edge(SidesOfBranch<>& sides, Edge between, int times = halvings) {
    for (int k = 0; k < times; ++k) {
      const double middle = 0.5 * (between.holds + between.is_left);
      (left_at(sides, middle) >= 0 ? between.is_left : between.holds) = middle;
    }
    return between;
  }

  bool stays_here();
  [[gnu::cold]] std::optional<Failure> undecided(SidesOfBranch<>& sides, int guard) const;
  struct Bands {
    double rounding, hidden;
  };
  [[gnu::cold]] Bands bands(std::size_t guard);
  [[gnu::cold]] std::optional<double> grazed(bool is_held = false);
  [[gnu::cold]] std::optional<int> first_beyond();
  struct Ahead {
    double fraction;
    std::unique_ptr<SidesOfBranch<>> sides;
  };
  [[gnu::cold]] Ahead behind(const Edge& own);
  // Of a step that is held what lies before its branch begins is not looked at.
  double fraction_of(int place) const { return first_fraction_ + (1.0 - first_fraction_) * place / places; }
  void take_sizes();
  [[gnu::cold]] void take_energies(RecordedBranch& branch, const std::vector<double>& at);
  [[gnu::cold]] bool has_rates(const Eigen::VectorXd& y, Eigen::VectorXd& out) const;
  [[gnu::cold]] std::optional<Failure> trouble_at_start();
  [[gnu::cold]] std::optional<Failure> trouble_between(SidesOfBranch<>& before, SidesOfBranch<>& behind, Edge between, bool is_start);

  const WatchedForm& form_;
  Eigen::Index size_, dof_;
  double rtol_;
  long retaken_ = 0;
  SizesOfMotion sizes_{};
  std::unique_ptr<SidesOfBranch<>> here_{};
  Clock clock_{};
  PolynomialView step_{};
  double from_ = 0.0, to_ = 0.0, t_ = 0.0;  // of the step, and of the place last looked at
  Eigen::VectorXd y_{}, y_all_{}, rates_before_{}, rates_behind_{};
  std::vector<double> inside_{};   // of each guard, at each place
  std::optional<double> goes_on_from_{};  // where the branch that is held begins, when so much has elapsed
  double first_fraction_ = 0.0;
  std::vector<Interval> bounds_{};
};

// Whether bounds of the step's polynomial show that no guard is reached: then there is nothing to be looked for.
template <class Number>
bool BranchSteps<Number>::stays_here() {
  const double s = std::max(std::abs(from_ - step_.origin), std::abs(to_ - step_.origin)) / std::abs(step_.scale);
  bounds_.clear();
  for (Eigen::Index i = 0; i < size_; ++i) {  // |y − c₀| ≤ Σ |c_k| s^k, and a little for rounding
    double reach = 0.0;
    for (int k = step_.degree; k > 0; --k) reach = (reach + std::abs(step_.coefficients[k * step_.size + i])) * s;
    const double middle = step_.coefficients[i];
    bounds_.push_back(Interval::around(middle - 1.001 * reach, middle + 1.001 * reach));
  }
  bounds_.insert(bounds_.begin() + 2 * dof_, Interval::around(clock_.shown(from_), clock_.shown(to_)));
  return here_->hold_within(bounds_);
}

// A comparison with NaN has no side.
template <class Number>
std::optional<Failure> BranchSteps<Number>::undecided(SidesOfBranch<>& sides, int guard) const {
  std::string what = sides.branch().branches.undecided;
  if (guard >= 0) {
    const formula::Guard& it = sides.branch().branches.met[static_cast<std::size_t>(guard)];
    if (!std::isnan(sides.value(it))) return std::nullopt;
    what = it.what;
  }
  if (what.empty()) return std::nullopt;
  return Failure{Outcome::non_finite, sentence({what, " is asked about NaN at t = ", {t_, 10}, ", which is on no side; compare what has a value there"})};
}

// How much of a guard rounding makes, and how much the tolerances hide, at the place last looked at.
template <class Number>
auto BranchSteps<Number>::bands(std::size_t guard) -> Bands {
  RecordedBranch& branch = here_->branch();
  const std::vector<int> variables = branch.variables();
  const std::vector<double> at = here_->at(), slopes = branch.values(branch.motion.recording.graph.gradient(branch.branches.met[guard].node, variables), at);
  double of_state = 0.0;
  for (std::size_t i = 0; i + 1 < variables.size(); ++i) {
    const int place = branch.motion.recording.graph[variables[i]].a;
    of_state += std::abs(slopes[i] * at[static_cast<std::size_t>(place)]);
  }
  const double of_time = std::abs(slopes.back() * t_);
  constexpr double rounding = 64 * std::numeric_limits<double>::epsilon(), hidden = 10.0;
  return {rounding * (of_state + of_time), std::max(hidden * rtol_, rounding) * of_state + rounding * of_time};
}

// A place where a guard that holds at both of its neighbours does not: between them it comes near to its level and turns. Of a step that is held a guard
// which turns within what the tolerances hide is only touched.
template <class Number>
std::optional<double> BranchSteps<Number>::grazed(bool is_held) {
  constexpr double ratio = 0.3819660112501051;  // of the golden section
  const std::size_t guards = here_->branch().branches.met.size();
  for (std::size_t k = 0; k < guards; ++k) {
    const auto inside = [&](int place) { return inside_[static_cast<std::size_t>(place) * guards + k]; };
    const auto inside_at = [&](double fraction) { return static_cast<void>(left_at(*here_, fraction)), here_->inside(k); };
    double size = 0.0;
    for (int place = 0; place <= places; ++place) size = std::max(size, std::abs(inside(place)));
    for (int place = 1; place < places; ++place) {
      const double a = inside(place - 1), b = inside(place), c = inside(place + 1), bend = a - 2.0 * b + c;
      if (!(b <= a && b <= c && bend > 0.0) || b - 0.125 * (a - c) * (a - c) / bend > 0.5 * b) continue;  // a parabola stays far from the level
      double low = fraction_of(place - 1), high = fraction_of(place + 1);
      for (int times = 0; times < 60; ++times) {
        const double left = low + ratio * (high - low), right = high - ratio * (high - low), at_left = inside_at(left);
        if (at_left < -noise * size && (!is_held || at_left < -bands(k).hidden)) return left;
        const double at_right = inside_at(right);
        if (at_right < -noise * size && (!is_held || at_right < -bands(k).hidden)) return right;
        (at_left < at_right ? high : low) = at_left < at_right ? right : left;
      }
    }
  }
  return std::nullopt;
}

// Where the step begins and ends.
template <class Number>
void BranchSteps<Number>::take_sizes() {
  for (const double fraction : {1.0, 0.0}) {
    move_to(fraction);
    sizes_.q = std::max(sizes_.q, y_.head(dof_).cwiseAbs().maxCoeff()), sizes_.qdot = std::max(sizes_.qdot, y_.segment(dof_, dof_).cwiseAbs().maxCoeff());
  }
}
// Rates at the time last looked at; false where functors refuse.
template <class Number>
bool BranchSteps<Number>::has_rates(const Eigen::VectorXd& y, Eigen::VectorXd& out) const {
  out.resize(size_);
  try {
    form_.derivative(t_, y, out);
  } catch (...) {
    return false;
  }
  return all_finite(out.data(), out.size());
}

// Where the step begins, on its branch.
template <class Number>
void BranchSteps<Number>::take_energies(RecordedBranch& branch, const std::vector<double>& at) {
  const std::vector<int>& returned = branch.motion.returned;
  const double energy = returned.size() < 2 ? 0.0 : [&] {
    const std::vector<double> both = branch.values({returned[0], returned[1]}, at);
    return std::abs(both[0]) + std::abs(both[1]);
  }();
  sizes_.energy = std::max(sizes_.energy, energy);
}

// What the motion meets at the boundary of two branches, which lies between two fractions of the step, or at one.
template <class Number>
std::optional<Failure> BranchSteps<Number>::trouble_between(SidesOfBranch<>& before, SidesOfBranch<>& behind, Edge between, bool is_start) {
  const bool is_within = between.holds != between.is_left;
  if (is_within) between = edge(before, between, finer);
  static_cast<void>(left_at(before, 0.0));
  take_energies(before.branch(), before.at());
  const int guard = left_at(before, between.is_left);
  if (guard < 0) return std::nullopt;
  const bool has_other_side = has_rates(y_, rates_behind_);
  BranchCrossing<> crossing(before.branch(), behind.branch(), static_cast<std::size_t>(guard), before.at(), sizes_, rtol_);
  if (auto jump = is_start ? std::nullopt : crossing.jump()) return jump;
  if (!is_within || !has_other_side) return std::nullopt;
  move_to(between.holds);
  if (!has_rates(y_, rates_before_)) return std::nullopt;
  return crossing.sliding(rates_before_, rates_behind_, to_ > from_ ? 1.0 : -1.0);
}

// What the motion meets where it starts on a boundary. The rates of the other side are those a little beyond it, less their change on the way there.
template <class Number>
std::optional<Failure> BranchSteps<Number>::trouble_at_start() {
  constexpr double part = 1e-6;  // of what the step moves
  move_to(1.0);
  const Eigen::VectorXd end = y_;
  Eigen::VectorXd nearer(size_);
  const auto& met = here_->branch().branches.met;
  for (std::size_t k = 0; k < met.size(); ++k) {
    static_cast<void>(left_at(*here_, 0.0));
    if (here_->inside(k) != 0.0) continue;
    std::vector<int> variables = here_->branch().variables();
    variables.pop_back();
    const std::vector<double> at = here_->at(), slopes = here_->branch().values(here_->branch().motion.recording.graph.gradient(met[k].node, variables), at);
    const Eigen::Map<const Eigen::VectorXd> slope(slopes.data(), size_);
    const double moved = (end - y_).cwiseAbs().maxCoeff(), steepest = slope.cwiseAbs().maxCoeff();
    if (!(steepest > 0.0)) continue;
    const double way = met[k].sign * std::max(part * (moved > 0.0 ? moved : 1e-3), 1e-12 * y_.cwiseAbs().maxCoeff()) / steepest;
    const Eigen::VectorXd beyond = y_ - way * slope, half = y_ - 0.5 * way * slope;
    if (here_->move_to(dof_, t_, beyond) < 0 || here_->move_to(dof_, t_, half) < 0) continue;
    if (!has_rates(y_, rates_before_) || !has_rates(beyond, rates_behind_) || !has_rates(half, nearer)) continue;
    rates_behind_ = 2.0 * nearer - rates_behind_;
    BranchCrossing<> crossing(here_->branch(), here_->branch(), k, at, {}, rtol_);
    if (auto trouble = crossing.sliding(rates_before_, rates_behind_, to_ > from_ ? 1.0 : -1.0, true)) return trouble;
  }
  return std::nullopt;
}

template <class Number>
[[gnu::cold, gnu::noinline]] Passage BranchSteps<Number>::passage(const Clock& clock, const PolynomialView& step, double from, double to) {
  if (retaken_ > most_retaken) return {};
  clock_ = clock, step_ = step, from_ = from, to_ = to;
  const bool is_start = !here_;  // of the run, or behind a change of the state
  first_fraction_ = 0.0, goes_on_from_.reset();
  if (const int left = here_ ? left_at(*here_, 0.0) : 0; left >= 0) {
    auto now = sides_at(0.0);
    if (auto unknown = undecided(*now, -1)) return {{}, unknown, from};
    take_sizes();
    const auto before = std::exchange(here_, std::move(now));
    if (auto trouble = before ? trouble_between(*before, *here_, {0.0, 0.0}, false) : trouble_at_start()) return {{}, trouble, from};
  }
  if (!here_->has_guards()) return {};
  take_sizes();
  if (stays_here()) return {};
  inside_.resize((places + 1) * here_->branch().branches.met.size());
  int changes = 0, first = 0;
  for (int k = 0, was = 0; k <= places; ++k) {
    const int left = left_at_place(k);
    if (auto unknown = undecided_at_place(k, left)) return *unknown;
    const int is = left >= 0 ? 1 : 0;
    if (is != std::exchange(was, is) && ++changes == 1) first = k;
  }
  double seen = static_cast<double>(first) / places;
  if (changes == 0) {
    const auto place = grazed();
    if (!place) return {};
    seen = *place;
  } else if (changes == 1) {  // a third branch may lie between the two
    auto behind = sides_at(1.0);
    const Edge own = edge(*here_, {seen - 1.0 / places, seen});
    const double last = own.holds, next = edge(*behind, {1.0, last}).holds;
    if (next - last < 4.0 * std::ldexp(1.0, -halvings)) {
      // What a start lies on, to rounding, is behind it.
      if (auto trouble = trouble_between(*here_, *behind, own, is_start && own.holds < 1e-9)) return {{}, trouble, from + own.is_left * (to - from)};
      return here_ = std::move(behind), Passage();
    }
    seen = 0.5 * (last + next);
  }
  ++retaken_;
  return {from + seen * (to - from), {}, 0.0};
}

// The first place where a guard does not hold by more than rounding makes of it. A motion that turns back on this side of what the tolerances tell only
// touches the guard, and does not leave its branch.
template <class Number>
std::optional<int> BranchSteps<Number>::first_beyond() {
  const std::size_t guards = here_->branch().branches.met.size();
  std::optional<int> first;
  for (std::size_t i = 0; i < guards; ++i) {
    const auto inside = [&](int k) { return inside_[static_cast<std::size_t>(k) * guards + i]; };
    int deepest = 0;
    for (int k = 1; k <= places; ++k)
      if (inside(k) < inside(deepest)) deepest = k;
    if (!(inside(deepest) < 0.0)) continue;
    static_cast<void>(left_at(*here_, fraction_of(deepest)));
    const Bands band = bands(i);
    if (std::min(inside(0), inside(places)) >= -band.rounding && inside(deepest) >= -band.hidden) continue;
    for (int k = 0; k <= places && (!first || k < *first); ++k)
      if (inside(k) < -band.rounding) first = k;
  }
  return first;
}

// The branch behind an edge, at a place so far ahead that rounding does not decide.
template <class Number>
auto BranchSteps<Number>::behind(const Edge& own) -> Ahead {
  const int guard = left_at(*here_, own.is_left);
  double ahead = own.is_left;
  for (const double further : {1e-12, 1e-10, 1e-8, 1e-6}) {
    ahead = std::min(own.is_left + further, 1.0);
    static_cast<void>(left_at(*here_, ahead));
    if (guard < 0 || here_->inside(static_cast<std::size_t>(guard)) < -2.0 * bands(static_cast<std::size_t>(guard)).rounding) break;
  }
  return {ahead, sides_at(ahead)};
}

template <class Number>
[[gnu::cold, gnu::noinline]] Passage BranchSteps<Number>::held(const Clock& clock, const PolynomialView& step, double from, double to) {
  clock_ = clock, step_ = step, from_ = from, to_ = to;
  const bool is_start = !here_;
  take_sizes();
  first_fraction_ = is_start || !goes_on_from_ ? 0.0 : std::clamp((*goes_on_from_ - from) / (to - from), 0.0, 1.0);
  if (first_fraction_ == 0.0) goes_on_from_.reset();
  if (is_start) {
    here_ = sides_at(0.0);
    if (auto unknown = undecided(*here_, -1)) return {{}, unknown, from};
    if (auto trouble = trouble_at_start()) return {{}, trouble, from};
  }
  if (!here_->has_guards() || stays_here()) return {};
  inside_.resize((places + 1) * here_->branch().branches.met.size());
  for (int k = 0; k <= places; ++k)
    if (auto unknown = undecided_at_place(k, left_at_place(k))) return *unknown;
  const std::optional<int> first = first_beyond();
  const std::optional<double> beyond = first ? std::optional(fraction_of(*first)) : grazed(true);
  if (!beyond) return {};
  int before = first.value_or(places) - 1;
  while (before > 0 && fraction_of(before) >= *beyond) --before;
  const Edge own = before >= 0 ? edge(*here_, {fraction_of(before), *beyond}, halvings + finer) : Edge{*beyond, *beyond};
  Passage left{.until = from + own.is_left * (to - from)};
  auto [ahead, next] = behind(own);
  const bool is_on_guard = own.is_left < 1e-9;  // a start on the guard, to rounding, is behind it
  if (auto trouble = trouble_between(*here_, *next, own, is_start && is_on_guard)) return left.trouble = std::move(trouble), left;
  here_ = std::move(next);
  left.cut = is_on_guard ? from : left.until;
  left.ahead = goes_on_from_ = from + ahead * (to - from);
  return left;
}

template <class Number>
[[gnu::cold, gnu::noinline]] Passage BranchSteps<Number>::beginning(const Clock& clock, const PolynomialView& step, double from, double to) {
  clock_ = clock, step_ = step, from_ = from, to_ = to;
  take_sizes();
  const bool is_start = !here_;
  if (is_start) {
    here_ = sides_at(0.0);
    if (auto unknown = undecided(*here_, -1)) return {{}, unknown, from};
    if (auto trouble = trouble_at_start()) return {{}, trouble, from};
  }
  if (!here_->has_guards()) return {};
  // Not in its middle, where a motion between two edges turns, maybe on a third.
  constexpr double within = 0.38;
  const int guard = left_at(*here_, within);
  if (guard < 0) return {};
  if (auto unknown = undecided(*here_, guard)) return {{}, unknown, from};
  const auto before = std::exchange(here_, sides_at(within));
  if (is_start) return {};
  static_cast<void>(left_at(*before, 0.0));
  take_energies(before->branch(), before->at());
  return {{}, BranchCrossing<>(before->branch(), here_->branch(), static_cast<std::size_t>(guard), before->at(), sizes_, rtol_).jump(), from};
}

}  // namespace qdot::detail
