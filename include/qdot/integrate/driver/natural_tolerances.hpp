#pragma once
// SPDX-License-Identifier: MIT
//
// The absolute tolerance of a run whose user gave none.
//
// 1e-12 is small beside a pendulum's angle and is all of a molecule's motion in metres. So it is an upper bound: component i of size Yᵢ gets
//
//     atolᵢ = min(1e-12, rtol Yᵢ)  where Yᵢ < 1e-3 ,     else 1e-12 .
//
// Yᵢ comes from the start: |yᵢ|, and what the rates add in the time h in which they change by their own size. With Heun's rule,
//
//     y₁ = y + h f ,   y₂ = y + h (f + f₁)/2 ,   |f₂ − f₁| ≤ max(|f|, |f₁|) in each component,
//
// h is the longest for which that holds, by doubling. A velocity has at least the size of its coordinate by the length of the run.
// A component that is zero with all its rates borrows the size of its like; one that is zero but for rounding gets what rounding
// makes of it (integrate/accurate/motion.hpp). Where all is zero, later times of the run are searched for a push. Without one
// nothing is known, and the next leg is asked again.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "qdot/error.hpp"
#include "qdot/integrate/accurate/motion.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/watch/driven_form.hpp"
#include "qdot/mechanics/equations/ordinary_size.hpp"

namespace qdot::detail {

struct NaturalTolerances {
  Eigen::VectorXd each = {};  // empty: the default for all
  bool known = true;          // false: nothing moves, and nothing pushes
};

// Sizes of the components of a motion from (t, y) on its way.
template <class Number = double>
class NaturalSizes {
 public:
  NaturalSizes(const DrivenForm& system, double t, const Eigen::VectorXd& y, double way)
      : system_(system), t_(t), way_(way), end_(t + way), dof_(std::min(system.dof(), y.size() / 2)), y_(y), sizes_(y.cwiseAbs()) {}

  // The tolerances; asks for f only where a component may be too small for the default. Unknown where what holds the scene at rest may
  // balance a push.
  NaturalTolerances tolerances(double rtol, double most) {
    constexpr double enough = ordinary_size;
    for (Eigen::Index i = 0; i < dof_; ++i) sizes_[dof_ + i] = std::max(sizes_[dof_ + i], sizes_[i] / std::abs(way_));
    if (!(sizes_.minCoeff() < enough) || !rates(t_, y_, f_)) return {};
    // Accelerations of what is held at rest are rounding.
    if ((system_.is_constrained() || system_.guard_count() > 0) && sizes_.head(2 * dof_).isZero(0.0)) return {{}, false};
    if (f_.isZero(0.0) || sizes_.isZero(0.0)) look_later();  // at rest, and the foot of a push is no size
    if (sizes_.head(2 * dof_).isZero(0.0) && f_.isZero(0.0)) return {{}, false};  // phases are no sizes
    if (swing(enough)) return {};
    grow();
    lend(2 * dof_, y_.size() - 2 * dof_);
    const double time = std::min(std::abs(way_), 1e3 * h_);
    const ComponentSizes found = component_sizes(system_, dof_, sizes_, {t_}, y_, time);
    Eigen::VectorXd each = found.tolerances(rtol, found.sizes).cwiseMin(most);
    // What else is carried along, as derivatives are, may be zero but for rounding: it is small where the motion is.
    const bool small_motion = dof_ == 0 || found.sizes.head(2 * dof_).maxCoeff() < enough;
    for (Eigen::Index i = 0; i < each.size(); ++i)
      if (found.sizes[i] >= enough || (i >= 2 * dof_ && !small_motion)) each[i] = most;
    if (each.minCoeff() >= most) return {};
    return {each, true};
  }

 private:
  // f ← the rates, false where there are none.
  bool rates(double t, const Eigen::VectorXd& y, Eigen::VectorXd& f) const {
    f.resize(y.size());
    try {
      system_.derivative(t, y, f);
    } catch (...) {  // the run itself will say what is wrong
      return false;
    }
    return f.allFinite();
  }

  // The strongest push of the way at this state.
  void look_later() {
    constexpr int looks = 16;
    constexpr double golden = 0.6180339887498949;  // no period of a drive is a multiple of it
    const double begin = t_;
    Eigen::VectorXd f;
    for (int k = 1; k <= looks; ++k) {
      const double t = begin + 0.999 * way_ * (k * golden - std::floor(k * golden));
      if (rates(t, y_, f) && f.squaredNorm() > f_.squaredNorm()) f_ = f, t_ = t;
    }
  }

  // Whether what pulls each coordinate back shows that all is large enough, but for what borrows from its like.
  bool swing(double enough) {
    Eigen::VectorXd sizes = sizes_;
    for (Eigen::Index i = 0; i < dof_; ++i)
      if (const double q = sizes_[i], a = std::abs(f_[dof_ + i]); q > 0.0 && a > 0.0)
        sizes[dof_ + i] = std::max(sizes[dof_ + i], a * std::min(std::sqrt(q / a), std::abs(way_)));
    const auto large = [&](Eigen::Index begin, Eigen::Index count) {
      if (count == 0) return true;
      if (!(sizes.segment(begin, count).maxCoeff() >= enough)) return false;
      for (Eigen::Index i = begin; i < begin + count; ++i) {
        const bool moves = sizes[i] > 0.0 || f_[i] != 0.0 || (i < dof_ && f_[dof_ + i] != 0.0);
        if (moves && !(sizes[i] >= enough)) return false;
      }
      return true;
    };
    return large(0, dof_) && large(dof_, dof_) && large(2 * dof_, y_.size() - 2 * dof_);
  }

  // Whether the rates keep their sizes over h; what is zero beside its like but for rounding has no voice.
  bool keeps(double h) {
    const double left = 0.999 * std::abs(end_ - t_), later = t_ + std::copysign(std::min(h, left), way_);  // never behind the end
    if (!rates(later, y_ + std::copysign(h, way_) * f_, f_one_)) return false;
    if (!rates(later, y_ + std::copysign(0.5 * h, way_) * (f_ + f_one_), f_two_)) return false;
    constexpr double rounding = 1e-12;
    const auto kept = [&](Eigen::Index begin, Eigen::Index count, double least) {
      if (count == 0) return true;
      const double alike = least * f_.segment(begin, count).cwiseAbs().maxCoeff();
      for (Eigen::Index i = begin; i < begin + count; ++i) {
        const double size = std::max(std::abs(f_[i]), std::abs(f_one_[i]));
        if (size > 0.0 && std::abs(f_two_[i] - f_one_[i]) > size + alike) return false;
      }
      return true;
    };
    return kept(0, dof_, rounding) && kept(dof_, dof_, rounding) && kept(2 * dof_, y_.size() - 2 * dof_, 0.0);
  }

  // Adds what the rates do in the time in which they change.
  void grow() {
    constexpr int most = 100;
    int most_doublings = most;
    const double way = std::abs(way_);
    h_ = way;
    for (Eigen::Index i = 0; i < y_.size(); ++i) {
      if (f_[i] != 0.0 && y_[i] != 0.0) h_ = std::min(h_, std::abs(y_[i] / f_[i]));
      if (i < dof_ && y_[i] != 0.0 && f_[dof_ + i] != 0.0) h_ = std::min(h_, std::sqrt(std::abs(y_[i] / f_[dof_ + i])));
    }
    h_ = std::max(h_ < way ? h_ / 16 : way * 0x1p-20, way * 0x1p-80);
    int tries = 0;
    while (!keeps(h_) && ++tries < most) h_ /= 2;
    for (; tries == 0 && most_doublings > 0 && 2 * h_ <= way && keeps(2 * h_); --most_doublings) h_ *= 2;
    keeps(h_);
    if (!f_one_.allFinite()) return;
    sizes_ = sizes_.cwiseMax(h_ * f_.cwiseAbs().cwiseMax(f_one_.cwiseAbs()));
  }

  // What is zero behind the velocities has no like: the least that is known there.
  void lend(Eigen::Index begin, Eigen::Index count) {
    double least = std::numeric_limits<double>::infinity();
    for (Eigen::Index i = begin; i < begin + count; ++i)
      if (sizes_[i] > 0.0) least = std::min(least, sizes_[i]);
    for (Eigen::Index i = begin; i < begin + count && std::isfinite(least); ++i)
      if (sizes_[i] == 0.0) sizes_[i] = least;
  }

  const DrivenForm& system_;
  double t_, way_, end_;
  Eigen::Index dof_;
  const Eigen::VectorXd& y_;
  Eigen::VectorXd sizes_, f_, f_one_, f_two_;
  double h_ = 0.0;
};

/// The tolerances of a run from (t, y) over `way`, which is not zero, by options that leave them to the run.
template <class Number = double>
[[gnu::cold]] NaturalTolerances natural_tolerances(const DrivenForm& system, const Options& options, double t, const Eigen::VectorXd& y, double way) {
  return NaturalSizes<Number>(system, t, y, way).tolerances(options.rtol, options.atol[0]);
}

#ifdef QDOT_COMPILED
extern template NaturalTolerances natural_tolerances<double>(const DrivenForm&, const Options&, double, const Eigen::VectorXd&, double);
#endif

}  // namespace qdot::detail
