#pragma once
// SPDX-License-Identifier: MIT
//
// The variational equations of one model: where its type is known.
//
// Systems and scenes give q̈ and its Jacobian in one evaluation, and so do parameters of T and V. The upper rows of ∂f/∂y, [0 1 0], are not multiplied.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/analysis/variations/equations.hpp"
#include "qdot/analysis/variations/model.hpp"
#include "qdot/effects/input.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/driver/watched_function.hpp"
#include "qdot/integrate/event.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/integrate/steps/one_step.hpp"
#include "qdot/integrate/steps/recorded_branches.hpp"
#include "qdot/integrate/watch/driven_form_of.hpp"

namespace qdot::detail {

struct AlongColumn {};  // the tag of perturbations of a state along a column of Φ

// Whether the columns of Φ are put onto the tangent space of the constraints, as those of a scene.
template <class Form>
inline constexpr bool projects_columns = ProjectableSystem<Form>;
// Whether ẏ begins with q̇.
template <class Form>
inline constexpr bool begins_with_velocities = requires(const Form& form) { form.scene(); };

// Where in y the effects' own states stand that vary continuously: no phases of contacts and friction, and inputs, which are held, on request.
template <class Form>
std::vector<Eigen::Index> own_states_of(const Form& form, [[maybe_unused]] bool with_inputs) {
  std::vector<Eigen::Index> places;
  if constexpr (requires { form.scene().effects(); }) {
    for_each_place(form.scene(), [&]<class E>(const E&, Eigen::Index place) {
      constexpr bool is_held = requires { E::is_input; } || requires { E::interpolated_inputs; };
      if constexpr (!SwitchingEffect<E, dof_at_compile_time<Form>()>)
        for (int i = 0; i < states_of<E>() && (with_inputs || !is_held); ++i) places.push_back(place + i);
    });
  } else if constexpr (requires { form.own_states(); }) {
    places = form.own_states();
  }
  return places;
}

template <class Model>
class Variations final : public VariationalEquations {
  using Form = typename Model::Form;
  static constexpr int N = Form::size_at_compile_time;
  static constexpr bool projects = ProjectableSystem<Form>, switches = SwitchingSystem<Form>;

 public:
  static constexpr int n = detail::dof_at_compile_time<Form>();

  // Columns for the state at the start, or for all that varies continuously in it, for its time, and for parameters, in this order.
  Variations(Model model, bool with_start, bool with_time, bool with_all = false) : model_(std::move(model)), times_(with_time ? 1 : 0) {
    size_ = form().size();
    dof_ = detail::dof(form());
    if (with_start)
      for (Eigen::Index i = 0; i < (dof_ > 0 ? 2 * dof_ : size_); ++i) entries_.push_back(i);
    if (with_all)
      for (const Eigen::Index place : own_states_of(form(), true)) entries_.push_back(place);
    starts_ = static_cast<Eigen::Index>(entries_.size());
    columns_ = starts_ + times_ + model_.parameters();
    J_.resize(size_, size_);
    head_.resize(size_);
    largest_.setZero(size_);
  }

  const Model& model() const noexcept { return model_; }
  const Form& form() const noexcept { return model_.form; }
  Eigen::Index start_columns() const noexcept { return starts_; }
  Eigen::Index time_columns() const noexcept { return times_; }

  void write_rates(double t, const double* y, double* ydot) const override {
    const Eigen::Index columns = leaves_parameters_out ? columns_ - model_.parameters() : columns_;  // those that are asked for
    const Eigen::Map<const Eigen::MatrixXd> Phi(y + size_, size_, columns);
    Eigen::Map<Eigen::MatrixXd> rate(ydot + size_, size_, columns);
    note_size(y);
    if constexpr (requires { model_.jacobian_written(t, y, ydot, J_); }) {
      if (!leaves_parameters_out && model_.jacobian_written(t, y, ydot, J_)) return write_columns(y, ydot, columns_, model_.parameters());
    }
    if constexpr (mechanical_form<Form>::value) {
      J_.resize(size_, size_);
      form().derivative_and_jacobian(t, Eigen::Map<const Eigen::VectorXd>(y, size_), Eigen::Map<Eigen::VectorXd>(ydot, size_), J_);
      write_columns(y, ydot, columns, 0);
    } else {
      const Eigen::Map<const Eigen::VectorXd> state(y, size_);
      Eigen::Map<Eigen::VectorXd> f(ydot, size_);
      if constexpr (requires { form().derivative_and_jacobian(t, state, f, J_); }) {
        form().derivative_and_jacobian(t, state, f, J_);
      } else {
        form().derivative(t, state, f);
        form().jacobian(t, state, J_);
      }
      constexpr int unrolled = 16;
      if constexpr (requires { form().scene(); } && n > 0 && N > 0 && N <= unrolled) {
        const auto lower = Eigen::Map<const Eigen::Matrix<double, N, N>>(J_.data()).template bottomRows<N - n>();
        for (Eigen::Index j = 0; j < columns; ++j) {
          const Eigen::Map<const Vector<double, N>> from(y + size_ * (j + 1));
          Eigen::Map<Vector<double, N>> to(ydot + size_ * (j + 1));
          to.template head<n>() = from.template segment<n>(n);
          to.template tail<N - n>().noalias() = lower.lazyProduct(from);
        }
      } else {
        const Eigen::Index known = begins_with_velocities<Form> ? dof_ : 0;
        rate.topRows(known) = Phi.middleRows(known, known);
        rate.bottomRows(size_ - known).noalias() = J_.bottomRows(size_ - known).lazyProduct(Phi);
      }
    }
    if (const Eigen::Index m = model_.parameters(); m > 0 && !leaves_parameters_out) {
      slopes_.resize(size_, m);
      if constexpr (is_family_model<Model>) {
        const auto is_same = [&](Eigen::Index j, double s) { return is_same_branch(starts_ + times_ + j, s, t, y); };
        if (is_same_branch) model_.write_rates_within(t, y, ydot, slopes_, is_same);
        else model_.write_parameter_rates(t, y, ydot, slopes_);
      } else {
        model_.write_parameter_rates(t, y, ydot, slopes_);
      }
      rate.rightCols(m) += slopes_;
    }
  }

  void write_state_rates(double t, const double* y, double* ydot) const override {
    note_size(y);
    form().derivative(t, Eigen::Map<const Eigen::VectorXd>(y, size_), Eigen::Map<Eigen::VectorXd>(ydot, size_));
  }
  void write_state_jacobian(double t, const double* y, Eigen::Ref<Eigen::MatrixXd> J) const override {
    form().jacobian(t, Eigen::Map<const Eigen::VectorXd>(y, size_), J);
  }
  bool goes_backwards() const override { return Model::goes_backwards; }
  Eigen::VectorXd parameter_gradient(double t, const double* y, const double* ydot, const Eigen::VectorXd& lambda) const override {
    if constexpr (Model::goes_backwards) return model_.gradient(t, y, ydot, lambda.data());
    return (void)t, (void)y, (void)ydot, (void)lambda, Eigen::VectorXd();
  }
  Eigen::VectorXd state_rate(double t, const Eigen::VectorXd& y) const override {
    Eigen::VectorXd f(size_);
    form().derivative(t, y, f);
    return f;
  }

  ProjectionReport project(double t, Eigen::Ref<Eigen::VectorXd> both) const override {
    if constexpr (projects) {
      const bool bends = bends_projections && both.size() > size_;
      const Eigen::VectorXd before = bends ? Eigen::VectorXd(both.head(size_)) : Eigen::VectorXd();
      const ProjectionReport report = form().project(t, both.head(size_));
      for (Eigen::Index j = 0; j < columns_ && bends && report.residual_before > 0.0; ++j) bend_column(t, before, j, both.segment(size_ * (j + 1), size_));
      if (both.size() > size_) project_columns(t, both);
      return report;
    } else {
      return (void)t, (void)both, ProjectionReport{};
    }
  }

  Eigen::Index guard_count() const override {
    if constexpr (switches) return form().guard_count();
    return 0;
  }
  std::string ending(Eigen::Index k) const override {
    if constexpr (switches) return form().ending(k);
    return (void)k, std::string();
  }
  void guards(double t, const Eigen::VectorXd& both, Eigen::Ref<Eigen::VectorXd> g) const override {
    if constexpr (switches) form().guards(t, head_ = both.head(size_), g);
    (void)t, (void)both, (void)g;
  }
  void guard_bands(double t, const Eigen::VectorXd& both, const Eigen::VectorXd& tolerance, Eigen::Ref<Eigen::VectorXd> g) const override {
    if constexpr (switches) form().guard_bands(t, Eigen::VectorXd(both.head(size_)), Eigen::VectorXd(tolerance.head(size_)), g);
    (void)t, (void)both, (void)tolerance, (void)g;
  }

  // Phases and velocities behind the guards that fired, with Φ⁺.
  std::vector<std::string> switched(double t, Eigen::VectorXd& both, const std::vector<bool>& fired, const Eigen::VectorXd& tolerance) override {
    std::vector<std::string> names = std::exchange(pending_, {});
    if constexpr (switches) {
      const Eigen::VectorXd resolution = tolerance.head(size_);
      const auto settle = [&](const Form& form, double at, Eigen::VectorXd& y) { return form.switched(at, y, fired, resolution); };
      const auto count = std::count(fired.begin(), fired.end(), true);
      Eigen::VectorXd y = both.head(size_);
      if (count == 0) {
        for (std::string& name : settle(form(), t, y)) names.push_back(std::move(name));
        for (Eigen::Index i = 0; i < 2 * dof_; ++i)
          if (std::abs(y[i] - both[i]) > 1e-9 * std::abs(both[i]) + 100 * resolution[i])
            throw InvalidValue(sentence({"a motion must not begin in the moment of an impact, but at t = ", t, " ", state_name(i), " = ", both[i],
                                         " becomes ", y[i], " at once; begin before the impact, or behind it"}));
        both.head(size_) = y;
      } else {
        const std::vector<std::string> happened = settle(form(), t, y);
        const bool moves_on = happened.empty() && is_same_motion(both.head(size_), y, 2 * dof_, resolution);
        if (moves_on) both.head(size_) = y;
        std::string name = happened.empty() ? std::string() : happened.front();
        for (std::size_t k = 0; k < fired.size(); ++k) {
          if (!fired[k] || moves_on) continue;
          if (count > 1 || name.empty()) name = guard_name(static_cast<Eigen::Index>(k));
          Surface surface = guard_surface(static_cast<Eigen::Index>(k));
          surface.jump = [&, k](double at, Eigen::VectorXd& x, Eigen::Index column, double s) {
            model_.with_form(parameter_of(column), s, [&](const Form& form) {
              if constexpr (projects) form.project(at, x);
              (void)settled_alone(form, at, x, fired, k, resolution);
            });
          };
          pass(name, t, both, surface);
        }
        if (count > 1 && !(both.head(size_) - y).isZero(1e-9 * (1.0 + y.cwiseAbs().maxCoeff())))
          end_undifferentiable(name, t, {"coincides with another contact or friction that it acts on: they are solved together, and a displaced motion "
                                         "meets one first; choose a start or parameters that separate them"});
        names.insert(names.end(), happened.begin(), happened.end());
      }
      if constexpr (projects) project_columns(t, both);
    }
    return (void)t, (void)both, (void)fired, (void)tolerance, names;
  }

  // An event of the caller leaves alone what fires in its moment and has an event of its own.
  void pass(const std::string& name, double t, Eigen::VectorXd& both, const Surface& surface) override {
    if constexpr (switches) {
      Eigen::VectorXd g(guard_count()), band(guard_count());
      const Eigen::VectorXd y = both.head(size_);
      form().guards(t, y, g);
      form().guard_bands(t, y, resolution(y), band);
      at_zero_.assign(static_cast<std::size_t>(g.size()), false);
      for (Eigen::Index k = 0; k < g.size(); ++k) at_zero_[static_cast<std::size_t>(k)] = std::abs(g[k]) <= band[k];
    }
    VariationalEquations::pass(name, t, both, surface);
    at_zero_.clear();
  }

  std::string state_name(Eigen::Index i) const override { return form().component_name(i); }
  std::string column_name(Eigen::Index j) const override {
    if (j < starts_) return sentence({state_name(entries_[static_cast<std::size_t>(j)]), " at the start"});
    if (j < starts_ + times_) return "the time of the start";
    return sentence({"parameter ", j - starts_ - times_});
  }
  double parameter_size(Eigen::Index column) const override {
    const Eigen::Index j = parameter_of(column);
    const double p = j < 0 ? std::numeric_limits<double>::infinity() : std::abs(model_.parameter(j));
    return p == 0.0 ? 1.0 : p;
  }
  void renew() override { model_.renew(); }
  bool records_functors() const override { return has_branches_recorded<Form>; }
  void record(RecordedBranch& branch, Eigen::Index column, double s) const override {
    if constexpr (has_branches_recorded<Form>)
      model_.with_form(column < 0 ? column : parameter_of(column), s, [&](const Form& form) { run_functors(branch, form); });
    (void)branch, (void)column, (void)s;
  }
  std::unique_ptr<AnyWatch> watch(const Options& options) const override { return watch_of(form(), options); }

  // Guard k of a scene that switches.
  Surface guard_surface(Eigen::Index k) const {
    const auto h = [this, k](double t, const Eigen::VectorXd& y, Eigen::Index column, double s) {
      Eigen::VectorXd g = Eigen::VectorXd::Zero(guard_count());
      const auto write = [&](const auto& form) {
        if constexpr (requires { form.guards(t, y, g, true); }) form.guards(t, y, g, true);
        else if constexpr (switches) form.guards(t, y, g);
      };
      model_.with_form(parameter_of(column), s, write);
      return g[k];
    };
    return {h, {}};
  }

  // Event number i of the model, as pass() and crossing() ask for it.
  template <std::size_t i>
  Surface surface() const {
    Surface surface;
    surface.h = [this](double t, const Eigen::VectorXd& y, Eigen::Index column, double s) {
      return model_.template with_event<i>(parameter_of(column), s, [&](const auto& event) { return event_value<n>(event.g, t, y, dof_); });
    };
    surface.jump = [this](double t, Eigen::VectorXd& y, Eigen::Index column, double s) {
      // What is displaced along a column is off its closed contacts by s². Their gaps are judged at y itself.
      if constexpr (switches)
        if (column >= 0 && !gap_has_moved_) model_.with_form(parameter_of(column), s, [&](const Form& form) { form.project(t, y); });
      model_.template with_event<i>(parameter_of(column), s, [&](const auto& event) {
        using E = std::remove_cvref_t<decltype(event)>;
        if constexpr (!E::stops && !E::records)
          if (std::optional<Failure> failure = change_state<n>(event.name, event.change, t, y, dof_)) throw EndOfRun(std::move(*failure));
      });
      model_.renew();  // an action may change what f is
      if (!y.allFinite()) return;
      model_.with_form(parameter_of(column), s, [&](const Form& form) {
        if constexpr (projects && !switches) form.project(t, y);
        if constexpr (requires { form.gap_has_moved(t, y, y); })
          if (column < 0) gap_has_moved_ = form.gap_has_moved(t, y, resolution(y));
        if constexpr (switches) {
          const std::vector<bool> none(static_cast<std::size_t>(form.guard_count()));
          if constexpr (requires { form.switched(t, y, none, resolution(y), &at_zero_); })
            pending_ = form.switched(t, y, none, resolution(y), at_zero_.empty() ? nullptr : &at_zero_);
          else pending_ = form.switched(t, y, none, resolution(y));
        }
      });
    };
    return surface;
  }

 private:
  // So many columns of Φ̇ of T and V, where J_ is ∂f/∂y, with ∂f/∂p for the last columns behind it.
  void write_columns(const double* y, double* ydot, Eigen::Index columns, Eigen::Index parameters) const {
    using Accelerations = Vector<double, n >= 1 && n <= 8 ? n : Dynamic>;
    const auto slope = [&](Eigen::Index j) { return Eigen::Map<const Accelerations>(J_.data() + j * size_ + dof_, dof_); };
    for (Eigen::Index column = 0; column < columns; ++column) {
      const double* const from = y + size_ * (column + 1);
      double* const to = ydot + size_ * (column + 1);
      std::copy_n(from + dof_, dof_, to);
      const Eigen::Index parameter = column - (columns - parameters);
      Accelerations rate = from[0] * slope(0);
      if constexpr (n >= 1 && n <= 8) unroll<2 * n - 1>([&](auto j) { rate += from[j + 1] * slope(j + 1); });
      else for (Eigen::Index j = 1; j < size_; ++j) rate += from[j] * slope(j);
      if (parameter >= 0) rate += slope(size_ + parameter);
      std::copy_n(rate.data(), dof_, to + dof_);
    }
  }
  // Which parameter a column belongs to; −1 for one of another kind.
  Eigen::Index parameter_of(Eigen::Index column) const { return column < starts_ + times_ ? -1 : column - starts_ - times_; }

  // What guard k does, where others fire in the same moment.
  static std::vector<std::string> settled_alone(const Form& form, double t, Eigen::VectorXd& y, std::vector<bool> fired, std::size_t k,
                                                const Eigen::VectorXd& resolution) {
    std::vector<bool> others = fired;
    others[k] = false;
    fired.assign(fired.size(), false);
    fired[k] = true;
    if constexpr (requires { form.switched(t, y, fired, resolution, &others); }) return form.switched(t, y, fired, resolution, &others);
    else return form.switched(t, y, fired, resolution);
  }

  std::string guard_name(Eigen::Index k) const {
    if (std::string name = ending(k); !name.empty()) return name;
    if constexpr (requires { form().guard_name(k); }) return form().guard_name(k);
    return "a contact or friction";
  }

  // Column j ← what the projection of a state makes of it.
  void bend_column(double t, const Eigen::VectorXd& y, Eigen::Index j, Eigen::Ref<Eigen::VectorXd> column) const {
    const auto projected = [&](double s) {
      Eigen::VectorXd nearby = y + s * column;
      model_.with_form(parameter_of(j), s, [&](const Form& form) { form.project(t, nearby); });
      return nearby;
    };
    if (const auto slope = slope_at_zero(projected, 0.125 * reach(y, column, j), largest_)) column = *slope;
  }

  // Columns of Φ, put onto the tangent space at y.
  void project_columns(double t, Eigen::Ref<Eigen::VectorXd> both) const {
    if constexpr (projects_columns<Form>) {
      static_assert(requires { form().scene(); }, "qdot: sensitivities of a system with constraints need it as a scene, scene(system, holonomic(…))");
      using Sc = std::remove_cvref_t<decltype(form().scene())>;
      using D = Dual<double, 1, AlongColumn>;
      const Vector<double, n> q = both.head(dof_), qdot = both.segment(dof_, dof_);
      const Vector<double, Sc::states_at_compile_time> z = both.segment(2 * dof_, size_ - 2 * dof_);
      if (is_free(form().scene(), z)) return;
      const SceneRowsOf<Sc> rows_of_scene(form().scene());
      auto geometry = constraint_geometry(form().scene(), rows_of_scene, t, default_rank_cutoff);
      geometry.move_to(q, qdot, z);
      const auto take_away = [&](const auto& rows, Eigen::Index parameter, const auto& rows_of, double* column) {
        Eigen::VectorXd residual = rates_in(rows);
        if (parameter >= 0) model_.add_parameter_slope(parameter, rows_of, residual);
        for (Eigen::Index i = 0; i < residual.size(); ++i) residual[i] = -residual[i];
        const Column step = geometry.displacement(residual);
        for (Eigen::Index i = 0; i < dof_; ++i) column[i] += step[i];
      };
      for (Eigen::Index j = 0; j < columns_; ++j) {
        double* const dq = both.data() + size_ * (j + 1);
        take_away(constraint_residual(form().scene(), with_rates<D>(q, dq), D(t), z), parameter_of(j),
                  [&](const Form& nearby) { return Eigen::VectorXd(constraint_residual(nearby.scene(), q, t, z)); }, dq);
        take_away(constraint_velocity(form().scene(), with_rates<D>(q, dq), with_rates<D>(qdot, dq + dof_), D(t), z), parameter_of(j),
                  [&](const Form& nearby) { return Eigen::VectorXd(constraint_velocity(nearby.scene(), q, qdot, t, z)); }, dq + dof_);
      }
    }
    (void)t, (void)both;
  }

  mutable Model model_;
  Eigen::Index starts_ = 0, times_;
  mutable Eigen::MatrixXd J_, slopes_;
  mutable Eigen::VectorXd head_;
  mutable std::vector<std::string> pending_;  // names of what a user's jump led to
  mutable bool gap_has_moved_ = false;        // of a closed contact, by a user's jump
  mutable std::vector<bool> at_zero_;         // guards that are at zero where a user's jump begins
};

}  // namespace qdot::detail
