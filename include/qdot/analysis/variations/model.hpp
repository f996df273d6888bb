#pragma once
// SPDX-License-Identifier: MIT
//
// What depends on parameters, and how.
//
//     FixedModel       equations without parameters
//     EnergiesModel    p ↦ (T, V) that takes duals: ∂q̈/∂p exactly (mechanics/parameter_jacobian.hpp)
//     FamilyModel      p ↦ (system or scene, start, events), numbers only: ∂f/∂p from the equations of seven members of the family,
//                      made beforehand, by the formula of order six (slope.hpp)
//
// A family may change everything: masses, stiffnesses, restitution, where events lie, what they do, where the run begins. What does not depend on a
// parameter has equal members, whose differences are exactly zero.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/analysis/variations/parameter_gradient.hpp"
#include "qdot/analysis/variations/slope.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/event.hpp"
#include "qdot/mechanics/derive/traced_jacobian.hpp"
#include "qdot/mechanics/first_order_form.hpp"
#include "qdot/mechanics/parameter_jacobian.hpp"

namespace qdot::detail {

template <class System>
using FormOf = std::remove_cvref_t<decltype(first_order_form(std::declval<const System&>()))>;

template <class P>
void require_finite_parameters(const P& p) {
  for (Eigen::Index j = 0; j < p.size(); ++j)
    if (!std::isfinite(p[j])) throw_invalid_value({"parameter ", j, " must be finite, but is ", p[j], "; give it a number"});
}

// Of all models: the equations, and events that do not depend on parameters.
template <class Form_, class List>
struct FixedModel {
  using Form = Form_;
  static constexpr std::size_t event_count = std::tuple_size_v<decltype(List::list)>;
  Form form;
  List events;

  static constexpr int parameters_at_compile_time = 0;
  Eigen::Index parameters() const { return 0; }
  void renew() { detail::renew(form); }
  void write_parameter_rates(double, const double*, const double*, Eigen::Ref<Eigen::MatrixXd>) const {}
  static constexpr bool goes_backwards = false;  // whether it has a gradient of λ·f in p that costs less than ∂f/∂p
  template <class Rows>
  void add_parameter_slope(Eigen::Index, const Rows&, Eigen::VectorXd&) const {}
  // use(event) for number i, with parameter j displaced by s; j < 0 for none.
  template <std::size_t i, class Use>
  auto with_event(Eigen::Index, double, const Use& use) const {
    return use(std::get<i>(events.list));
  }
  // use(form), likewise.
  template <class Use>
  auto with_form(Eigen::Index, double, const Use& use) const {
    return use(form);
  }
  double parameter(Eigen::Index) const { return 0.0; }
};

template <class EnergiesOf, class P>
using EnergiesOf_t = std::remove_cvref_t<std::invoke_result_t<const EnergiesOf&, const P&>>;

template <class Form_, class List, class EnergiesOf, int m>
struct EnergiesModel : FixedModel<Form_, List> {
  static constexpr int n = Form_::size_at_compile_time == Dynamic ? Dynamic : Form_::size_at_compile_time / 2;
  EnergiesOf energies_of;
  Vector<double, m> p;
  mutable GradientTapes tapes{};
  mutable bool is_tried = false;  // whether it has been traced, if it can be
  mutable std::optional<TracedJacobian<unrolled_size<n>>> traced{};
  mutable std::vector<int> traced_parameters{};

  static constexpr bool goes_backwards = n != Dynamic && (m == Dynamic || m > 8);
  Eigen::VectorXd gradient(double t, const double* y, const double* ydot, const double* lambda) const {
    const Eigen::Index dof = this->form.size() / 2;
    using X = Vector<double, n>;
    const auto part = [&](const double* of) { return X(Eigen::Map<const X>(of, dof)); };
    const X q = part(y), qdot = part(y + dof);
    const auto& system = this->form.system();
    const X u = solved_with_mass_matrix(system, kinetic_hessian<n>(system.energies(), q, qdot, t), part(lambda + dof), t);
    return parameter_gradient(energies_of, p, q, qdot, part(ydot + dof), u, t, tapes);
  }

  static constexpr int parameters_at_compile_time = m;
  Eigen::Index parameters() const { return p.size(); }
  template <class Use>
  auto with_form(Eigen::Index j, double s, const Use& use) const {
    if (j < 0 || s == 0.0) return use(this->form);
    Vector<double, m> beside = p;
    beside[j] += s;
    return use(Form_(first_order_form(mechanical_system<n>(energies_of(beside)).by(this->form.system().kept_lines()->by()))));
  }
  double parameter(Eigen::Index j) const { return p[j]; }

  void renew() {
    detail::renew(this->form);
    try {
      if (traced && !traced->still_holds(recordable())) traced.reset();
    } catch (...) {  // no formulas any more
      traced.reset();
    }
    is_tried = traced.has_value();
  }
  // ẏ, and ∂ẏ/∂(y, p), 2n × (2n + m), by the lines of one recording; false where T and V are no formulas, or are to go another way.
  bool jacobian_written(double t, const double* y, double* ydot, Eigen::MatrixXd& J) const {
    if constexpr (records_parameters) {
      if (!is_tried) trace();
      if (!traced) return false;
      J.resize(this->form.size(), this->form.size() + p.size());
      return traced->write(t, y, ydot, J);
    }
    return (void)t, (void)y, (void)ydot, (void)J, false;
  }

  void write_parameter_rates(double t, const double* y, const double*, Eigen::Ref<Eigen::MatrixXd> out) const {
    const Eigen::Index dof = this->form.size() / 2;
    const Vector<double, n> q = Eigen::Map<const Vector<double, n>>(y, dof), qdot = Eigen::Map<const Vector<double, n>>(y + dof, dof);
    const auto jacobian = acceleration_jacobian_wrt_parameters(energies_of, p, q, qdot, t);
    for (Eigen::Index j = 0; j < p.size(); ++j)
      for (Eigen::Index i = 0; i < dof; ++i) {
        out(i, j) = 0.0;
        out(dof + i, j) = jacobian.d_p(i, j);
      }
  }

 private:
  static constexpr bool records_parameters = RecordableEnergies<EnergiesOf_t<EnergiesOf, Vector<double, m>>, n> &&
                                             RecordableEnergies<EnergiesOf_t<EnergiesOf, Vector<formula::Recorded, m>>, n>;
  static constexpr Eigen::Index most_traced = 64;  // coordinates

  void record(RecordedMotion& motion, const std::vector<int>& parameters) const {
    using Recorded = EnergiesOf_t<EnergiesOf, Vector<formula::Recorded, m>>;
    const Recorded energies = energies_of(recorded_vector<m>(motion.recording, parameters));
    run_energies<n>(motion, WithSignatureOf<Recorded, EnergiesOf_t<EnergiesOf, Vector<double, m>>, n>{energies});
  }
  RecordableForm recordable() const {
    const auto run = [](const void* it, RecordedMotion& again, std::vector<char>*) {
      const auto& self = *static_cast<const EnergiesModel*>(it);
      self.record(again, self.traced_parameters);
    };
    const Eigen::Index dof = this->form.size() / 2;
    return {.form = this, .run = run, .dof = dof, .limits = {.singular = singular_pivot<double>(dof), .dependent = 0.0}};
  }
  [[gnu::cold]] void trace() const {
    is_tried = true;
    const KeptLines& kept = *this->form.system().kept_lines();
    const Eigen::Index dof = this->form.size() / 2;
    if (!kept.may_be_lines() || dof > most_traced) return;
    try {
      TracedEquations<double> equations(dof, 0, p.size());
      equations.begins = machine_code_begins(kept.by());
      traced_parameters = equations.parameters;
      record(equations.motion, traced_parameters);
      equations.derive(false, {});
      traced.emplace(std::move(equations), LimitsOfPivots{.singular = singular_pivot<double>(dof), .dependent = 0.0});
      traced->set_parameters(p.data());
      if (!traced->is_known()) traced.reset();
    } catch (...) {  // what functors throw they throw again, where they are asked for values
      traced.reset();
    }
  }
};

template <class Family, class P>
class FamilyModel {
  using Member = std::remove_cvref_t<std::invoke_result_t<const Family&, const P&>>;

 public:
  using Form = FormOf<decltype(Member::system)>;
  static constexpr std::size_t event_count = std::tuple_size_v<decltype(Member::events.list)>;

  FamilyModel(Family family, P p) : nominal(family(p)), form(first_order_form(nominal.system)), family_(std::move(family)), p_(std::move(p)) {
    require_finite_parameters(p_);
    for (Eigen::Index j = 0; j < p_.size(); ++j) neighbours_.push_back(neighbours_of(j));
    rate_.resize(form.size());
  }

  Member nominal;
  Form form;

  void renew() {
    detail::renew(form);
    for (Neighbours& nearby : neighbours_)
      for (Form& one : nearby.forms) detail::renew(one);
    near_forms_.clear();
  }

  Eigen::Index parameters() const { return p_.size(); }
  double parameter(Eigen::Index j) const { return p_[j]; }
  static constexpr bool goes_backwards = false;

  // The member with parameter j displaced by s.
  Member member(Eigen::Index j, double s) const {
    P p = p_;
    if (j >= 0) p[j] += s;
    return family_(p);
  }

  // out ← ∂f/∂p where f(t, y) is known to be ydot.
  void write_parameter_rates(double t, const double* y, const double* ydot, Eigen::Ref<Eigen::MatrixXd> out) const {
    const Eigen::Map<const Eigen::VectorXd> state(y, form.size()), f(ydot, form.size());
    for (Eigen::Index j = 0; j < p_.size(); ++j) {
      const Neighbours& nearby = neighbours_[static_cast<std::size_t>(j)];
      out.col(j).setZero();
      for (std::size_t i = 1; i < nearby.forms.size(); ++i) {
        nearby.forms[i].derivative(t, state, rate_);
        if (i == 1) first_ = rate_;
        if (i == 2 && nearby.points->central && rate_ == first_) {  // f does not ask for this parameter
          out.col(j).setZero();
          break;
        }
        out.col(j) += nearby.points->weight[i] / nearby.h * (rate_ - f);
      }
    }
  }

  // The rates where functors compare: from members on the branch of the one in the middle, is_same(j, s), on one side of it, or nearer.
  template <class IsSame>
  void write_rates_within(double t, const double* y, const double* ydot, Eigen::Ref<Eigen::MatrixXd> out, const IsSame& is_same) const {
    const Eigen::Map<const Eigen::VectorXd> state(y, form.size()), f(ydot, form.size());
    for (Eigen::Index j = 0; j < p_.size(); ++j) {
      double h = neighbours_[static_cast<std::size_t>(j)].h;
      const SlopePoints* points = nullptr;
      for (int attempt = 0; attempt < 4 && points == nullptr; ++attempt, h /= points == nullptr ? 64 : 1)
        for (const SlopePoints& each : slope_points)
          if (points == nullptr && std::all_of(each.at.begin() + 1, each.at.end(), [&](double at) { return near_form(j, at * h) && is_same(j, at * h); }))
            points = &each;
      out.col(j).setConstant(points == nullptr ? std::numeric_limits<double>::quiet_NaN() : 0.0);
      for (std::size_t i = 1; points != nullptr && i < points->at.size(); ++i) {
        near_form(j, points->at[i] * h)->derivative(t, state, rate_);
        out.col(j) += points->weight[i] / h * (rate_ - f);
      }
    }
  }

  // use(form, weight) such that Σ weight F(form) is ∂F/∂p_j.
  template <class Use>
  void for_each_neighbour(Eigen::Index j, const Use& use) const {
    const Neighbours& nearby = neighbours_[static_cast<std::size_t>(j)];
    for (std::size_t i = 0; i < nearby.forms.size(); ++i)
      if (nearby.points->weight[i] != 0.0) use(nearby.forms[i], nearby.points->weight[i] / nearby.h);
  }

  // slope += ∂rows/∂p_j for rows_of(form).
  template <class Rows>
  void add_parameter_slope(Eigen::Index j, const Rows& rows_of, Eigen::VectorXd& slope) const {
    const Eigen::VectorXd here = rows_of(form);
    for_each_neighbour(j, [&](const Form& nearby, double weight) { slope += weight * (rows_of(nearby) - here); });
  }

  template <std::size_t i, class Use>
  auto with_event(Eigen::Index j, double s, const Use& use) const {
    if (j < 0 || s == 0.0) return use(std::get<i>(nominal.events.list));
    return use(std::get<i>(member(j, s).events.list));
  }
  template <class Use>
  auto with_form(Eigen::Index j, double s, const Use& use) const {
    if (j < 0 || s == 0.0) return use(form);
    return use(Form(first_order_form(member(j, s).system)));
  }

 private:
  struct Neighbours {
    double h = 0.0;
    const SlopePoints* points = nullptr;
    std::vector<Form> forms;  // the first is `form` itself
  };

  // The member with parameter j displaced by s; null where there is none.
  const Form* near_form(Eigen::Index j, double s) const {
    const auto [place, is_new] = near_forms_.try_emplace({j, s});
    if (is_new) {
      try {
        place->second = std::make_shared<Form>(first_order_form(member(j, s).system));
      } catch (const Error&) {  // on this side there is none
      }
    }
    return place->second.get();
  }

  // Of two formulas for the same slope, that whose members there are.
  Neighbours neighbours_of(Eigen::Index j) const {
    std::string trouble;
    for (const SlopePoints& points : slope_points) {
      Neighbours nearby{parameter_step(p_[j]), &points, {}};
      try {
        for (const double at : points.at) nearby.forms.emplace_back(first_order_form(member(j, at * nearby.h).system));
        return nearby;
      } catch (const Error& error) {
        trouble = error.what();
      }
    }
    throw InvalidValue(sentence({"a family must have members beside parameter ", j, " = ", p_[j], ", on one side at least, but: ", trouble}));
  }

  Family family_;
  P p_;
  std::vector<Neighbours> neighbours_;
  mutable std::map<std::pair<Eigen::Index, double>, std::shared_ptr<Form>> near_forms_;
  mutable Eigen::VectorXd rate_, first_;
};

template <class Model>
inline constexpr bool is_family_model = false;
template <class Family, class P>
inline constexpr bool is_family_model<FamilyModel<Family, P>> = true;

}  // namespace qdot::detail
