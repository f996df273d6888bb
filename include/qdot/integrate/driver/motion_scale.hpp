#pragma once
// SPDX-License-Identifier: MIT
//
// Absolute tolerances that grow with the motion.
//
// A run whose user gave no absolute tolerance takes one from the start (integrate/driver/natural_tolerances.hpp). A start may be far smaller than what
// follows: a drive that begins with the foot of a bell, 1e-56, or a pendulum beside its upright position. So coordinates, velocities and what else
// is integrated each have a size, and when it doubles, their tolerances grow as much, up to the default. They never fall: what was large once makes
// errors of its own size. Motions of ordinary size have the default from the start, and cost one comparison a step.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "qdot/integrate/driver/natural_tolerances.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/watch/driven_form.hpp"
#include "qdot/mechanics/equations/ordinary_size.hpp"

namespace qdot::detail {

class MotionScale {
 public:
  MotionScale() = default;
  explicit MotionScale(bool is_known) : is_known_(is_known) {}

  bool is_known() const noexcept { return is_known_; }
  bool grows() const noexcept { return grows_; }
  /// What to say of a run that ends without one.
  const char* remark() const noexcept { return is_known_ ? "" : "; nothing moved, so atol = 1e-12 stood for a size that is not known"; }

  /// Whether a motion from (t, y) to t_end asks for other tolerances than the default.
  [[gnu::cold, gnu::noinline]] bool take(const DrivenForm& system, const Options& options, double t, const Eigen::VectorXd& y, double t_end) {
    most_ = options.atol[0];
    dof_ = std::min(system.dof(), y.size() / 2);
    each_.resize(0);
    if (t == t_end) return false;
    const NaturalTolerances found = natural_tolerances(system, options, t, y, t_end - t);
    is_known_ = found.known;
    each_ = found.each;
    grows_ = each_.size() > 0;
    for (int part = 0; part < parts && grows_; ++part) {
      const double largest = count(part) == 0 ? most_ : each_.segment(begin(part), count(part)).maxCoeff();
      sizes_[part] = largest < most_ ? largest / options.rtol : std::numeric_limits<double>::infinity();
    }
    return grows_;
  }

  /// Whether the tolerances have grown for a state y on the way.
  template <class Y>
  bool has_outgrown(const Y& y) {
    bool changed = false;
    for (int part = 0; part < parts; ++part) {
      if (!std::isfinite(sizes_[part])) continue;
      const double size = y.segment(begin(part), count(part)).cwiseAbs().maxCoeff();
      if (!(size > 2.0 * sizes_[part])) continue;
      auto tolerances = each_.segment(begin(part), count(part));
      const double grown = size < ordinary_size ? size : std::numeric_limits<double>::infinity();
      tolerances = (grown / sizes_[part] * tolerances).cwiseMin(most_);
      sizes_[part] = grown;
      changed = true;
    }
    if (changed) grows_ = std::any_of(sizes_, sizes_ + parts, [](double size) { return std::isfinite(size); });
    return changed;
  }
  /// Those of all components, where they are not the default.
  const Eigen::VectorXd& tolerances() const noexcept { return each_; }

 private:
  static constexpr int parts = 3;  // coordinates, velocities, and what else there is

  Eigen::Index begin(int part) const noexcept { return part * dof_; }
  Eigen::Index count(int part) const noexcept { return part < 2 ? dof_ : each_.size() - 2 * dof_; }

  bool is_known_ = true, grows_ = false;
  double most_ = 0.0;
  Eigen::Index dof_ = 0;
  double sizes_[parts] = {};  // infinite: of ordinary size, with the default tolerance
  Eigen::VectorXd each_;
};

}  // namespace qdot::detail
