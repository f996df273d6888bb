#pragma once
// SPDX-License-Identifier: MIT
//
// The graph of a motion and of its parameters, for methods that take the variational equations from there and not from ∂f/∂y.
//
// T, V and forces are run once with the scalar that records (integrate/steps/recorded_motion.hpp), parameters θ of T and V as variables like q and q̇.
// p = ∂L/∂q̇, F, and their derivatives are nodes of that graph: what power series and the tangent map of a symplectic method are made of.

#include <Eigen/Core>
#include <memory>
#include <type_traits>
#include <vector>

#include "qdot/analysis/variations/beginning.hpp"
#include "qdot/analysis/variations/equations.hpp"
#include "qdot/analysis/variations/model.hpp"
#include "qdot/analysis/variations/variations.hpp"
#include "qdot/integrate/steps/form_mechanics.hpp"
#include "qdot/integrate/steps/recorded_motion.hpp"

namespace qdot::detail {

// The graph of a model's motion; θ ← the variables of its parameters.
struct VariationalRecorder {
  virtual ~VariationalRecorder() = default;
  virtual RecordedMotion record(std::vector<int>& theta) const = 0;
  virtual bool holds(RecordedMotion& m, const std::vector<int>& theta) const = 0;
  virtual double parameter(Eigen::Index j) const = 0;
};

template <class Model>
inline constexpr bool is_family_model = false;
template <class Family, class P>
inline constexpr bool is_family_model<FamilyModel<Family, P>> = true;

template <class Model>
class RecorderOf final : public VariationalRecorder {
 public:
  explicit RecorderOf(const Model& model) : model_(&model) {}

  RecordedMotion record(std::vector<int>& theta) const override {
    if constexpr (has_parameters) {
      return recorded_energies(Model::n, [&](RecordedMotion& m) {
        theta = new_variables(m.recording, 2 * Model::n + 1, model_->p.size());
        run(m, theta);
      });
    } else {
      return (void)theta, recorded_motion(model_->form);
    }
  }
  bool holds(RecordedMotion& m, const std::vector<int>& theta) const override {
    if constexpr (has_parameters) {
      return still_holds(m, [&](RecordedMotion& again) { run(again, theta); });
    } else {
      return (void)theta, still_holds(m, model_->form);
    }
  }
  double parameter(Eigen::Index j) const override { return model_->parameter(j); }

 private:
  static constexpr bool has_parameters = requires(const Model& m) { m.energies_of; };

  void run(RecordedMotion& m, const std::vector<int>& theta) const {
    m.recording.source = "T or V";
    run_energies<Model::n>(m, model_->energies_of(recorded_vector<decltype(Model::p)::SizeAtCompileTime>(m.recording, theta)));
  }

  const Model* model_;
};

template <bool jumps>
struct Mechanics<VariationalForm<jumps>> {
  static constexpr int n = Dynamic, states = 0, constraints = 0;
  static constexpr Inertia inertia = Inertia::positive_definite;
};

// Sees to it that a model can be recorded, and records it.
template <class Model>
void attach_recorder(Variations<Model>& equations) {
  using Form = typename Model::Form;
  static_assert(!is_family_model<Model>,
                "qdot: sensitivities by Taylor and Gauss take parameters of T and V, energies_of(p) with duals, but no family of problems; use Dop853");
  if constexpr (requires { Mechanics<Form>::n; }) {
    static_assert(!can_jump<Model> && Mechanics<Form>::states == 0 && Mechanics<Form>::inertia == Inertia::positive_definite,
                  "qdot: sensitivities by Taylor and Gauss take no constraints, contacts, dry friction, massless coordinates or effects with states; use Dop853");
    static_assert(is_recordable<Form>::value,
                  "qdot: sensitivities by Taylor and Gauss run T, V and the effects with a scalar that records operations: take `const auto& q`; or use Dop853");
  } else {
    static_assert(requires { Mechanics<Form>::n; }, "qdot: sensitivities by Taylor and Gauss are those of a system or scene; use Dop853");
  }
  equations.recorder = std::make_shared<RecorderOf<Model>>(equations.model());
}

}  // namespace qdot::detail
