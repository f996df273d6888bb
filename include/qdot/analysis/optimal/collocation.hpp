#pragma once
// SPDX-License-Identifier: MIT
//
// A motion with inputs as a sparse program: collocation at Gauss' points
// ======================================================================
//
//     X_i − x_k − h Σ_j a_ij f(t_j, X_j, u_j) = 0 ,     x_{k+1} − x_k − h Σ_j b_j f(t_j, X_j, u_j) = 0 ,      h = τ_k (t_b − t_a)
//
// are steps of Gauss' method with s stages, of order 2s. Unknown are x_k at the ends of intervals, X_j and u_j at the
// points, and t_b. Inputs are polynomials of degree s − 1 in each interval, and may jump between. No point lies at an
// end, where an input may have no effect: the direction of a push on what is at rest. In H = Σ λ g + σ f each point has
// a block in (X_j, u_j), the curvature of f with weights ω = −h Σ_i a_ij λ_i. With t_j = t_a + ρ_j (t_b − t_a),
// G = ω·f/h, and y = (X_j, u_j),
//     ∂²/∂y∂t_b = τ ∂G/∂y + h ρ ∂²G/∂y∂t ,      ∂²/∂t_b² = 2 τ ρ ∂G/∂t + h ρ² ∂²G/∂t² .
// Conditions at the end are rows x_K − target + p − n = 0 with p, n ≥ 0, held at zero where some motion meets them all.
// Otherwise Σ (p + n), each in its extent, is minimized, and shows which conditions are missed, and by how much.

#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "qdot/analysis/optimal/controlled.hpp"
#include "qdot/analysis/optimal/sparse_program.hpp"
#include "qdot/integrate/steps/gauss_table.hpp"

namespace qdot::detail {

// What is asked of a motion. Sizes: states N, inputs m.
struct ControlTask {
  const Controlled* of = nullptr;
  double t_a = 0.0, least_t_b = 0.0, most_t_b = 0.0;
  Eigen::VectorXd start{};                 // x at t_a
  std::vector<Eigen::Index> held{};        // entries of x that have a target at the end
  Eigen::VectorXd target{};                // of each of them
  Eigen::VectorXd lower{}, upper{};        // of (x, u)
  Eigen::VectorXd scale{};                 // of x: its extents
};

// A motion on a mesh: states at its ends, and stages of each interval, (X, u) in columns.
struct ControlMesh {
  std::vector<double> part{};              // τ_k, which add up to 1
  double t_b = 0.0;
  Eigen::MatrixXd x{};                     // N×(K + 1)
  std::vector<Eigen::MatrixXd> stages{};   // K of (N + m)×s
};

template <class = void>  // compiled only where it is made
class Collocation final : public SparseProgram {
 public:
  Collocation(const ControlTask& task, ControlMesh mesh, int stages, bool elastic)
      : task_(task), mesh_(std::move(mesh)), table_(stages), elastic_(elastic), N_(task.of->states()), m_(task.of->inputs()), s_(stages),
        K_(static_cast<Eigen::Index>(mesh_.part.size())), E_(static_cast<Eigen::Index>(task.held.size())), stride_(N_ + s_ * (N_ + m_)) {
    place();
  }

  Eigen::VectorXd lower() const override { return bounds(task_.lower, task_.least_t_b, true); }
  Eigen::VectorXd upper() const override { return bounds(task_.upper, task_.most_t_b, false); }
  Eigen::Index rows() const override { return K_ * (s_ + 1) * N_ + E_; }
  const std::vector<Place>& jacobian_places() const override { return jacobian_; }
  const std::vector<Place>& hessian_places() const override { return hessian_; }

  Eigen::VectorXd start() const override {
    Eigen::VectorXd w = Eigen::VectorXd::Zero(size());
    w[0] = mesh_.t_b;
    for (Eigen::Index k = 0; k <= K_; ++k) w.segment(node(k), N_) = mesh_.x.col(k);
    for (Eigen::Index k = 0; k < K_; ++k)
      for (Eigen::Index j = 0; j < s_; ++j) w.segment(stage(k, j), N_ + m_) = mesh_.stages[static_cast<std::size_t>(k)].col(j);
    return w;
  }
  // The same mesh with the values of a solution.
  ControlMesh mesh(const Eigen::VectorXd& w) const {
    ControlMesh result = mesh_;
    result.t_b = w[0];
    for (Eigen::Index k = 0; k <= K_; ++k) result.x.col(k) = w.segment(node(k), N_);
    for (Eigen::Index k = 0; k < K_; ++k)
      for (Eigen::Index j = 0; j < s_; ++j) result.stages[static_cast<std::size_t>(k)].col(j) = w.segment(stage(k, j), N_ + m_);
    return result;
  }
  // How far the e-th condition at the end is missed: x_K − target.
  double missed(const Eigen::VectorXd& w, Eigen::Index e) const { return w[node(K_) + task_.held[static_cast<std::size_t>(e)]] - task_.target[e]; }
  // The cost itself, whatever is minimized.
  double cost(const Eigen::VectorXd& w) {
    look(w);
    double sum = task_.of->end_cost(end_of(w));
    for (Eigen::Index k = 0; k < K_; ++k)
      for (Eigen::Index j = 0; j < s_; ++j) sum += duration(w, k) * table_.b[j] * at(k, j).f[N_];
    return sum;
  }

  double objective(const Eigen::VectorXd& w) override {
    if (!elastic_) return cost(w);
    double sum = 0.0;
    for (Eigen::Index e = 0; e < E_; ++e) sum += (w[slack(e)] + w[slack(e) + 1]) / extent(e);
    return sum;
  }

  Eigen::VectorXd gradient(const Eigen::VectorXd& w) override {
    Eigen::VectorXd g = Eigen::VectorXd::Zero(size());
    if (elastic_) {
      for (Eigen::Index e = 0; e < E_; ++e) g[slack(e)] = g[slack(e) + 1] = 1.0 / extent(e);
      return g;
    }
    look(w);
    const Eigen::VectorXd slope = task_.of->end_slope(end_of(w));
    g.segment(node(K_), N_) = slope.head(N_);
    g[0] = slope[N_];
    for (Eigen::Index k = 0; k < K_; ++k)
      for (Eigen::Index j = 0; j < s_; ++j) {
        const ControlledRates& r = at(k, j);
        const double weight = duration(w, k) * table_.b[j];
        for (Eigen::Index i = 0; i < N_ + m_; ++i) g[stage(k, j) + i] += weight * r.slopes(N_, i);
        g[0] += tau(k) * table_.b[j] * r.f[N_] + weight * rho(k, j) * r.slopes(N_, N_ + m_);
      }
    return g;
  }

  Eigen::VectorXd residual(const Eigen::VectorXd& w) override {
    look(w);
    Eigen::VectorXd g(rows());
    for (Eigen::Index k = 0; k < K_; ++k)
      for (Eigen::Index i = 0; i <= s_; ++i) {
        Eigen::VectorXd gap = w.segment(i < s_ ? stage(k, i) : node(k + 1), N_) - w.segment(node(k), N_);
        for (Eigen::Index j = 0; j < s_; ++j) gap -= duration(w, k) * weight(i, j) * at(k, j).f.head(N_);
        g.segment(row(k, i), N_) = gap;
      }
    for (Eigen::Index e = 0; e < E_; ++e) g[row(K_, 0) + e] = missed(w, e) + w[slack(e)] - w[slack(e) + 1];
    return g;
  }

  std::vector<double> jacobian(const Eigen::VectorXd& w) override {
    look(w);
    std::vector<double> values;
    values.reserve(jacobian_.size());
    for (Eigen::Index k = 0; k < K_; ++k)
      for (Eigen::Index i = 0; i <= s_; ++i)
        for (Eigen::Index r = 0; r < N_; ++r) {
          double by_time = 0.0;
          values.push_back(1.0);
          values.push_back(-1.0);
          for (Eigen::Index j = 0; j < s_; ++j) {
            const ControlledRates& here = at(k, j);
            const double h = duration(w, k) * weight(i, j);
            for (Eigen::Index c = 0; c < N_ + m_; ++c) values.push_back(-h * here.slopes(r, c));
            by_time -= tau(k) * weight(i, j) * here.f[r] + h * rho(k, j) * here.slopes(r, N_ + m_);
          }
          values.push_back(by_time);
        }
    for (Eigen::Index e = 0; e < E_; ++e) values.insert(values.end(), {1.0, 1.0, -1.0});
    return values;
  }

  std::vector<double> hessian(const Eigen::VectorXd& w, double sigma, const Eigen::VectorXd& lambda) override {
    look(w);
    if (elastic_) sigma = 0.0;
    std::vector<double> values;
    values.reserve(hessian_.size());
    for (Eigen::Index k = 0; k < K_; ++k)
      for (Eigen::Index j = 0; j < s_; ++j) {
        const ControlledRates& here = at(k, j);
        Eigen::VectorXd omega = Eigen::VectorXd::Zero(N_ + 1);
        for (Eigen::Index i = 0; i <= s_; ++i)
          for (Eigen::Index r = 0; r < N_; ++r) omega[r] -= weight(i, j) * lambda[row(k, i) + r];
        omega[N_] = sigma * table_.b[j];
        const double h = duration(w, k), t = time(w, k, j), tau_k = tau(k), rho_j = rho(k, j);
        const Eigen::Index place = stage(k, j);
        const Eigen::MatrixXd H = task_.of->curvature(t, w.segment(place, N_), w.segment(place + N_, m_), omega, here.slopes);
        const Eigen::VectorXd slope = here.slopes.transpose() * omega;
        for (Eigen::Index a = 0; a < N_ + m_; ++a) {
          for (Eigen::Index b = 0; b <= a; ++b) values.push_back(h * H(a, b));
          values.push_back(tau_k * slope[a] + h * rho_j * H(a, N_ + m_));
        }
        values.push_back(2.0 * tau_k * rho_j * slope[N_ + m_] + h * rho_j * rho_j * H(N_ + m_, N_ + m_));
      }
    const Eigen::MatrixXd end = sigma * task_.of->end_curvature(end_of(w));
    for (Eigen::Index a = 0; a < N_; ++a) {
      for (Eigen::Index b = 0; b <= a; ++b) values.push_back(end(a, b));
      values.push_back(end(N_, a));
    }
    values.push_back(end(N_, N_));
    return values;
  }

 private:
  // Places: t_b; of each interval x_k and its stages; x_K; p and n of each condition.
  Eigen::Index size() const { return 1 + K_ * stride_ + N_ + 2 * E_; }
  Eigen::Index node(Eigen::Index k) const { return 1 + k * stride_; }
  Eigen::Index stage(Eigen::Index k, Eigen::Index j) const { return node(k) + N_ + j * (N_ + m_); }
  Eigen::Index slack(Eigen::Index e) const { return node(K_) + N_ + 2 * e; }
  Eigen::Index row(Eigen::Index k, Eigen::Index i) const { return (k * (s_ + 1) + i) * N_; }

  double tau(Eigen::Index k) const { return mesh_.part[static_cast<std::size_t>(k)]; }
  double rho(Eigen::Index k, Eigen::Index j) const { return before_[static_cast<std::size_t>(k)] + table_.c[j] * tau(k); }
  double weight(Eigen::Index i, Eigen::Index j) const { return i < s_ ? table_.a(i, j) : table_.b[j]; }
  double duration(const Eigen::VectorXd& w, Eigen::Index k) const { return tau(k) * (w[0] - task_.t_a); }
  double time(const Eigen::VectorXd& w, Eigen::Index k, Eigen::Index j) const { return task_.t_a + rho(k, j) * (w[0] - task_.t_a); }
  double extent(Eigen::Index e) const { return task_.scale[task_.held[static_cast<std::size_t>(e)]]; }
  Eigen::VectorXd end_of(const Eigen::VectorXd& w) const {
    Eigen::VectorXd xt(N_ + 1);
    xt << w.segment(node(K_), N_), w[0];
    return xt;
  }
  const ControlledRates& at(Eigen::Index k, Eigen::Index j) const { return rates_[static_cast<std::size_t>(k * s_ + j)]; }

  // Rates and slopes at all points, once for each w.
  void look(const Eigen::VectorXd& w) {
    if (seen_.size() == w.size() && (seen_.array() == w.array()).all()) return;
    seen_.resize(0);
    rates_.clear();
    for (Eigen::Index k = 0; k < K_; ++k)
      for (Eigen::Index j = 0; j < s_; ++j)
        rates_.push_back(task_.of->slopes(time(w, k, j), w.segment(stage(k, j), N_), w.segment(stage(k, j) + N_, m_)));
    seen_ = w;
  }

  Eigen::VectorXd bounds(const Eigen::VectorXd& of, double end, bool least) const {
    Eigen::VectorXd w(size());
    w[0] = end;
    for (Eigen::Index k = 0; k <= K_; ++k) w.segment(node(k), N_) = k == 0 ? task_.start : Eigen::VectorXd(of.head(N_));
    for (Eigen::Index k = 0; k < K_; ++k)
      for (Eigen::Index j = 0; j < s_; ++j) w.segment(stage(k, j), N_ + m_) = of;
    w.tail(2 * E_).setConstant(!least && elastic_ ? std::numeric_limits<double>::infinity() : 0.0);
    return w;
  }

  void place() {
    double sum = 0.0;
    for (const double part : mesh_.part) {
      before_.push_back(sum);
      sum += part;
    }
    for (Eigen::Index k = 0; k < K_; ++k)
      for (Eigen::Index i = 0; i <= s_; ++i)
        for (Eigen::Index r = 0; r < N_; ++r) {
          jacobian_.push_back({row(k, i) + r, (i < s_ ? stage(k, i) : node(k + 1)) + r});
          jacobian_.push_back({row(k, i) + r, node(k) + r});
          for (Eigen::Index j = 0; j < s_; ++j)
            for (Eigen::Index c = 0; c < N_ + m_; ++c) jacobian_.push_back({row(k, i) + r, stage(k, j) + c});
          jacobian_.push_back({row(k, i) + r, 0});
        }
    for (Eigen::Index e = 0; e < E_; ++e)
      for (const Eigen::Index column : {node(K_) + task_.held[static_cast<std::size_t>(e)], slack(e), slack(e) + 1})
        jacobian_.push_back({row(K_, 0) + e, column});
    const auto block = [&](Eigen::Index first, Eigen::Index count) {
      for (Eigen::Index a = 0; a < count; ++a) {
        for (Eigen::Index b = 0; b <= a; ++b) hessian_.push_back({first + a, first + b});
        hessian_.push_back({first + a, 0});
      }
      hessian_.push_back({0, 0});
    };
    for (Eigen::Index k = 0; k < K_; ++k)
      for (Eigen::Index j = 0; j < s_; ++j) block(stage(k, j), N_ + m_);
    block(node(K_), N_);
  }

  const ControlTask& task_;
  ControlMesh mesh_;
  GaussTable table_;
  bool elastic_;
  Eigen::Index N_, m_, s_, K_, E_, stride_;
  std::vector<double> before_;
  std::vector<Place> jacobian_, hessian_;
  Eigen::VectorXd seen_;
  std::vector<ControlledRates> rates_;
};

}  // namespace qdot::detail
