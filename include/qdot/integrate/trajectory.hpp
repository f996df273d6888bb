#pragma once
// SPDX-License-Identifier: MIT
//
// A trajectory is a function of time, not a table.
//
// The driver appends the polynomial of every accepted step (integrate/steps/polynomial.hpp), and y at any t is that of the step that
// contains t. So a plot, a root search or a comparison may sample as finely as it likes after the run. It has the accuracy of the run,
// and needs no new evaluation of the model.
//
// Times run monotonically from front to back, up or down. A time at which two steps meet belongs to the earlier one, because a
// method's own value lies at the end of its step. Where the state *jumps* (an impact, a reset), t is the double nearest to the jump:
// at(t) gives the state after the jump, and before(t) the state in front of it. Steps may be shorter than a rounding unit of t: they
// are told apart by what has elapsed since their origin (time_point.hpp).
//
// Memory is 8·size·(degree + 1) bytes for the coefficients of a step and 64 bytes for the step. Its blocks are never copied or
// moved as the trajectory grows: on small systems copying one growing array cost more than the integration.

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <deque>
#include <utility>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/steps/polynomial.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot {

/// Piecewise polynomial y(t) over a whole run, for any first-order system. A template only so that it is compiled once, by the library.
template <class Number = double>
class BasicDenseOutput {
 public:
  BasicDenseOutput();
  BasicDenseOutput(const BasicDenseOutput&);
  BasicDenseOutput(BasicDenseOutput&&);
  BasicDenseOutput& operator=(const BasicDenseOutput&);
  BasicDenseOutput& operator=(BasicDenseOutput&&) noexcept;
  ~BasicDenseOutput();

  /// Forgets everything and begins at (t, y).
  void start(double t, const Eigen::Ref<const Eigen::VectorXd>& y);

  /// Appends the step that ends at t. Allocates now and then, when a block is full.
  void append(double t, const PolynomialView& step) { append(t, t - step.base, step); }

  /// Appends a step whose end is given more exactly by `elapsed`, the time since the step's base.
  void append(double t, double elapsed, const PolynomialView& step);

  /// Notes that the state is changed from outside at back_time(): the next step starts from `y`.
  void jump(const Eigen::Ref<const Eigen::VectorXd>& y);

  /// Components of y.
  Eigen::Index size() const noexcept { return size_; }
  /// Steps that are kept.
  std::size_t steps() const noexcept { return pieces_.size() - jumps_.size(); }
  /// Where it begins.
  double front_time() const noexcept { return start_time_; }
  /// Where it ends.
  double back_time() const noexcept { return pieces_.empty() ? start_time_ : pieces_.back().t_end; }

  /// True when t lies between front_time() and back_time(), both included.
  bool contains(double t) const noexcept {
    return std::min(front_time(), back_time()) <= t && t <= std::max(front_time(), back_time());
  }

  /// The times of the accepted steps, the start first.
  std::vector<double> times() const;

  /// y(t), after a jump if there is one at t. O(log steps).
  ///
  /// @throws InvalidValue  when t is not between front_time() and back_time()
  Eigen::VectorXd y(double t) const;

  /// y ← y(t) as by at(t), into a vector of the caller's, without allocation.
  void evaluate(double t, Eigen::Ref<Eigen::VectorXd> y) const;

  /// y at front_time(), in front of a jump there.
  const Eigen::VectorXd& y_front() const noexcept { return start_; }

  /// y just before a jump at t; y(t) where there is none.
  Eigen::VectorXd y_before(double t) const;

  /// Times at which the state jumps, in order.
  std::vector<double> jump_times() const;

 private:
  struct Piece {
    double t_end, elapsed;       // at the end, since base
    double base, origin, scale;  // of the polynomial
    std::size_t block;
    std::ptrdiff_t offset;
    int degree;
  };
  static constexpr std::size_t start_point = static_cast<std::size_t>(-1);
  static constexpr std::size_t block_size = 4096;  // doubles

  // Copies numbers into the last block, or into a new one if they do not fit; returns where.
  std::pair<std::size_t, std::ptrdiff_t> stored(const double* numbers, Eigen::Index count);

  void require_contained(double t) const;

  // a comes before b in the order of the run.
  bool precedes(double a, double b) const noexcept { return back_time() >= start_time_ ? a < b : a > b; }

  // The first piece whose end is not before t, or the start.
  void evaluate_within(double t, Eigen::Ref<Eigen::VectorXd> y) const;

  void evaluate_end(std::size_t index, Eigen::Ref<Eigen::VectorXd> y) const;

  PolynomialView view(const Piece& piece) const {
    return {piece.origin, piece.scale, blocks_[piece.block].data() + piece.offset, size_, piece.degree};
  }

  Eigen::Index size_ = 0;
  double start_time_ = 0.0;
  Eigen::VectorXd start_;
  std::deque<Piece> pieces_;
  std::vector<std::size_t> jumps_;          // indices of pieces of no length
  std::deque<std::vector<double>> blocks_;  // the coefficients of the pieces
};

template <class Number>
void BasicDenseOutput<Number>::start(double t, const Eigen::Ref<const Eigen::VectorXd>& y) {
  size_ = y.size();
  start_time_ = t;
  start_ = y;
  pieces_.clear();
  jumps_.clear();
  blocks_.clear();
}

template <class Number>
void BasicDenseOutput<Number>::append(double t, double elapsed, const PolynomialView& step) {
  const auto [block, offset] = stored(step.coefficients, step.size * (step.degree + 1));
  pieces_.push_back({t, elapsed, step.base, step.origin, step.scale, block, offset, step.degree});
}

template <class Number>
void BasicDenseOutput<Number>::jump(const Eigen::Ref<const Eigen::VectorXd>& y) {
  jumps_.push_back(pieces_.size());
  const Eigen::VectorXd after = y;
  const auto [block, offset] = stored(after.data(), after.size());
  // A piece of no length, so that at(back_time()) is right even if the run ends here.
  const bool first = pieces_.empty();
  const double t = back_time(), base = first ? t : pieces_.back().base, elapsed = first ? 0.0 : pieces_.back().elapsed;
  pieces_.push_back({t, elapsed, base, elapsed, 1.0, block, offset, 0});
}

template <class Number>
std::vector<double> BasicDenseOutput<Number>::times() const {
  std::vector<double> result;
  result.reserve(pieces_.size() + 1);
  result.push_back(start_time_);
  for (const Piece& piece : pieces_)
    if (piece.t_end != result.back()) result.push_back(piece.t_end);
  return result;
}

template <class Number>
Eigen::VectorXd BasicDenseOutput<Number>::y(double t) const {
  Eigen::VectorXd result(size_);
  evaluate(t, result);
  return result;
}

template <class Number>
void BasicDenseOutput<Number>::evaluate(double t, Eigen::Ref<Eigen::VectorXd> y) const {
  require_contained(t);
  if (t == back_time()) return evaluate_end(pieces_.size() - 1, y);  // which t may have been rounded beyond
  const auto after = std::upper_bound(jumps_.begin(), jumps_.end(), t, [this](double time, std::size_t jump) { return precedes(time, pieces_[jump].t_end); });
  if (after != jumps_.begin() && pieces_[*(after - 1)].t_end == t) return evaluate_end(*(after - 1), y);
  evaluate_within(t, y);
}

template <class Number>
Eigen::VectorXd BasicDenseOutput<Number>::y_before(double t) const {
  require_contained(t);
  Eigen::VectorXd result(size_);
  const auto jump = std::lower_bound(jumps_.begin(), jumps_.end(), t, [this](std::size_t each, double time) { return precedes(pieces_[each].t_end, time); });
  if (jump != jumps_.end() && pieces_[*jump].t_end == t) {
    evaluate_end(*jump - 1, result);
  } else {
    evaluate(t, result);
  }
  return result;
}

template <class Number>
std::vector<double> BasicDenseOutput<Number>::jump_times() const {
  std::vector<double> result;
  for (const std::size_t piece : jumps_) result.push_back(pieces_[piece].t_end);
  return result;
}

template <class Number>
std::pair<std::size_t, std::ptrdiff_t> BasicDenseOutput<Number>::stored(const double* numbers, Eigen::Index count) {
  const auto wanted = static_cast<std::size_t>(count);
  if (blocks_.empty() || blocks_.back().capacity() - blocks_.back().size() < wanted) {
    blocks_.emplace_back();
    blocks_.back().reserve(std::max(block_size, wanted));
  }
  std::vector<double>& block = blocks_.back();
  const auto offset = static_cast<std::ptrdiff_t>(block.size());
  block.insert(block.end(), numbers, numbers + count);
  return {blocks_.size() - 1, offset};
}

template <class Number>
void BasicDenseOutput<Number>::require_contained(double t) const {
  if (!contains(t))
    detail::throw_invalid_value({"t must lie within the trajectory, from ", front_time(), " to ", back_time(), ", but is ", t,
                                 "; extend the run, or ask for a time it has reached"});
}

template <class Number>
void BasicDenseOutput<Number>::evaluate_within(double t, Eigen::Ref<Eigen::VectorXd> y) const {
  if (t == start_time_) return evaluate_end(start_point, y);
  const auto found = std::lower_bound(pieces_.begin(), pieces_.end(), t, [this](const Piece& piece, double time) {
    return piece.t_end == time ? precedes(piece.elapsed, time - piece.base) : precedes(piece.t_end, time);
  });
  view(*found).at(t - found->base, y);
}

template <class Number>
void BasicDenseOutput<Number>::evaluate_end(std::size_t index, Eigen::Ref<Eigen::VectorXd> y) const {
  if (index == start_point) {
    y = start_;
  } else {
    view(pieces_[index]).at(pieces_[index].elapsed, y);
  }
}

template <class Number>
BasicDenseOutput<Number>::BasicDenseOutput() = default;
template <class Number>
BasicDenseOutput<Number>::BasicDenseOutput(const BasicDenseOutput&) = default;
template <class Number>
BasicDenseOutput<Number>::BasicDenseOutput(BasicDenseOutput&&) = default;
template <class Number>
BasicDenseOutput<Number>& BasicDenseOutput<Number>::operator=(const BasicDenseOutput&) = default;
template <class Number>
BasicDenseOutput<Number>& BasicDenseOutput<Number>::operator=(BasicDenseOutput&&) noexcept = default;
template <class Number>
BasicDenseOutput<Number>::~BasicDenseOutput() = default;

/// The continuous solution of a run.
using DenseOutput = BasicDenseOutput<>;

#ifdef QDOT_COMPILED
extern template class BasicDenseOutput<double>;
#endif

/// The motion of a mechanical system with n coordinates: y(t) = [q; q̇; …] taken apart.
///
/// @tparam n  number of coordinates, or Dynamic
template <int n = Dynamic>
class Trajectory : public DenseOutput {
 public:
  Trajectory() = default;
  explicit Trajectory(Eigen::Index dof) : dof_(dof) {}
  /// The same motion, the number of its coordinates being known.
  template <int m>
    requires(m == Dynamic && n != Dynamic)
  explicit Trajectory(Trajectory<m>&& other) : DenseOutput(std::move(other)), dof_(other.dof()) {}

  /// Number of coordinates; 0 for a first-order system without any.
  Eigen::Index dof() const noexcept { return dof_; }

  /// The state at t, after a jump if there is one at t.
  ///
  /// @throws InvalidValue  when t is not between front_time() and back_time()
  State<n> at(double t) const { return state(t, y(t)); }

  /// The state just in front of a jump at t; at(t) where there is none.
  State<n> before(double t) const { return state(t, y_before(t)); }

  /// The state at its beginning.
  State<n> front() const { return state(front_time(), y_front()); }
  /// The state at its end.
  State<n> back() const { return at(back_time()); }

  /// `count` states at equal distances in time, both ends included.
  ///
  /// @throws InvalidValue  when count < 2
  std::vector<State<n>> sampled(int count) const {
    if (count < 2)
      detail::throw_invalid_value({"the number of samples must be at least 2 (both ends), but is ", count});
    std::vector<State<n>> result;
    result.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count - 1; ++i)
      result.push_back(at(front_time() + (back_time() - front_time()) * (static_cast<double>(i) / (count - 1))));
    result.push_back(back());
    return result;
  }

 private:
  State<n> state(double t, const Eigen::VectorXd& y) const {
    if (dof_ < 1)
      detail::throw_invalid_value({"a state needs coordinates, but this first-order system of ", size(), " components has none; ask for y(t)"});
    State<n> state{t, Vector<double, n>(dof_), Vector<double, n>(dof_)};
    std::copy_n(y.data(), dof_, state.q.data());
    std::copy_n(y.data() + dof_, dof_, state.qdot.data());
    return state;
  }

  Eigen::Index dof_ = 0;
};

}  // namespace qdot
