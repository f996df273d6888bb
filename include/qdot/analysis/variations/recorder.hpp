#pragma once
// SPDX-License-Identifier: MIT
//
// The graph of a motion and of what it depends on, for methods that take the variational equations from there and not from ∂f/∂y.
//
// T, V, forces and constraints are run once with the scalar that records (integrate/steps/recorded_motion.hpp), parameters θ of T and V as variables like
// q and q̇. p = ∂L/∂q̇, F, the rows of constraints, and their derivatives are nodes of that graph: what power series and the tangent map of a symplectic
// method are made of.
//
// The members of a family take numbers only. They are recorded on the same graph, where equal formulas are one node, and
//
//     ∂F/∂p_j  =  Σ wᵢ (Fᵢ − F)          with the weights of the difference of order six (slope.hpp)
//
// is a node like any other. A row that does not ask for p_j is the same node in all members, and its slope is zero before anything is computed.

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "qdot/analysis/variations/beginning.hpp"
#include "qdot/analysis/variations/equations.hpp"
#include "qdot/analysis/variations/model.hpp"
#include "qdot/analysis/variations/variational_form.hpp"
#include "qdot/analysis/variations/variations.hpp"
#include "qdot/integrate/steps/form_mechanics.hpp"
#include "qdot/integrate/steps/recorded_motion.hpp"

namespace qdot::detail {

// What some rows of equations depend on; numbers of nodes.
struct RecordedVariations {
  RecordedMotion motion = {};
  std::vector<int> theta = {};   // variables of the parameters of T and V
  std::vector<int> x = {};       // q, q̇, θ
  Eigen::Index parameters = 0;   // θ, or those of a family
  std::vector<int> slopes = {};  // of the rows by q, q̇ and the parameters, row by row
};

class VariationalRecorder {
 public:
  virtual ~VariationalRecorder() = default;

  // The motion, and the slopes of rows_of(motion, first), which may call variables by the number `first` and those behind it.
  //
  // @throws NotAnalytic  T, V, a force or a constraint compares values or has a kink
  RecordedVariations recorded(const std::function<std::vector<int>(RecordedMotion&, int)>& rows_of) const;
  virtual bool holds(RecordedVariations& v) const = 0;
  virtual double parameter(Eigen::Index j) const = 0;

 private:
  using Use = std::function<void(RecordedMotion&, double weight)>;

  virtual RecordedMotion motion(std::vector<int>& theta) const = 0;
  // Of a family: how many parameters, and members with the weights of a slope, recorded beside m.
  virtual Eigen::Index differenced() const { return 0; }
  virtual void for_each_neighbour(Eigen::Index, RecordedMotion&, const Use&) const {}
};

inline RecordedVariations VariationalRecorder::recorded(const std::function<std::vector<int>(RecordedMotion&, int)>& rows_of) const {
  RecordedVariations v;
  v.motion = motion(v.theta);
  RecordedMotion& m = v.motion;
  for (const auto* list : {&m.q, &m.qdot, &v.theta}) v.x.insert(v.x.end(), list->begin(), list->end());
  const int first = static_cast<int>(v.x.size()) + 1;
  const std::vector<int> rows = rows_of(m, first);
  std::vector<std::vector<int>> by_family(static_cast<std::size_t>(differenced()), std::vector<int>(rows.size(), m.recording.graph.constant(0.0)));
  for (std::size_t j = 0; j < by_family.size(); ++j)
    for_each_neighbour(static_cast<Eigen::Index>(j), m, [&](RecordedMotion& nearby, double weight) {
      const std::vector<int> there = rows_of(nearby, first);
      formula::Graph& graph = nearby.recording.graph;
      for (std::size_t i = 0; i < rows.size(); ++i) by_family[j][i] = graph.sum(by_family[j][i], graph.scaled(graph.difference(there[i], rows[i]), weight));
    });
  v.parameters = static_cast<Eigen::Index>(v.theta.size() + by_family.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::vector<int> row = m.recording.graph.gradient(rows[i], v.x);
    v.slopes.insert(v.slopes.end(), row.begin(), row.end());
    for (const std::vector<int>& column : by_family) v.slopes.push_back(column[i]);
  }
  return v;
}

template <class Model>
class RecorderOf final : public VariationalRecorder {
 public:
  explicit RecorderOf(const Model& model) : model_(&model) {}

  bool holds(RecordedVariations& v) const override {
    return still_holds(v.motion, [&](RecordedMotion& again) {
      if constexpr (has_parameters) run(again, v.theta);
      else run_again(again, model_->form);
      for (Eigen::Index j = 0; j < differenced(); ++j) for_each_member(j, [&](const auto& form, double) { run_again(again, form); });
    });
  }
  double parameter(Eigen::Index j) const override { return model_->parameter(j); }

 private:
  static constexpr bool has_parameters = requires(const Model& m) { m.energies_of; };

  RecordedMotion motion(std::vector<int>& theta) const override {
    if constexpr (has_parameters) {
      return recorded_energies(Model::n, [&](RecordedMotion& m) {
        theta = new_variables(m.recording, 2 * Model::n + 1, model_->p.size());
        run(m, theta);
      });
    } else {
      return (void)theta, recorded_motion(model_->form);
    }
  }
  void run(RecordedMotion& m, const std::vector<int>& theta) const {
    m.recording.source = "T or V";
    run_energies<Model::n>(m, model_->energies_of(recorded_vector<decltype(Model::p)::SizeAtCompileTime>(m.recording, theta)));
  }

  Eigen::Index differenced() const override { return is_family_model<Model> ? model_->parameters() : 0; }
  void for_each_neighbour(Eigen::Index j, RecordedMotion& m, const std::function<void(RecordedMotion&, double)>& use) const override {
    for_each_member(j, [&](const auto& form, double weight) {
      RecordedMotion nearby = recorded_motion(form, std::move(m.recording));
      use(nearby, weight);
      m.recording = std::move(nearby.recording);
      m.returned.insert(m.returned.end(), nearby.returned.begin(), nearby.returned.end());
    });
  }
  template <class Use>
  void for_each_member(Eigen::Index j, const Use& use) const {
    if constexpr (is_family_model<Model>) model_->for_each_neighbour(j, use);
  }

  const Model* model_;
};

template <Changes changes>
struct Mechanics<VariationalForm<changes>> {
  static constexpr int n = Dynamic, states = 0, constraints = changes == Changes::none ? 0 : Dynamic;
  static constexpr Inertia inertia = Inertia::positive_definite;
};

// Sees to it that a model can be recorded, and records it.
template <class Model>
void attach_recorder(Variations<Model>& equations) {
  using Form = typename Model::Form;
  if constexpr (requires { Mechanics<Form>::n; }) {
    static_assert(!SwitchingSystem<Form> && Mechanics<Form>::states == 0 && Mechanics<Form>::inertia == Inertia::positive_definite,
                  "qdot: sensitivities by Taylor and Gauss take no contacts, dry friction, massless coordinates or effects with states; use Dop853");
    static_assert(is_recordable<Form>::value,
                  "qdot: sensitivities by Taylor and Gauss run T, V and the effects with a scalar that records operations: take `const auto& q`; or use Dop853");
  } else {
    static_assert(requires { Mechanics<Form>::n; }, "qdot: sensitivities by Taylor and Gauss are those of a system or scene; use Dop853");
  }
  equations.recorder = std::make_shared<RecorderOf<Model>>(equations.model());
}

}  // namespace qdot::detail
