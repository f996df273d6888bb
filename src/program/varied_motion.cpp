// SPDX-License-Identifier: MIT
#include "program/varied_motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
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

// Columns of Φ ← what consistent starts are to first order, where y is on the constraints itself.
void put_onto_tangents(const ModelVariations& equations, double t, Eigen::VectorXd& both) {
  const Model& model = *equations.form().model;
  const Eigen::Index size = equations.state_size(), columns = equations.columns(), first = columns - equations.model().parameters(), n = equations.dof();
  const Eigen::VectorXd y = both.head(size);
  const qdot::detail::ConstraintsAt rows = model.constraints_at(t, y);
  Eigen::Map<Eigen::MatrixXd> Phi(both.data() + size, size, columns);
  Eigen::MatrixXd J = rows.slopes.rightCols(n);  // of positions
  for (Eigen::Index i = 0; i < J.rows(); ++i)
    if (!rows.holonomic[static_cast<std::size_t>(i)]) J.row(i).setZero();
  const auto put = [&](Eigen::Index place, Eigen::MatrixXd off, const auto& rows_of) {
    for (Eigen::Index j = first; j < columns; ++j) {
      Eigen::VectorXd by_parameter = Eigen::VectorXd::Zero(off.rows());
      equations.model().add_parameter_slope(j - first, [&](const SwitchingModel& form) { return rows_of(form.model->constraints_at(t, y)); }, by_parameter);
      off.col(j) += by_parameter;
    }
    if (const Eigen::MatrixXd ways = model.displacements(t, y, -off); ways.cols() > 0) Phi.middleRows(place, n) += ways;
  };
  put(0, J * Phi.topRows(n), [](const qdot::detail::ConstraintsAt& at) { return at.phi; });
  put(n, rows.slopes * Phi.topRows(2 * n), [](const qdot::detail::ConstraintsAt& at) { return at.velocity; });
}

// The derivatives of the projections where y had to be moved onto the constraints: there the displacement itself depends on where
// it begins.
void difference_projections(const ModelVariations& equations, const VariedModel& of, double t, const Eigen::VectorXd& given, Eigen::VectorXd& both) {
  const Eigen::Index size = equations.state_size(), starts = equations.start_columns(), n = equations.dof();
  const Eigen::VectorXd y = both.head(size);
  const Eigen::VectorXd beside = qdot::detail::sizes_beside(y.cwiseAbs().cwiseMax(given.cwiseAbs()), n);
  for (Eigen::Index j = 0; j < equations.columns(); ++j) {
    const auto projected = [&](double s) {
      Eigen::VectorXd near = given;
      if (j < starts) near[j] += s;
      else near.head(2 * n) = of.given(j - starts, of.parameters[static_cast<std::size_t>(j - starts)] + s).head(2 * n);
      equations.model().with_form(j - starts, s, [&](const SwitchingModel& form) { form.project(t, near); });
      return near;
    };
    const double far = j < starts ? beside[j] : equations.parameter_size(j);
    const auto slope = qdot::detail::slope_at_zero(projected, far > 0.0 ? far : 1.0, {}, beside);
    if (!slope)
      throw InvalidValue("a start that is off the constraints must come onto them smoothly where it is differentiated, but by " + equations.column_name(j) +
                         " it does not; give a start on the constraints");
    both.segment(size * (j + 1), size) = *slope;
  }
}

// [y; Φ] at the start: Φ is what a displaced start becomes on the constraints.
Eigen::VectorXd begun(ModelVariations& equations, const VariedModel& of, double t, const Eigen::VectorXd& y, const Options& options) {
  const Eigen::Index size = equations.state_size(), starts = equations.start_columns(), n = equations.dof();
  equations.rtol = options.rtol;
  equations.began = t;
  equations.atol = qdot::detail::each_atol(options, size);
  Eigen::VectorXd both = equations.seeded(y), given = y;
  for (Eigen::Index j = starts; of.given && j < equations.columns(); ++j) {
    const double value = of.parameters[static_cast<std::size_t>(j - starts)];
    const auto slope = qdot::detail::slope_at_zero([&](double s) { return of.given(j - starts, value + s); },
                                                   std::ldexp(qdot::detail::parameter_step(value), 8));
    if (!slope) throw InvalidValue("the start of a scene must have a derivative with respect to its parameters, but has none by " + equations.column_name(j));
    both.segment(size * (j + 1), 2 * n) = slope->head(2 * n);
  }
  if (!equations.form().model->is_constrained()) return both;
  if (of.given) given.head(2 * n) = of.given(-1, 0.0).head(2 * n);
  const auto moved = [&](Eigen::Index first) {
    constexpr double near = 1e-10;  // to which tangents are known there
    return (y - given).segment(first, n).cwiseAbs().maxCoeff() > near * y.segment(first, n).cwiseAbs().maxCoeff();
  };
  if (moved(0) || moved(n)) difference_projections(equations, of, t, given, both);
  else put_onto_tangents(equations, t, both);
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
  const Eigen::VectorXd both = begun(equations, of, t0, y0, options);
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
  return formula_misfit(model);
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
