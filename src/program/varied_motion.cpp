// SPDX-License-Identifier: MIT
#include "program/varied_motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "program/first_order_model.hpp"
#include "program/methods.hpp"
#include "program/simulation.hpp"
#include "qdot/analysis/gauss_sensitivity.hpp"
#include "qdot/analysis/taylor_sensitivity.hpp"
#include "qdot/analysis/variations/model.hpp"
#include "qdot/analysis/variations/slope.hpp"
#include "qdot/analysis/variations/variations.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

// Φ keeps what constraints demand of it as far as it is integrated.
template <>
inline constexpr bool qdot::detail::projects_columns<qdot::program::SwitchingModel> = false;
template <>
inline constexpr bool qdot::detail::begins_with_velocities<qdot::program::SwitchingModel> = true;

namespace qdot::program {

namespace {

// The models of a VariedModel, one for each value of its parameters: at most one of them is displaced.
struct ModelFamily {
  struct Member {
    SwitchingModel system;
    EventList<> events = {};
  };
  const VariedModel* of;

  Member operator()(const Eigen::VectorXd& p) const {
    for (Eigen::Index j = 0; j < p.size(); ++j)
      if (const double value = of->parameters[static_cast<std::size_t>(j)]; p[j] != value) return {{{{of->with_parameter(j, p[j])}}}};
    return {{{{of->model}}}};
  }
};
using Models = qdot::detail::FamilyModel<ModelFamily, Eigen::VectorXd>;
using ModelVariations = qdot::detail::Variations<Models>;

// The graphs of the models.
class ModelRecorder final : public qdot::detail::VariationalRecorder {
 public:
  explicit ModelRecorder(const Models& models) : models_(models) {}

  bool holds(qdot::detail::RecordedVariations&) const override { return true; }  // models do not change
  double parameter(Eigen::Index) const override { return 0.0; }

 private:
  qdot::detail::RecordedMotion motion(std::vector<int>&) const override { return std::move(*models_.form.model->recorded_motion()); }
  Eigen::Index differenced() const override { return models_.parameters(); }
  void for_each_neighbour(Eigen::Index j, qdot::detail::RecordedMotion& m,
                          const std::function<void(qdot::detail::RecordedMotion&, double)>& use) const override {
    models_.for_each_neighbour(j, [&](const SwitchingModel& member, double weight) {
      const auto near = member.model->recorded_on(m.recording);
      use(*near, weight);
      m.recording = std::move(near->recording);
    });
  }

  const Models& models_;
};

// [y; Φ] at the start: Φ is what a displaced start becomes on the constraints.
Eigen::VectorXd begun(ModelVariations& equations, double t, const Eigen::VectorXd& y, const Options& options) {
  const Eigen::Index size = equations.state_size(), starts = equations.start_columns();
  equations.rtol = options.rtol;
  equations.atol = qdot::detail::each_atol(options, size);
  Eigen::VectorXd both = equations.seeded(y);
  if (!equations.form().model->is_constrained()) return both;
  for (Eigen::Index j = 0; j < equations.columns(); ++j) {
    const Eigen::VectorXd along = both.segment(size * (j + 1), size);
    const auto projected = [&](double s) {
      Eigen::VectorXd near = y + s * along;
      equations.model().with_form(j - starts, s, [&](const SwitchingModel& form) { form.project(t, near); });
      return near;
    };
    const double reach = j < starts ? std::max(1e-3, y.head(2 * equations.dof()).cwiseAbs().maxCoeff()) : equations.parameter_size(j);
    if (const auto slope = qdot::detail::slope_at_zero(projected, reach)) both.segment(size * (j + 1), size) = *slope;
  }
  return both;
}

}  // namespace

VariedMotion varied_motion(const VariedModel& of, double t0, const Eigen::VectorXd& y0, double t_end, Options options, const VariedMethod& method) {
  using qdot::detail::Changes, qdot::detail::VariationalForm;
  if (const std::string why = variation_misfit(*of.model, method.name); !why.empty()) throw InvalidValue(method.name + " " + why);
  options.keep_trajectory = false;
  ModelVariations equations(
      Models({&of}, Eigen::Map<const Eigen::VectorXd>(of.parameters.data(), static_cast<Eigen::Index>(of.parameters.size()))),
      of.with_start, false);
  const Eigen::VectorXd both = begun(equations, t0, y0, options);
  const Eigen::Index size = equations.state_size(), columns = equations.columns();
  if (options.atol.size() > 1) {
    Eigen::VectorXd each(both.size());
    for (Eigen::Index i = 0; i < each.size(); ++i) each[i] = options.atol[i % size];
    options.atol = each;
  }
  const auto record = [&] { equations.recorder = std::make_shared<ModelRecorder>(equations.model()); };
  const auto run_of = [&](const auto& form, const auto& with) { return simulate(form, FirstOrderState{t0, both}, t_end, with, options); };
  const Run<Dynamic> run = [&]() -> Run<Dynamic> {
    const VariationalForm<Changes::phases> any(equations);
    const VariationalForm<Changes::projections> formulas(equations);
    const MethodInfo& info = method_named(method.name);
    switch (info.kind) {
      case MethodKind::stiff: return run_of(any, CvodeBdf{});
      case MethodKind::multistep: return run_of(VariationalForm<Changes::none>(equations), CvodeAdams{});
      case MethodKind::series: return record(), run_of(formulas, Taylor{});
      case MethodKind::gauss: return record(), run_of(formulas, Gauss{.step = method.step, .stages = info.order / 2});
      default: return info.name == "dopri5" ? run_of(any, Dopri5{}) : run_of(any, Dop853{});
    }
  }();
  VariedMotion motion{run.outcome,      run.message, run.t,
                      run.y.head(size), {},          Eigen::Map<const Eigen::MatrixXd>(run.y.data() + size, size, columns),
                      run.samples.t,    {}};
  motion.ydot = equations.state_rate(run.t, motion.y);
  for (Eigen::Index k = 0; k < run.samples.y.cols(); ++k) motion.samples.emplace_back(run.samples.y.col(k));
  return motion;
}

std::string variation_misfit(const Model& model, const std::string& method) {
  const MethodKind kind = method_named(method).kind;
  if (kind == MethodKind::automatic) return "chooses by the motion alone";
  if (kind == MethodKind::splitting || kind == MethodKind::rattle) return "makes steps of the motion alone";
  if (std::string why = misfit(model, method); !why.empty() || (kind != MethodKind::series && kind != MethodKind::gauss)) return why;
  if (model.guard_count() > 0) return "takes no contacts or dry friction with derivatives";
  if (model.size() > 2 * model.dof()) return "takes no effects with states with derivatives";
  return misfit(model, "taylor");  // of what is recorded
}

std::vector<std::string> varying_methods(const Model& model) {
  std::vector<std::string> names = method_names();
  std::erase_if(names, [&](const std::string& name) { return !variation_misfit(model, name).empty(); });
  return names;
}

Eigen::VectorXd settled(const Model& model, double t, Eigen::VectorXd y) {
  if (model.is_constrained()) model.project(t, y);
  if (model.guard_count() > 0) {
    const Eigen::VectorXd before = y;
    Eigen::VectorXd resolution(y.size());
    for (Eigen::Index i = 0; i < y.size(); ++i) resolution[i] = 1e-13 * std::abs(y[i]) + 1e-14;
    model.switched(t, y, std::vector<bool>(static_cast<std::size_t>(model.guard_count())), resolution);
    y.head(2 * model.dof()) = before.head(2 * model.dof());
  }
  return y;
}

}  // namespace qdot::program
