#pragma once
// SPDX-License-Identifier: MIT
//
// What a watchdog asks of a first-order form, by calls.
//
// A watchdog (integrate/watch/any_watch.ipp) compares numbers: energies, the pivots of M, f as it is and as it was, guards of branches and of the time. Only
// the numbers depend on the types of T, V and effects. So WatchedForm has a virtual function for each, WatchedFormOf answers from a form, and whatever
// is done with the answers is compiled once. All are asked now and then, not in each evaluation.

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/ad/vector.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/integrate/steps/recorded_branches.hpp"
#include "qdot/integrate/watch/energy_slope.hpp"
#include "qdot/integrate/watch/time_formulas.hpp"
#include "qdot/mechanics/derive/kept_lines.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot::detail {

// What an evaluation gives; nothing where the model refuses. It has been evaluated there before: it is the watch that must not end a run with another
// error than its own.
template <class Evaluate>
auto quietly(Evaluate&& evaluate) -> std::optional<decltype(evaluate())> {
  try {
    return evaluate();
  } catch (...) {
    return std::nullopt;
  }
}

/// A first-order form as watchdogs see it. What has no T and V leaves the defaults.
struct WatchedForm {
  virtual ~WatchedForm() = default;
  virtual Eigen::Index size() const = 0;
  virtual Eigen::Index dof() const = 0;
  virtual std::string component_name(Eigen::Index i) const = 0;
  virtual void derivative(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> out) const = 0;
  /// out ← rates, then φ and φ̇, then guards, without recordings or factors that the form keeps; may throw.
  virtual void values(double t, const Eigen::VectorXd& y, Eigen::VectorXd& out) const = 0;

  /// T and V; NaN where there are none.
  virtual EnergyAt energy(double, const Eigen::VectorXd&) const {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    return {none, none, none};
  }
  virtual bool conserves_energy() const { return false; }
  /// |∂h/∂y| where n is known at run time only; otherwise nothing.
  virtual Eigen::VectorXd energy_slopes(double, const Eigen::VectorXd&) const { return {}; }
  /// @throws NonFinite  T or V has no value at y
  virtual void require_energies(double, const Eigen::VectorXd&) const {}

  virtual bool has_positive_mass() const { return false; }  // which M of this promises to be
  virtual void write_mass(double, const Eigen::VectorXd&, Eigen::MatrixXd&) const {}
  virtual std::vector<std::string> row_names() const { return {}; }
  virtual bool is_constrained() const { return false; }
  struct Pivots {
    double mass = 1.0, constraints = 1.0;  // smallest ones, of M and of J M⁻¹ Jᵀ
    Eigen::Index weakest_constraint = 0;
  };
  virtual Pivots pivots(double, const Eigen::VectorXd&) const { return {}; }  // where constraints are

  virtual void record_time(TimeFormulas&) const {}

  virtual bool has_recordable_branches() const { return false; }
  virtual bool is_known_to_compare_nothing() const { return false; }
  virtual void record_branch(RecordedBranch&) const {}
};

/// What a watchdog finds of a step.
struct Passage {
  std::optional<double> retake{};    // what may have elapsed at most at its end when it is taken again
  std::optional<Failure> trouble{};  // the run cannot go on,
  double until = 0.0;                // when so much has elapsed
  std::optional<double> cut{};       // the branch is left when so much has elapsed: there the step ends, and the method begins afresh
  std::optional<double> ahead{};     // the state there lies on a guard, and the branch is that when so much has elapsed
};

/// How a step goes where functors branch: as they are at each stage; on one branch by the stepper's own care; or on the branch of its beginning.
enum class Course { free, ends_at_branches, held };

// The system whose T and V stand behind a first-order form; nothing for what is of first order by itself.
template <class F>
struct BehindForm {
  static constexpr bool is_mechanical = false, is_scene = false, conserves = false;
};
template <class Sys>
struct BehindForm<FirstOrderForm<Sys>> {
  using System = Sys;
  static constexpr bool is_mechanical = true, is_scene = false;
  static constexpr bool conserves = Sys::autonomous;
  static const Sys& system(const FirstOrderForm<Sys>& form) { return form.system(); }
};
template <class F>
  requires requires(const F& f) { f.scene().system().energies(); }
struct BehindForm<F> {
  using System = std::remove_cvref_t<decltype(std::declval<const F&>().scene().system())>;
  static constexpr bool is_mechanical = true, is_scene = true, conserves = false;
  static const System& system(const F& form) { return form.scene().system(); }
};

// q and q̇ of y = [q; q̇; …].
template <int n>
std::pair<Vector<double, n>, Vector<double, n>> coordinates_of(const Eigen::VectorXd& y, Eigen::Index dof) {
  return {vector_at<n>(y.data(), dof), vector_at<n>(y.data() + dof, dof)};
}

// Whether the equations of a form have been derived without a comparison.
template <class F>
bool has_no_branches([[maybe_unused]] const F& form) {
  if constexpr (requires { form.is_recorded(); }) return form.is_recorded();
  return false;
}
template <class Sys>
bool has_no_branches(const FirstOrderForm<Sys>& form) {
  using E = typename Sys::EnergiesType;
  constexpr int n = Sys::dof_at_compile_time;
  if constexpr (requires { form.is_recorded(); }) return form.is_recorded();
  if constexpr (may_keep_lines<E, n>) {
    const int size = static_cast<int>(form.system().dof());
    const auto& shared = form.system().kept_lines()->shared();
    Derivations::Held held;
    return shared && size <= block_limit<n> && derivations_of(*shared).template everywhere<n>(form.system().energies(), size, held) != nullptr;
  }
  return false;
}

/// Answers from a form, which outlives this.
template <FirstOrderSystem F>
class WatchedFormOf final : public WatchedForm {
  using Behind = BehindForm<F>;
  static constexpr int n = dof_at_compile_time<F>();
  static constexpr bool is_constrained_scene = requires { requires F::has_constraints; };

 public:
  explicit WatchedFormOf(const F& form) : form_(form) {}

  Eigen::Index size() const override { return form_.size(); }
  Eigen::Index dof() const override { return qdot::detail::dof(form_); }
  std::string component_name(Eigen::Index i) const override { return form_.component_name(i); }
  void derivative(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> out) const override { form_.derivative(t, y, out); }

  // Allocates nothing where n is fixed and out has been written to before.
  void values(double t, const Eigen::VectorXd& y, Eigen::VectorXd& out) const override {
    const KeptLines::Aside aside(kept_lines());  // but lines that it keeps are asked for no values here
    const Eigen::Index size = form_.size();
    Eigen::Index guards = 0;
    if constexpr (SwitchingSystem<F>) guards = form_.guard_count();
    if constexpr (is_constrained_scene) {
      const Eigen::Index k = form_.dof();
      const Vector<double, n> q = vector_at<n>(y.data(), k), qdot = vector_at<n>(y.data() + k, k);
      const auto z = vector_at<std::remove_cvref_t<decltype(form_.scene())>::states_at_compile_time>(y.data() + 2 * k, size - 2 * k);
      const auto phi = constraint_residual(form_.scene(), q, t, z), velocity = constraint_velocity(form_.scene(), q, qdot, t, z);
      out.resize(size + 2 * phi.size() + guards);
      std::copy_n(velocity.data(), velocity.size(), std::copy_n(phi.data(), phi.size(), out.data() + size));
    } else {
      out.resize(size + guards);
    }
    if constexpr (requires { form_.system().energies(); }) {
      const auto [q, qdot] = coordinates_of<n>(y, dof());
      const Vector<double, n> a = acceleration(form_.system(), q, qdot, t);  // with no factors of M that the form keeps
      std::copy_n(a.data(), a.size(), std::copy_n(qdot.data(), qdot.size(), out.data()));
    } else {
      form_.derivative(t, y, Eigen::Map<Eigen::VectorXd>(out.data(), size));
    }
    if constexpr (SwitchingSystem<F>) form_.guards(t, y, Eigen::Map<Eigen::VectorXd>(out.data() + out.size() - guards, guards));
  }

  EnergyAt energy(double t, const Eigen::VectorXd& y) const override {
    if constexpr (Behind::is_mechanical) return energy_at(Behind::system(form_), t, y);
    return WatchedForm::energy(t, y);
  }
  bool conserves_energy() const override { return Behind::conserves; }
  Eigen::VectorXd energy_slopes(double t, const Eigen::VectorXd& y) const override {
    if constexpr (Behind::conserves && n == Dynamic) return qdot::detail::energy_slopes(Behind::system(form_), t, y);
    return WatchedForm::energy_slopes(t, y);
  }
  void require_energies(double t, const Eigen::VectorXd& y) const override {
    if constexpr (Behind::is_mechanical) {
      const auto [q, qdot] = coordinates_of<n>(y, dof());
      require_finite_energies(Behind::system(form_).energies(), q, qdot, t);
    }
    (void)t, (void)y;
  }

  bool has_positive_mass() const override { return looks_at_mass; }
  void write_mass(double t, const Eigen::VectorXd& y, Eigen::MatrixXd& M) const override {
    if constexpr (looks_at_mass) {
      const auto [q, qdot] = coordinates_of<n>(y, dof());
      const Matrix<double, n> now = mass_matrix(Behind::system(form_), q, qdot, t);
      M.resize(now.rows(), now.cols());
      std::copy_n(now.data(), now.size(), M.data());
    }
    (void)t, (void)y, (void)M;
  }
  std::vector<std::string> row_names() const override {
    if constexpr (is_constrained_scene) return constraint_names(form_.scene());
    return {};
  }
  bool is_constrained() const override { return is_constrained_scene; }
  Pivots pivots(double t, const Eigen::VectorXd& y) const override {
    if constexpr (is_constrained_scene) {
      const auto seen = conditioning(form_.scene(), y, t);
      return {seen.mass, seen.constraints, seen.weakest_constraint};
    }
    return WatchedForm::pivots(t, y);
  }

  void record_time(TimeFormulas& found) const override {
    if constexpr (TimeOf<F>::enters) TimeOf<F>::record(found, form_);
    (void)found;
  }

  bool has_recordable_branches() const override { return has_branches_recorded<F>; }
  bool is_known_to_compare_nothing() const override { return has_no_branches(form_); }
  void record_branch(RecordedBranch& branch) const override {
    if constexpr (has_branches_recorded<F>) run_functors(branch, form_);
    (void)branch;
  }

 private:
  static constexpr bool looks_at_mass = [] {
    if constexpr (Behind::is_mechanical && !is_constrained_scene) return Behind::System::inertia == Inertia::positive_definite;
    return false;
  }();

  KeptLines* kept_lines() const {
    if constexpr (Behind::is_mechanical) return Behind::system(form_).kept_lines();
    else return nullptr;
  }

  const F& form_;
};

}  // namespace qdot::detail
