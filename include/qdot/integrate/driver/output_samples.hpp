#pragma once
// SPDX-License-Identifier: MIT
//
// The states at a run's output times, filled as steps cover them. Times are compared as what has elapsed on the leg's clock (time_point.hpp):
// at a large t two doubles t may be the same where the steps between them are not.
//
// Equal moments. Where something happens by the clock, output times within some rounding units of that time are this time (EventClocks::same()), and
// their states are those behind it. 0.1 + 5 · 0.1 and 6 · 0.1 are one moment, though not one double.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "qdot/integrate/driver/landing_points.hpp"
#include "qdot/integrate/run.hpp"

namespace qdot::detail {

class OutputSamples {
 public:
  // @throws InvalidValue  a time outside the run
  [[gnu::cold]] void prepare(const std::vector<double>& asked, double t0, double t_end, Eigen::Index size) {
    times_ = output_points(asked, t0, t_end);
    samples_.t.reserve(times_.size());
    samples_.y.resize(size, static_cast<Eigen::Index>(times_.size()));
    at_.resize(size);
  }

  // Those in front of what has elapsed since origin, by more than `same`; write(t, y) gives the state.
  template <class Write>
  void fill_before(double elapsed, double direction, double origin, double same, const Write& write) {
    while (next_ < times_.size() && (elapsed - (times_[next_] - origin)) * direction > same) {
      write(times_[next_], at_);
      keep(at_);
    }
  }

  // Those here, to within `same`.
  void fill_here(double elapsed, double origin, double same, const Eigen::VectorXd& y) {
    while (next_ < times_.size() && std::abs((times_[next_] - origin) - elapsed) <= same) keep(y);
  }

  // Those exactly here once more, where the state has changed since.
  void amend_here(double elapsed, double origin, const Eigen::VectorXd& y) {
    for (std::size_t k = next_; k > 0 && times_[k - 1] - origin == elapsed; --k)
      std::copy_n(y.data(), y.size(), samples_.y.data() + static_cast<Eigen::Index>(k - 1) * y.size());
  }

  // As far as the run came.
  Samples taken() {
    if (next_ < times_.size()) {
      Eigen::MatrixXd reached(samples_.y.rows(), static_cast<Eigen::Index>(next_));
      std::copy_n(samples_.y.data(), reached.size(), reached.data());
      samples_.y = std::move(reached);
    }
    return std::move(samples_);
  }

 private:
  void keep(const Eigen::VectorXd& y) {
    samples_.t.push_back(times_[next_]);
    std::copy_n(y.data(), y.size(), samples_.y.data() + static_cast<Eigen::Index>(next_++) * y.size());
  }

  std::vector<double> times_;
  std::size_t next_ = 0;
  Samples samples_;
  Eigen::VectorXd at_;
};

}  // namespace qdot::detail
