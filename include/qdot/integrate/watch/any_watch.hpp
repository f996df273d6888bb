#pragma once
// SPDX-License-Identifier: MIT
//
// A watchdog (integrate/watch/watch.hpp) without the type of what it looks at.
//
// A watchdog wants to know T, V and effects: which numbers they must have, what they ask of the time, whether M loses its inertia. The loop of a run
// does not, and is compiled once for many systems: it holds the watchdog by calls. If what is run has more components than the form that is watched,
// they stand behind those and are not looked at.

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "qdot/integrate/moment.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/statistics.hpp"
#include "qdot/integrate/steps/polynomial.hpp"
#include "qdot/integrate/watch/watch.hpp"

namespace qdot::detail {

/// The members are those of Watchdog.
class AnyWatch {
 public:
  virtual ~AnyWatch() = default;
  virtual bool is_due(double h) = 0;
  virtual void begin(double t, const Eigen::VectorXd& y, long steps) = 0;
  virtual bool watches_time() const = 0;  // otherwise nobody need ask for reach()
  virtual double reach(double t, const Eigen::Ref<const Eigen::VectorXd>& y, double landing, bool switches_only) = 0;
  virtual double first_shown(double t) const = 0;
  virtual bool may_pass_branches(double t, const Eigen::VectorXd& y) = 0;
  virtual Passage passage(const Clock& clock, const PolynomialView& step, double from, double to, bool on_one_branch) = 0;
  bool sees_branches = true;  // false: steps need not be asked about
  virtual std::optional<Failure> look(double t, const Eigen::VectorXd& y, long steps, bool controlled) = 0;
  virtual std::optional<Failure> look_at_values_and_mass(double t, const Eigen::VectorXd& y) = 0;
  virtual std::optional<Failure> change(double t) = 0;
  virtual void remember(double t, const Eigen::VectorXd& y) = 0;
  virtual std::optional<Failure> verdict() const = 0;
  virtual double mass_rcond() const = 0;
  virtual void report(Statistics& statistics) const = 0;
};

/// The watchdog of a first-order form, whose components are the first of y.
template <class Form>
class WatchOf final : public AnyWatch {
 public:
  WatchOf(const Form& form, const Options& options) : dog_(form, options), own_(form.size()) {}

  bool is_due(double h) override { return dog_.is_due(h); }
  void begin(double t, const Eigen::VectorXd& y, long steps) override { dog_.begin(t, own(y), steps); }
  bool watches_time() const override { return Watchdog<Form>::watches_time; }
  double reach(double t, const Eigen::Ref<const Eigen::VectorXd>& y, double landing, bool switches_only) override {
    for (Eigen::Index i = 0; i < own_.size(); ++i) own_[i] = y[i];
    return dog_.reach(t, own_, landing, switches_only);
  }
  double first_shown(double t) const override { return dog_.first_shown(t); }
  bool may_pass_branches(double t, const Eigen::VectorXd& y) override { return sees_branches = dog_.may_pass_branches(t, own(y)); }
  Passage passage(const Clock& clock, const PolynomialView& step, double from, double to, bool on_one_branch) override {
    return dog_.passage(clock, step, from, to, on_one_branch);
  }
  std::optional<Failure> look(double t, const Eigen::VectorXd& y, long steps, bool controlled) override {
    return dog_.look(t, own(y), steps, controlled);
  }
  std::optional<Failure> look_at_values_and_mass(double t, const Eigen::VectorXd& y) override { return dog_.look_at_values_and_mass(t, own(y)); }
  std::optional<Failure> change(double t) override { return dog_.change(t); }
  void remember(double t, const Eigen::VectorXd& y) override { dog_.remember(t, own(y)); }
  std::optional<Failure> verdict() const override { return dog_.verdict(); }
  double mass_rcond() const override { return dog_.mass_rcond(); }
  void report(Statistics& statistics) const override { dog_.report(statistics); }

 private:
  const Eigen::VectorXd& own(const Eigen::VectorXd& y) {
    if (y.size() == own_.size()) return y;
    for (Eigen::Index i = 0; i < own_.size(); ++i) own_[i] = y[i];
    return own_;
  }

  Watchdog<Form> dog_;
  Eigen::VectorXd own_;
};

}  // namespace qdot::detail
