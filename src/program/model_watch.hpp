#pragma once
// SPDX-License-Identifier: MIT
//
// The library's watchdog (integrate/watch/watch.hpp) for a model: it wants to know T and V, which only the scene's own .cpp does.

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "qdot/integrate/options.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/statistics.hpp"
#include "qdot/integrate/watch/watch.hpp"

namespace qdot::program {

/// A watchdog without the type of what it looks at. The members are those of qdot::detail::Watchdog.
class ModelWatch {
 public:
  virtual ~ModelWatch() = default;
  virtual bool is_due(double h) = 0;
  virtual void begin(double t, const Eigen::VectorXd& y, long steps) = 0;
  virtual double reach(double t, const Eigen::VectorXd& y, double landing) = 0;
  virtual std::optional<Failure> look(double t, const Eigen::VectorXd& y, long steps, bool controlled) = 0;
  virtual std::optional<Failure> look_at_values_and_mass(double t, const Eigen::VectorXd& y) = 0;
  virtual std::optional<Failure> change(double t) = 0;
  virtual void remember(double t, const Eigen::VectorXd& y) = 0;
  virtual double mass_rcond() const = 0;
  virtual void report(Statistics& statistics) const = 0;
};

/// The watchdog of a model's first-order form.
template <class Form>
class WatchOf final : public ModelWatch {
 public:
  WatchOf(const Form& form, const Options& options) : dog_(form, options) {}

  bool is_due(double h) override { return dog_.is_due(h); }
  void begin(double t, const Eigen::VectorXd& y, long steps) override { dog_.begin(t, y, steps); }
  double reach(double t, const Eigen::VectorXd& y, double landing) override { return dog_.reach(t, y, landing); }
  std::optional<Failure> look(double t, const Eigen::VectorXd& y, long steps, bool controlled) override {
    return dog_.look(t, y, steps, controlled);
  }
  std::optional<Failure> look_at_values_and_mass(double t, const Eigen::VectorXd& y) override { return dog_.look_at_values_and_mass(t, y); }
  std::optional<Failure> change(double t) override { return dog_.change(t); }
  void remember(double t, const Eigen::VectorXd& y) override { dog_.remember(t, y); }
  double mass_rcond() const override { return dog_.mass_rcond(); }
  void report(Statistics& statistics) const override { dog_.report(statistics); }

 private:
  qdot::detail::Watchdog<Form> dog_;
};

/// What a run holds: the model's own watchdog.
class HeldWatch {
 public:
  template <class System>
  HeldWatch(const System& system, const Options& options) : watch_(system.model->watch(options)) {}

  bool is_due(double h) { return watch_->is_due(h); }
  void begin(double t, const Eigen::VectorXd& y, long steps) { watch_->begin(t, y, steps); }
  template <Stepper S>
  double reach(const S& stepper, double landing) {
    return qdot::detail::has_fixed_step(stepper) ? landing : watch_->reach(stepper.t(), stepper.y(), landing);
  }
  std::optional<Failure> look(double t, const Eigen::VectorXd& y, long steps, bool controlled) {
    return watch_->look(t, y, steps, controlled);
  }
  std::optional<Failure> look_at_values_and_mass(double t, const Eigen::VectorXd& y) { return watch_->look_at_values_and_mass(t, y); }
  std::optional<Failure> change(double t) { return watch_->change(t); }
  void remember(double t, const Eigen::VectorXd& y) { watch_->remember(t, y); }
  double mass_rcond() const { return watch_->mass_rcond(); }
  void report(Statistics& statistics) const { watch_->report(statistics); }

 private:
  std::unique_ptr<ModelWatch> watch_;
};

}  // namespace qdot::program
