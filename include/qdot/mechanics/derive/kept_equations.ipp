#pragma once
// SPDX-License-Identifier: MIT
//
// The function of kept_equations.hpp: what a form keeps is a TracedJacobian for each combination of phases (traced_jacobian.hpp). A program that links
// qdot::compiled has it from there.

#include <Eigen/Core>
#include <atomic>
#include <memory>
#include <span>

#include "qdot/mechanics/derive/kept_equations.hpp"
#include "qdot/mechanics/derive/kept_motion.hpp"
#include "qdot/mechanics/derive/recordable_form.hpp"
#include "qdot/mechanics/derive/traced_jacobian.hpp"
#include "qdot/mechanics/derive/traced_motion.hpp"

namespace qdot::detail {

/// The Jacobians of a form of which n coordinates are known at compile time, or Dynamic.
template <int n>
class TracedJacobians final : public AnyJacobians {
 public:
  TracedJacobians() = default;
  TracedJacobians(const TracedJacobians& other) : kept_(other.kept_) {}

  std::unique_ptr<AnyJacobians> copy() const override { return std::make_unique<TracedJacobians>(*this); }
  bool write(const RecordableForm& form, std::span<const double> phases, double t, const double* y, double* ydot,
             Eigen::Ref<Eigen::MatrixXd> out) override {
    if (const TracedJacobian<n>* const ready = ready_.load(std::memory_order_acquire)) return ready->write_by_lines(t, y, ydot, out);
    return kept_.use(phases, [&] { return std::make_unique<TracedJacobian<n>>(traced_equations(form, phases), form.limits); },
                     [&](TracedJacobian<n>& jacobian) {
                       if (phases.empty() && jacobian.is_solved()) ready_.store(&jacobian, std::memory_order_release);
                       return jacobian.write(t, y, ydot, out);
                     });
  }
  void renew(const RecordableForm& form) override {
    ready_.store(nullptr, std::memory_order_relaxed);
    kept_.renew(form);
  }

 private:
  KeptMotion<TracedJacobian<n>> kept_;
  std::atomic<const TracedJacobian<n>*> ready_{nullptr};  // of forms without phases: that of kept_, if it needs no lock
};

template <int n>
[[gnu::cold]] std::unique_ptr<AnyJacobians> traced_jacobians() {
  return std::make_unique<TracedJacobians<n>>();
}

}  // namespace qdot::detail
