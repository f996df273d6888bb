#pragma once
// SPDX-License-Identifier: MIT
//
// Sensitivities by power series.
//
//     const auto s = sensitivities(system, start, 3.0, Taylor{}, {.rtol = 1e-13, .atol = 1e-14});
//
// Lagrange's equations are differentiated along the motion, and their series made with the motion's (analysis/variations/variation_series.hpp).
//
// The steps, their tests and their dense output are those of integrate/taylor.hpp; events and saltation those of analysis/sensitivity.hpp.

#include <Eigen/Core>
#include <memory>
#include <type_traits>
#include <vector>

#include "qdot/analysis/sensitivity.hpp"
#include "qdot/analysis/variations/variation_series.hpp"
#include "qdot/integrate/taylor.hpp"

namespace qdot::detail {

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
template <>
struct is_recordable<VariationalForm<false>> : std::true_type {};

/// The power series of a motion and of its derivatives.
template <bool jumps>
class LagrangeSeries<VariationalForm<jumps>> : public VariationSeries {
 public:
  /// @throws NotAnalytic  T, V or a force compares values or has a kink
  LagrangeSeries(const VariationalForm<jumps>& form, int highest_order) : VariationSeries(form.equations(), highest_order) {}

  void renew(const VariationalForm<jumps>&) { VariationSeries::renew(); }
  bool is_of(const VariationalForm<jumps>&) { return is_current(); }
};

// What the series needs of a model.
template <class Model>
struct Preparation<Taylor, Model> {
  static void prepare(Variations<Model>& equations) {
    using Form = typename Model::Form;
    static_assert(!is_family_model<Model>,
                  "qdot: sensitivities by Taylor take parameters of T and V, energies_of(p) with duals, but no family of problems; use Dop853");
    if constexpr (requires { Mechanics<Form>::n; }) {
      static_assert(!can_jump<Model> && Mechanics<Form>::states == 0 && Mechanics<Form>::inertia == Inertia::positive_definite,
                    "qdot: sensitivities by Taylor take no constraints, contacts, dry friction, massless coordinates or effects with states; use Dop853");
      static_assert(is_recordable<Form>::value,
                    "qdot: sensitivities by Taylor run T, V and the effects with a scalar that records operations: take `const auto& q`; or use Dop853");
    } else {
      static_assert(requires { Mechanics<Form>::n; }, "qdot: sensitivities by Taylor are those of a system or scene; use Dop853");
    }
    equations.recorder = std::make_shared<RecorderOf<Model>>(equations.model());
  }
};

}  // namespace qdot::detail
