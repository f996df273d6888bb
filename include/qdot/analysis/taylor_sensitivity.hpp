#pragma once
// SPDX-License-Identifier: MIT
//
// Sensitivities by power series.
//
//     const auto s = sensitivities(system, start, 3.0, Taylor{}, {.rtol = 1e-13, .atol = 1e-14});
//
// Lagrange's equations, d/dt p = F with p = ∂L/∂q̇, are differentiated along a motion:
//
//     d/dt (P x + P_θ) = G x + F_θ ,       x = [δq; δq̇] ,   P = ∂p/∂(q, q̇) ,   G = ∂F/∂(q, q̇) ,
//
// for one column of Φ; P_θ and F_θ only in those of parameters θ. They are linear, so the series of x needs those of P and G and nothing else. Both are nodes of
// the motion's own graph (integrate/steps/recorded_motion.hpp), by reverse differentiation, and θ are variables of the graph. With s = (t − t₀)/τ,
//
//     M₀ δq̇_k = Σ_{j=1…k} (τ/k G_{j−1} − P_j) x_{k−j} − (∂p/∂q)₀ δq_k + τ/k F_θ,k−1 − P_θ,k ,       δq_k = τ/k δq̇_{k−1} ,
//
// where M₀ = (∂p/∂q̇)₀ is factored for the motion anyway. A column costs 2n² k multiplications in order k, several columns side by side in a register.
//
// The steps, their tests and their dense output are those of integrate/taylor.hpp; events and saltation those of analysis/sensitivity.hpp.

#include <Eigen/Core>
#include <algorithm>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/analysis/sensitivity.hpp"
#include "qdot/integrate/taylor.hpp"

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
template <>
struct is_recordable<VariationalForm<false>> : std::true_type {};

/// The power series of a motion and of its derivatives.
template <bool jumps>
class LagrangeSeries<VariationalForm<jumps>> {
 public:
  /// @throws NotAnalytic  T, V or a force compares values or has a kink
  LagrangeSeries(const VariationalForm<jumps>& form, int highest_order)
      : equations_(&form.equations()), n_(equations_->dof()), columns_(equations_->columns()), m_(equations_->recorder->record(theta_)) {
    constexpr Eigen::Index lanes = taylor::register_lanes;
    std::vector<int> x = m_.q;
    x.insert(x.end(), m_.qdot.begin(), m_.qdot.end());
    x.insert(x.end(), theta_.begin(), theta_.end());
    taylor::SweepOutputs outputs{.early = m_.p, .series = m_.force, .values = m_.mass, .late = m_.qdot};
    std::vector<int> rows;  // of P, then of G
    for (const auto* list : {&m_.p, &m_.force})
      for (const int node : *list) {
        const std::vector<int> row = m_.recording.graph.gradient(node, x);
        rows.insert(rows.end(), row.begin(), row.end());
      }
    outputs.series.insert(outputs.series.end(), rows.begin(), rows.end());
    outputs.series.insert(outputs.series.end(), m_.q.begin(), m_.q.end());
    outputs.series.insert(outputs.series.end(), theta_.begin(), theta_.end());
    outputs.series.push_back(m_.t);
    for (const auto& assumption : m_.recording.assumptions) outputs.values.push_back(assumption.node);
    sweep_ = taylor::Sweep(m_.recording.graph, outputs, highest_order);
    for (int& node : rows) node = sweep_.slot(node);
    slopes_ = rows;
    for (Eigen::Index i = 0; i < n_; ++i) names_.push_back(equations_->state_name(i));
    width_ = 2 * n_ + static_cast<Eigen::Index>(theta_.size());
    stride_ = (columns_ + lanes - 1) / lanes * lanes;
    coefficients_.setZero(equations_->size(), highest_order + 1);
    slope_series_.setZero(2 * n_ * width_, highest_order + 1);
    x_.assign(static_cast<std::size_t>(2 * n_ * (highest_order + 1) * stride_), 0.0);
    sums_.assign(static_cast<std::size_t>(n_ * stride_), 0.0);
    weights_.setZero(2 * n_ * (highest_order + 1), n_);
    M_.setZero(n_, n_);
    solution_.setZero(n_);
  }

  void renew(const VariationalForm<jumps>& form) {
    if (!is_of(form)) *this = LagrangeSeries(form, static_cast<int>(coefficients_.cols()) - 1);
  }
  bool is_of(const VariationalForm<jumps>&) { return equations_->recorder->holds(m_, theta_); }

  /// Orders 0 and 1.
  void start(double t, const Eigen::VectorXd& y, double time_unit) {
    unit_ = time_unit;
    equations_->note_size(y.data());
    coefficients_.col(0) = y;
    for (Eigen::Index i = 0; i < n_; ++i) {
      sweep_.set(sweep_.slot(m_.q[index(i)]), y[i]);
      sweep_.set(sweep_.slot(m_.qdot[index(i)]), y[n_ + i]);
    }
    for (std::size_t j = 0; j < theta_.size(); ++j) sweep_.set(sweep_.slot(theta_[j]), equations_->recorder->parameter(static_cast<Eigen::Index>(j)));
    sweep_.set(sweep_.slot(m_.t), t);
    sweep_.start();
    for (const auto& assumption : m_.recording.assumptions)
      if (sweep_.value(sweep_.slot(assumption.node)) == assumption.value)
        throw NonFinite("a Taylor coefficient", t,
                        sentence({"T, V or a force asks whether a quantity is exactly ", assumption.value, ", and at t = ", t,
                                  " it is, so the motion may not be analytic there; use Dop853"}));
    std::size_t next = 0;
    for (Eigen::Index i = 0; i < n_; ++i)
      for (Eigen::Index j = 0; j <= i; ++j) M_(i, j) = M_(j, i) = sweep_.value(sweep_.slot(m_.mass[next++]));
    if (!factors_.factor(M_)) throw_mass_matrix_error(M_, t, names_);
    note_slopes(0);
    for (Eigen::Index c = 0; c < columns_; ++c)
      for (Eigen::Index i = 0; i < 2 * n_; ++i) x(0, i, c) = y[2 * n_ * (c + 1) + i];
    make_order(1);
  }

  /// Orders 2 to `order`, after start().
  void expand(int order) {
    for (int k = 2; k <= order; ++k) make_order(k);
  }

  const Eigen::MatrixXd& coefficients() const noexcept { return coefficients_; }

 private:
  static std::size_t index(Eigen::Index i) { return static_cast<std::size_t>(i); }
  double& x(int k, Eigen::Index i, Eigen::Index c) { return x_[index((2 * n_ * k + i) * stride_ + c)]; }

  void note_slopes(int k) {
    for (std::size_t i = 0; i < slopes_.size(); ++i) slope_series_(static_cast<Eigen::Index>(i), k) = sweep_.latest(slopes_[i]);
  }

  void make_order(int k) {
    const double factor = unit_ / k;
    for (Eigen::Index i = 0; i < n_; ++i) solution_[i] = factor * sweep_.latest(sweep_.slot(m_.force[index(i)]));
    for (const int node : theta_) sweep_.set(sweep_.slot(node), 0.0);
    for (Eigen::Index i = 0; i < n_; ++i) {
      sweep_.set(sweep_.slot(m_.q[index(i)]), coefficients_(i, k) = factor * coefficients_(n_ + i, k - 1));
      sweep_.set(sweep_.slot(m_.qdot[index(i)]), 0.0);
    }
    sweep_.set(sweep_.slot(m_.t), k == 1 ? unit_ : 0.0);
    sweep_.advance(k);
    for (Eigen::Index i = 0; i < n_; ++i) solution_[i] -= sweep_.latest(sweep_.slot(m_.p[index(i)]));
    factors_.solve_in_place(solution_);
    for (Eigen::Index i = 0; i < n_; ++i) sweep_.set(sweep_.slot(m_.qdot[index(i)]), coefficients_(n_ + i, k) = solution_[i]);
    sweep_.complete(k);
    note_slopes(k);
    make_columns(k, factor);
  }

  // Order k of Φ.
  void make_columns(int k, double factor) {
    const Eigen::Index two_n = 2 * n_, half = n_ * width_;
    const auto weight = [&](Eigen::Index i, Eigen::Index l, int j) {
      return factor * slope_series_(half + i * width_ + l, j - 1) - slope_series_(i * width_ + l, j);
    };
    for (Eigen::Index i = 0; i < n_; ++i)
      for (int j = 1; j <= k; ++j)
        for (Eigen::Index l = 0; l < two_n; ++l) weights_(two_n * (k - j) + l, i) = weight(i, l, j);
    for (Eigen::Index i = 0; i < n_; ++i) {
      const double* const w = weights_.col(i).data();
      for (Eigen::Index c = 0; c < stride_; c += taylor::register_lanes) {
        taylor::Lanes even{}, odd{}, a, b;
        const double* from = x_.data() + c;
        for (Eigen::Index l = 0; l < two_n * k; l += 2, from += 2 * stride_) {
          taylor::read(a, from);
          taylor::read(b, from + stride_);
          even += w[l] * a;
          odd += w[l + 1] * b;
        }
        taylor::write(sums_.data() + i * stride_ + c, even + odd);
      }
    }
    const Eigen::Index first = columns_ - static_cast<Eigen::Index>(theta_.size());
    for (Eigen::Index c = 0; c < columns_; ++c) {
      for (Eigen::Index i = 0; i < n_; ++i) x(k, i, c) = factor * x(k - 1, n_ + i, c);
      for (Eigen::Index i = 0; i < n_; ++i) {
        double sum = sums_[index(i * stride_ + c)];
        for (Eigen::Index l = 0; l < n_; ++l) sum -= slope_series_(i * width_ + l, 0) * x(k, l, c);
        if (c >= first) sum += weight(i, two_n + c - first, k);
        solution_[i] = sum;
      }
      factors_.solve_in_place(solution_);
      for (Eigen::Index i = 0; i < n_; ++i) x(k, n_ + i, c) = solution_[i];
      for (Eigen::Index i = 0; i < two_n; ++i) coefficients_(two_n * (c + 1) + i, k) = x(k, i, c);
    }
  }

  VariationalEquations* equations_;
  Eigen::Index n_, columns_, width_ = 0, stride_ = 0;
  std::vector<int> theta_;  // variables of the parameters
  RecordedMotion m_;
  taylor::Sweep sweep_;
  std::vector<int> slopes_;  // slots of P and G, row by row
  std::vector<std::string> names_;
  Eigen::MatrixXd coefficients_, slope_series_, weights_, M_;
  std::vector<double> x_, sums_;  // x of all orders, a row for each component, columns side by side
  MassFactors<Dynamic> factors_;
  Eigen::VectorXd solution_;
  double unit_ = 1.0;
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
