#pragma once
// SPDX-License-Identifier: MIT
//
// What a search for periodic orbits asks of a system, whatever T, V, effects and events are behind it:
//
//     (x, T, p) ↦ φ_T(x) ,  ∂φ_T/∂x ,  ∂φ_T/∂p ,  ẋ at the end       one run with its derivatives
//     (x, p)    ↦ ẋ ,  h ,  ∂L/∂q̇ ,  x put onto the constraints       no run
//
// x = [q; q̇], h is Jacobi's energy function. Phases of contacts and friction follow from x at the start. Behind this interface the search is compiled once,
// with matrices of run-time size.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "qdot/analysis/sensitivity.hpp"
#include "qdot/effects/scene.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/mechanics/energy.hpp"

namespace qdot::detail {

// A run over the time T and its derivatives.
struct Shot {
  Outcome outcome = Outcome::completed;
  std::string message{};
  Eigen::VectorXd x{}, xdot{};     // at the end
  Eigen::MatrixXd Phi{};           // ∂x/∂x₀
  Eigen::VectorXd by_parameter{};  // ∂x/∂p; empty without parameter
  Eigen::VectorXd extent{};        // largest less smallest value of each component on the way
};

class Shooting {
 public:
  virtual ~Shooting() = default;
  virtual Eigen::Index size() const = 0;  // 2n
  virtual double time() const = 0;        // of the start
  virtual bool has_parameter() const = 0;
  virtual bool projects() const = 0;  // onto constraints
  virtual std::string name(Eigen::Index i) const = 0;
  // Tolerances are taken `coarser` times as large as they are.
  virtual Shot shot(const Eigen::VectorXd& x, double period, double p, double coarser) const = 0;
  virtual Eigen::VectorXd rate(const Eigen::VectorXd& x, double p, double later = 0.0) const = 0;
  virtual double energy(const Eigen::VectorXd& x, double p, double later = 0.0) const = 0;
  virtual Eigen::VectorXd momenta(const Eigen::VectorXd& x, double p, double later = 0.0) const = 0;
  virtual Eigen::VectorXd settled(const Eigen::VectorXd& x, double p) const = 0;
};

template <class>
inline constexpr bool remembers = false;
template <class Sys, class... Effects>
inline constexpr bool remembers<Scene<Sys, Effects...>> =
    ((StateEffect<Effects> && !SwitchingEffect<Effects, Sys::dof_at_compile_time> && !requires { Effects::is_input; }) || ...);

// One problem for all p.
template <class P>
struct OneProblem {
  P given;
  P operator()(const Eigen::Matrix<double, 1, 1>&) const { return given; }
};

// Of p ↦ problem(system or scene, any start, events), or of one problem for all p.
template <class Family, class Method, bool with_parameter>
class ShootingOf final : public Shooting {
  using One = Eigen::Matrix<double, 1, 1>;
  using Member = std::remove_cvref_t<std::invoke_result_t<const Family&, const One&>>;
  using System = std::remove_cvref_t<decltype(Member::system)>;
  static constexpr int n = System::dof_at_compile_time;
  static_assert(!remembers<System>,
                "qdot: a periodic orbit needs a scene whose state is q and qdot, but an effect has a state of its own: make it a coordinate "
                "of the system, or leave it out");

 public:
  ShootingOf(Family family, double t, double p, Method method, Options options)
      : family_(std::move(family)), t_(t), dof_(member(p).system.dof()), method_(std::move(method)), options_(std::move(options)) {
    options_.keep_trajectory = false;
    const auto form = first_order_form(member(p).system);
    for (Eigen::Index i = 0; i < size(); ++i) names_.push_back(form.component_name(i));
  }

  Eigen::Index size() const override { return 2 * dof_; }
  double time() const override { return t_; }
  bool has_parameter() const override { return with_parameter; }
  bool projects() const override { return ProjectableSystem<FormOf<System>>; }
  std::string name(Eigen::Index i) const override { return names_[static_cast<std::size_t>(i)]; }

  Shot shot(const Eigen::VectorXd& x, double period, double p, double coarser) const override {
    constexpr int samples = 24;
    Options options = options_;
    options.rtol *= coarser;
    if (options.atol.is_default()) options.atol = AbsoluteTolerance::at_most(coarser * options_.atol[0]);
    else options.atol = Eigen::VectorXd(coarser * each_atol(options_, options_.atol.size()));
    for (int k = 0; k <= samples; ++k) options.output_times.push_back(k == samples ? t_ + period : t_ + period * k / samples);
    Shot shot;
    const auto taken = [&](const auto& s) {
      shot.outcome = s.outcome;
      shot.message = s.message;
      shot.x = s.y.head(size());
      shot.xdot = s.ydot.head(size());
      shot.Phi = s.Phi.topLeftCorner(size(), size());
      if (with_parameter) shot.by_parameter = s.Phi.col(size()).head(size());
      Eigen::MatrixXd seen(size(), s.run.samples.y.cols() + 1);
      seen << x, s.run.samples.y.topRows(size());
      shot.extent = seen.rowwise().maxCoeff() - seen.rowwise().minCoeff();
    };
    if constexpr (with_parameter) {
      const auto from_x = [&](const One& at) {
        auto one = family_(at);
        return problem(std::move(one.system), state(x), std::move(one.events));
      };
      taken(sensitivities(from_x, One(p), t_ + period, method_, options, WithRespectTo{.start = true}));
    } else {
      const auto one = member(p);
      taken(sensitivities(one.system, state(x), t_ + period, method_, options, one.events));
    }
    return shot;
  }

  Eigen::VectorXd rate(const Eigen::VectorXd& x, double p, double later) const override {
    const auto one = member(p);
    const auto& form = first_order_form(one.system);
    Eigen::VectorXd y = packed(form, state(x)), f(y.size());
    if constexpr (SwitchingSystem<std::remove_cvref_t<decltype(form)>>) {  // chooses the phases
      const Eigen::VectorXd resolution = options_.rtol * y.cwiseAbs() + each_atol(options_, y.size());
      form.switched(t_, y, std::vector<bool>(static_cast<std::size_t>(form.guard_count())), resolution);
    }
    form.derivative(t_ + later, y, f);
    return f.head(size());
  }
  double energy(const Eigen::VectorXd& x, double p, double later) const override {
    return jacobi_energy(member(p).system.system(), state(x, later));
  }
  Eigen::VectorXd momenta(const Eigen::VectorXd& x, double p, double later) const override {
    return conjugate_momenta(member(p).system.system(), state(x, later));
  }
  Eigen::VectorXd settled(const Eigen::VectorXd& x, double p) const override {
    const auto one = member(p);
    const auto& form = first_order_form(one.system);
    if constexpr (ProjectableSystem<std::remove_cvref_t<decltype(form)>>) {
      Eigen::VectorXd y = packed(form, state(x));
      form.project(t_, y);
      return y.head(size());
    }
    return x;
  }

 private:
  Member member(double p) const { return family_(One(p)); }
  State<n> state(const Eigen::VectorXd& x, double later = 0.0) const { return State<n>{t_ + later, x.head(dof_), x.tail(dof_)}; }

  Family family_;
  double t_;
  Eigen::Index dof_;
  Method method_;
  Options options_;
  std::vector<std::string> names_;
};

}  // namespace qdot::detail
