// SPDX-License-Identifier: MIT
#include "program/varied_motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "program/methods.hpp"
#include "program/simulation.hpp"
#include "qdot/analysis/gauss_sensitivity.hpp"
#include "qdot/analysis/taylor_sensitivity.hpp"
#include "qdot/analysis/variations/equations.hpp"
#include "qdot/analysis/variations/slope.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

namespace qdot::program {

namespace {

using qdot::detail::sentence, qdot::detail::slope_points;

// A parameter and the models beside its value, by which f is differenced.
struct Neighbours {
  double h = 0.0;
  const qdot::detail::SlopePoints* points = nullptr;
  std::vector<std::shared_ptr<const Model>> models;
};

Neighbours neighbours_of(const VariedModel& of, Eigen::Index j) {
  const double p = of.parameters[static_cast<std::size_t>(j)];
  std::string trouble;
  for (const qdot::detail::SlopePoints& points : slope_points) {
    Neighbours near{qdot::detail::parameter_step(p), &points, {}};
    try {
      for (const double at : points.at) near.models.push_back(at == 0.0 ? of.model : of.with_parameter(j, p + at * near.h));
      return near;
    } catch (const Error& error) {
      trouble = error.what();
    }
  }
  throw InvalidValue("a parameter must have values on one side of it at least, to be varied, but " + trouble);
}

// The graphs of the models.
class ModelRecorder final : public qdot::detail::VariationalRecorder {
 public:
  ModelRecorder(const Model& model, const std::vector<Neighbours>& neighbours) : model_(model), neighbours_(neighbours) {}

  bool holds(qdot::detail::RecordedVariations&) const override { return true; }  // models do not change
  double parameter(Eigen::Index) const override { return 0.0; }

 private:
  qdot::detail::RecordedMotion motion(std::vector<int>&) const override { return std::move(*model_.recorded_motion()); }
  Eigen::Index differenced() const override { return static_cast<Eigen::Index>(neighbours_.size()); }
  void for_each_neighbour(Eigen::Index j, qdot::detail::RecordedMotion& m, const std::function<void(qdot::detail::RecordedMotion&, double)>& use) const override {
    const Neighbours& of = neighbours_[static_cast<std::size_t>(j)];
    for (std::size_t i = 1; i < of.models.size(); ++i) {
      const auto near = of.models[i]->recorded_on(m.recording);
      use(*near, of.points->weight[i] / of.h);
      m.recording = std::move(near->recording);
    }
  }

  const Model& model_;
  const std::vector<Neighbours>& neighbours_;
};

class ModelVariations final : public qdot::detail::VariationalEquations {
  using Surface = qdot::detail::Surface;

 public:
  explicit ModelVariations(const VariedModel& of) : of_(of), model_(*of.model) {
    size_ = model_.size();
    dof_ = model_.dof();
    if (of.with_start)
      for (Eigen::Index i = 0; i < 2 * dof_; ++i) entries_.push_back(i);
    starts_ = static_cast<Eigen::Index>(entries_.size());
    columns_ = starts_ + static_cast<Eigen::Index>(of.parameters.size());
    for (Eigen::Index j = 0; j < columns_ - starts_; ++j) neighbours_.push_back(neighbours_of(of, j));
    J_.resize(size_, size_);
    rate_.resize(size_);
    largest_.setZero(size_);
  }

  void record() { recorder = std::make_shared<ModelRecorder>(model_, neighbours_); }

  // [y; Φ] at the start: Φ is what a displaced start becomes on the constraints.
  Eigen::VectorXd begun(double t, const Eigen::VectorXd& y, const Options& options) {
    tolerances.push_back(options.rtol);
    for (Eigen::Index i = 0; i < size_; ++i) tolerances.push_back(options.atol[i]);
    Eigen::VectorXd both = Eigen::VectorXd::Zero(size());
    both.head(size_) = y;
    for (Eigen::Index j = 0; j < starts_; ++j) both[size_ * (j + 1) + entries_[static_cast<std::size_t>(j)]] = 1.0;
    if (!model_.constrained()) return both;
    for (Eigen::Index j = 0; j < columns_; ++j) {
      const Eigen::VectorXd along = both.segment(size_ * (j + 1), size_);
      const auto slope = qdot::detail::slope_at_zero(
          [&](double s) {
            Eigen::VectorXd near = y + s * along;
            with_model(j, s, [&](const Model& model) { model.project(t, near); });
            return near;
          },
          reach_of(y, j));
      if (slope) both.segment(size_ * (j + 1), size_) = *slope;
    }
    return both;
  }

  void write_rates(double t, const double* y, double* ydot) const override {
    const Eigen::Map<const Eigen::VectorXd> state(y, size_);
    const Eigen::Map<const Eigen::MatrixXd> Phi(y + size_, size_, columns_);
    Eigen::Map<Eigen::VectorXd> f(ydot, size_);
    Eigen::Map<Eigen::MatrixXd> rate(ydot + size_, size_, columns_);
    write_state_rates(t, y, ydot);
    model_.jacobian(t, state, J_);
    rate.topRows(dof_) = Phi.middleRows(dof_, dof_);
    rate.bottomRows(size_ - dof_).noalias() = J_.bottomRows(size_ - dof_).lazyProduct(Phi);
    for (std::size_t j = 0; j < neighbours_.size(); ++j) {
      const Neighbours& near = neighbours_[j];
      slope_.setZero(size_);
      for (std::size_t i = 1; i < near.models.size(); ++i) {
        near.models[i]->derivative(t, state, rate_);
        if (i == 1) first_ = rate_;
        if (i == 2 && near.points->central && rate_ == first_) {  // f does not ask for this parameter
          slope_.setZero();
          break;
        }
        slope_ += near.points->weight[i] / near.h * (rate_ - f);
      }
      rate.col(starts_ + static_cast<Eigen::Index>(j)) += slope_;
    }
  }
  void write_state_rates(double t, const double* y, double* ydot) const override {
    for (Eigen::Index i = 0; i < size_; ++i) largest_[i] = std::max(largest_[i], std::abs(y[i]));
    Eigen::Map<Eigen::VectorXd> f(ydot, size_);
    model_.derivative(t, Eigen::Map<const Eigen::VectorXd>(y, size_), f);
  }
  void write_state_jacobian(double t, const double* y, Eigen::Ref<Eigen::MatrixXd> J) const override { model_.jacobian(t, Eigen::Map<const Eigen::VectorXd>(y, size_), J); }
  Eigen::VectorXd state_rate(double t, const Eigen::VectorXd& y) const override {
    Eigen::VectorXd f(size_);
    model_.derivative(t, y, f);
    return f;
  }
  // Φ keeps what constraints demand of it as far as it is integrated.
  ProjectionReport project(double t, Eigen::Ref<Eigen::VectorXd> both) const override { return model_.project(t, both.head(size_)); }

  Eigen::Index guard_count() const override { return model_.guard_count(); }
  std::string ending(Eigen::Index k) const override { return model_.ending(k); }
  void guards(double t, const Eigen::VectorXd& both, Eigen::Ref<Eigen::VectorXd> g) const override { model_.guards(t, both.head(size_), g); }
  void guard_bands(double t, const Eigen::VectorXd& both, const Eigen::VectorXd& tolerance, Eigen::Ref<Eigen::VectorXd> g) const override {
    model_.guard_bands(t, both.head(size_), tolerance.head(size_), g);
  }
  std::vector<std::string> switched(double t, Eigen::VectorXd& both, const std::vector<bool>& fired, const Eigen::VectorXd& tolerance) override {
    if (guard_count() == 0) return {};
    const Eigen::VectorXd resolution = tolerance.head(size_);
    const auto settle = [&](const Model& model, double at, Eigen::VectorXd& y) { return model.switched(at, y, fired, resolution); };
    const auto count = std::count(fired.begin(), fired.end(), true);
    Eigen::VectorXd y = both.head(size_);
    if (count == 0) {
      const std::vector<std::string> happened = settle(model_, t, y);
      for (Eigen::Index i = 0; i < 2 * dof_; ++i)
        if (std::abs(y[i] - both[i]) > 1e-9 * std::abs(both[i]) + 100 * resolution[i])
          throw InvalidValue(sentence({"a motion must not begin in the moment of an impact, but at t = ", t, " ", state_name(i), " = ", both[i], " becomes ", y[i],
                                       " at once; begin before the impact, or behind it"}));
      both.head(size_) = y;
      return happened;
    }
    const auto k = static_cast<Eigen::Index>(std::find(fired.begin(), fired.end(), true) - fired.begin());
    const std::string guard = ending(k).empty() ? "a contact or friction" : ending(k);
    if (count > 1)
      qdot::detail::end_undifferentiable(guard, t, {"coincides with another: which of them comes first decides what follows, so there is no derivative; "
                                                    "choose a start or parameters that separate them"});
    const std::vector<std::string> happened = settle(model_, t, y);
    const auto h = [this, k](double at, const Eigen::VectorXd& x, Eigen::Index column, double s) {
      Eigen::VectorXd g = Eigen::VectorXd::Zero(guard_count());
      with_model(column, s, [&](const Model& model) { model.guards(at, x, g); });
      return g[k];
    };
    const auto jump = [&](double at, Eigen::VectorXd& x, Eigen::Index column, double s) {
      with_model(column, s, [&](const Model& model) { settle(model, at, x); });
    };
    pass(happened.empty() ? guard : happened.front(), t, both, Surface{h, jump});
    return happened;
  }

  std::string state_name(Eigen::Index i) const override { return model_.component_name(i); }
  std::string column_name(Eigen::Index j) const override {
    return j < starts_ ? state_name(entries_[static_cast<std::size_t>(j)]) + " at the start" : sentence({"parameter ", j - starts_});
  }
  double parameter_size(Eigen::Index column) const override {
    if (column < starts_) return std::numeric_limits<double>::infinity();
    const double p = std::abs(of_.parameters[static_cast<std::size_t>(column - starts_)]);
    return p == 0.0 ? 1.0 : p;
  }
  void renew() override {}
  std::unique_ptr<qdot::detail::AnyWatch> watch(const Options& options) const override { return model_.watch(options); }

 private:
  template <class Use>
  void with_model(Eigen::Index column, double s, const Use& use) const {
    const Eigen::Index j = column - starts_;
    if (j < 0 || s == 0.0) return use(model_);
    use(*of_.with_parameter(j, of_.parameters[static_cast<std::size_t>(j)] + s));
  }
  double reach_of(const Eigen::VectorXd& y, Eigen::Index column) const {
    return column < starts_ ? std::max(1e-3, y.head(2 * dof_).cwiseAbs().maxCoeff()) : parameter_size(column);
  }

  const VariedModel& of_;
  const Model& model_;
  Eigen::Index starts_ = 0;
  std::vector<Neighbours> neighbours_;
  mutable Eigen::MatrixXd J_;
  mutable Eigen::VectorXd rate_, first_, slope_;
};

}  // namespace

VariedMotion varied_motion(const VariedModel& of, double t0, const Eigen::VectorXd& y0, double t_end, Options options, const VariedMethod& method) {
  using qdot::detail::Changes, qdot::detail::VariationalForm;
  if (const std::string why = variation_misfit(*of.model, method.name); !why.empty()) throw InvalidValue(method.name + " " + why);
  options.keep_trajectory = false;
  ModelVariations equations(of);
  const Eigen::VectorXd both = equations.begun(t0, y0, options);
  const Eigen::Index size = equations.state_size(), columns = equations.columns();
  if (options.atol.size() > 1) {
    Eigen::VectorXd each(both.size());
    for (Eigen::Index i = 0; i < each.size(); ++i) each[i] = options.atol[i % size];
    options.atol = each;
  }
  const auto run_of = [&](const auto& form, const auto& with) { return simulate(form, FirstOrderState{t0, both}, t_end, with, options); };
  const Run<Dynamic> run = [&]() -> Run<Dynamic> {
    const VariationalForm<Changes::phases> any(equations);
    const VariationalForm<Changes::projections> formulas(equations);
    const MethodInfo& info = method_named(method.name);
    switch (info.kind) {
      case MethodKind::stiff: return run_of(any, CvodeBdf{});
      case MethodKind::multistep: return run_of(VariationalForm<Changes::none>(equations), CvodeAdams{});
      case MethodKind::series: return equations.record(), run_of(formulas, Taylor{});
      case MethodKind::gauss: return equations.record(), run_of(formulas, Gauss{.step = method.step, .stages = info.order / 2});
      default: return info.name == "dopri5" ? run_of(any, Dopri5{}) : run_of(any, Dop853{});
    }
  }();
  VariedMotion motion{run.outcome, run.message, run.t, run.y.head(size), {}, Eigen::Map<const Eigen::MatrixXd>(run.y.data() + size, size, columns), run.samples.t, {}};
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
  if (model.constrained()) model.project(t, y);
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
