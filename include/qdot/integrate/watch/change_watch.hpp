#pragma once
// SPDX-License-Identifier: MIT
//
// Is the right-hand side a function?
//
// Methods assume that f(t, y) is the same whenever it is asked for: a first stage is used again, a rejected step is taken anew. A force
// that reads a variable which an observer writes to, or that counts its own calls, is no such f. Then the result depends on the method
// and its steps. So the values at (t, y) are kept where a leg begins and at each look, and the next look evaluates f *there* again. The
// values are q̈ and ż by the equations themselves, φ and φ̇ of constraints, guards of contacts and friction. T and V are asked twice.
//
// An f that does not change gives the same bits. Bits that differ may be rounding, as of a sum whose order depends on threads. So a
// difference δ in component i is a change of the model only if rounding does not explain it,
//
//     |δ| > 2⁻³⁶ |fᵢ| + Σⱼ |fᵢ(y + 2⁻³⁶ yⱼ eⱼ) − fᵢ(y)| ,         2⁻³⁶ = 1.5e-11 ,
//
// a hundred thousand times what rounding of y does. A rate must also matter: |δ| times the time since the leg began > rtol |yᵢ| + atolᵢ.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "qdot/ad/vector.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/steps/one_step.hpp"
#include "qdot/integrate/watch/watched_form.hpp"

namespace qdot::detail {

/// Compares a run's right-hand side with what it was.
template <class Number = double>
class BasicChangeWatch {
 public:
  BasicChangeWatch(const WatchedForm& form, const Options& options) : form_(form), options_(options) {}

  /// Begins a leg: whatever changed before was allowed to.
  void begin(double t, const Eigen::VectorXd& y);

  /// Keeps the values at a state for the next look.
  void remember(double t, const Eigen::VectorXd& y) {
    if (looks_ < 8 || looks_ % thinned == 0) keep(latest_, t, y);
  }

  /// What is not as it was, if something is.
  ///
  /// @param loss_counts  whether a value that is there no more ends the run; otherwise the method is about to report it
  /// @throws             what functors throw that is no outcome, if a loss counts
  std::optional<Failure> look(double t, bool loss_counts = false);

 private:
  static constexpr double rounding = 0x1p-36;
  static constexpr long thinned = 4;  // after the first looks values are kept at every fourth, and those of the leg's begin compared: for what creeps

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
  Failure loss(const Seen& seen, double t);

  // out ← all values. False where they cannot be evaluated, or are not finite.
  bool values_at(double t, const Eigen::VectorXd& y, Eigen::VectorXd& out) const {
    try {
      form_.values(t, y, out);
    } catch (...) {
      return false;
    }
    return all_finite(out.data(), out.size());
  }
  std::string name(Eigen::Index i) const;

  const WatchedForm& form_;
  const Options& options_;
  Seen first_, latest_;
  long looks_ = 0;  // in this leg
  Eigen::VectorXd now_;
  std::array<double, 4> at_once_{};  // T, T again, V, V again where a leg begins
};

template <class Number>
void BasicChangeWatch<Number>::begin(double t, const Eigen::VectorXd& y) {
  keep(first_, t, y);
  const std::optional<EnergyAt> once = quietly([&] { return form_.energy(t, y); }), again = quietly([&] { return form_.energy(t, y); });
  at_once_ = once && again ? std::array{once->T, again->T, once->V, again->V} : std::array<double, 4>{};
  latest_.is_known = false;
  looks_ = 0;
}

template <class Number>
std::optional<Failure> BasicChangeWatch<Number>::look(double t, bool loss_counts) {
  for (const std::size_t i : {0U, 2U})
    if (std::abs(at_once_[i] - at_once_[i + 1]) > rounding * (std::abs(at_once_[i]) + std::abs(at_once_[i + 1])))
      return Failure{Outcome::model_changed,
                     sentence({"functors must depend on nothing but their arguments, but ", i == 0 ? "T" : "V", " at t = ", first_.t, " was ",
                               at_once_[i], " and, asked once more at the same state, ", at_once_[i + 1]})};
  const bool both = ++looks_ % thinned == 0 || !latest_.is_known;
  for (const Seen* seen : {&latest_, &first_}) {
    if (!seen->is_known || (seen != &latest_ && !both)) continue;
    if (!values_at(seen->t, seen->y, now_)) {
      if (loss_counts) return loss(*seen, t);
    } else if (!is_same(*seen)) {
      if (const std::optional<Eigen::Index> i = changed(*seen, std::abs(t - first_.t) + 4 * std::numeric_limits<double>::epsilon() * std::abs(t)))
        return failure(*seen, *i, t);
    }
  }
  return std::nullopt;
}

template <class Number>
void BasicChangeWatch<Number>::keep(Seen& seen, double t, const Eigen::VectorXd& y) {
  seen.t = t;
  seen.y = y;
  seen.is_known = values_at(t, y, seen.values);
}

template <class Number>
[[gnu::cold, gnu::noinline]] std::optional<Eigen::Index> BasicChangeWatch<Number>::changed(const Seen& seen, double duration) {
  const Eigen::Index size = std::min(now_.size(), seen.values.size());
  Eigen::VectorXd explained(now_.size()), moved = seen.y, there;
  for (Eigen::Index i = 0; i < now_.size(); ++i) explained[i] = rounding * std::abs(now_[i]);
  for (Eigen::Index j = 0; j < moved.size(); ++j) {
    moved[j] += rounding * moved[j];
    if (moved[j] != seen.y[j] && values_at(seen.t, moved, there) && there.size() == now_.size())
      for (Eigen::Index i = 0; i < now_.size(); ++i) explained[i] += std::abs(there[i] - now_[i]);
    moved[j] = seen.y[j];
  }
  std::optional<Eigen::Index> worst;
  double largest = 0.0;
  for (Eigen::Index i = 0; i < size; ++i) {
    const double change = std::abs(now_[i] - seen.values[i]);
    if (!(change > explained[i])) continue;
    if (i < form_.size() && !(change * duration > options_.rtol * std::abs(seen.y[i]) + options_.atol[i])) continue;
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
          sentence({"between events and stop times functors must depend on nothing but their arguments, but ", name(i), " at t = ",
                    seen.t, " was ", seen.values[i], " and is ", now_[i], " when it is evaluated there again at t = ", t})};
}
template <class Number>
[[gnu::cold, gnu::noinline]] Failure BasicChangeWatch<Number>::loss(const Seen& seen, double t) {
  Failure failure;
  if (!attempted(failure, [&] { form_.values(seen.t, seen.y, now_); })) return failure;
  return {Outcome::non_finite, sentence({"what was finite at t = ", seen.t, " is infinite or NaN when it is evaluated there again at t = ", t,
                                         ": functors must depend on nothing but their arguments"})};
}
// In words.
template <class Number>
[[gnu::cold]] std::string BasicChangeWatch<Number>::name(Eigen::Index i) const {
  if (i < form_.size()) return sentence({"the rate of ", form_.component_name(i)});
  const std::vector<std::string> names = form_.row_names();
  const auto rows = static_cast<Eigen::Index>(names.size()), k = i - form_.size();
  if (k < 2 * rows) return sentence({k < rows ? "the constraint '" : "the velocity of the constraint '", names[static_cast<std::size_t>(k % rows)], "'"});
  return "the gap of a contact or the limit of a friction";
}
using ChangeWatch = BasicChangeWatch<>;

#ifdef QDOT_COMPILED
extern template class BasicChangeWatch<double>;
#endif

}  // namespace qdot::detail
