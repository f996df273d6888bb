#pragma once
// SPDX-License-Identifier: MIT
//
// The adjoint equations, along a motion that is known: what a number F that a run ends with depends on, backwards.
//
//     F = ∫ g(t, y, p) dt + h(y(T), p) ,        dF = λᵀ δy + … at any time,
//     λ(T) = ∂h/∂y ,    λ̇ = −Aᵀ λ − ∂g/∂y ,    dF/dp = ∂h/∂p + ∫ (Bᵀλ + ∂g/∂p) dt ,     A = ∂f/∂y ,  B = ∂f/∂p
//
// One λ, however many parameters. At an event the run forwards notes what becomes of small differences, Φ⁺ = S and P for those of y⁻ and p, and when
// the event is, ∂t_e = τ·δy⁻ + π·δp (equations.hpp). Backwards
//
//     λ⁻ = Sᵀλ⁺ + (g⁻ − g⁺) τ ,      dF/dp += Pᵀλ⁺ + (g⁻ − g⁺) π .
//
// Each step of the run is gone back by Gauss' collocation of order 14 on its polynomial y(t). It is smooth there, linear in λ, and
// solved by iteration, since the run's own steps are short in units of A. Legendre coefficients of what is integrated say if the step
// must be halved: that of the highest degree, squared, is about the error.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "qdot/analysis/variations/equations.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/steps/gauss_table.hpp"
#include "qdot/integrate/trajectory.hpp"

namespace qdot::detail {

// What a jump makes of small differences.
struct Transfer {
  double t = 0.0;
  Eigen::MatrixXd Phi{};             // [S P]
  std::vector<EventSlope> passed{};  // [τ π] of what happened there
};

// y of a model alone, which notes what its jumps do to the columns of Φ.
template <class = void>  // compiled only where it is made
class JumpRecorder final : public VariationalEquations {
 public:
  explicit JumpRecorder(VariationalEquations& of) : of_(of) {
    size_ = of.state_size();
    dof_ = of.dof();
  }

  const std::vector<Transfer>& transfers() const noexcept { return transfers_; }

  void write_rates(double t, const double* y, double* ydot) const override { of_.write_state_rates(t, y, ydot); }
  void write_state_rates(double t, const double* y, double* ydot) const override { of_.write_state_rates(t, y, ydot); }
  Eigen::VectorXd state_rate(double t, const Eigen::VectorXd& y) const override { return of_.state_rate(t, y); }
  ProjectionReport project(double t, Eigen::Ref<Eigen::VectorXd> y) const override { return of_.project(t, y); }
  Eigen::Index guard_count() const override { return of_.guard_count(); }
  std::string ending(Eigen::Index k) const override { return of_.ending(k); }
  void guards(double t, const Eigen::VectorXd& y, Eigen::Ref<Eigen::VectorXd> g) const override { of_.guards(t, y, g); }
  void guard_bands(double t, const Eigen::VectorXd& y, const Eigen::VectorXd& tolerance, Eigen::Ref<Eigen::VectorXd> g) const override {
    of_.guard_bands(t, y, tolerance, g);
  }
  std::vector<std::string> switched(double t, Eigen::VectorXd& y, const std::vector<bool>& fired, const Eigen::VectorXd& tolerance) override {
    std::vector<std::string> happened;
    through(t, y, [&](Eigen::VectorXd& both) { happened = of_.switched(t, both, fired, tolerance); });
    return happened;
  }
  void pass(const std::string& name, double t, Eigen::VectorXd& y, const Surface& surface) override {
    through(t, y, [&](Eigen::VectorXd& both) { of_.pass(name, t, both, surface); });
  }
  void pass_branch(double t, Eigen::VectorXd& y) override {
    through(t, y, [&](Eigen::VectorXd& both) { of_.pass_branch(t, both); });
  }
  std::string state_name(Eigen::Index i) const override { return of_.state_name(i); }
  std::string column_name(Eigen::Index j) const override { return of_.column_name(j); }
  void renew() override { of_.renew(); }
  std::unique_ptr<AnyWatch> watch(const Options& options) const override { return of_.watch(options); }
  double parameter_size(Eigen::Index column) const override { return of_.parameter_size(column); }

  // [y; tangent Φ] in front of a jump.
  Eigen::VectorXd tangents(double t, const Eigen::VectorXd& y) const {
    Eigen::VectorXd both = of_.seeded(y);
    of_.project(t, both);
    both.head(size_) = y;
    return both;
  }

 private:
  void through(double t, Eigen::VectorXd& y, const auto& jump) {
    const std::size_t before = of_.passed().size();
    Eigen::VectorXd both = tangents(t, y);
    jump(both);
    const Eigen::VectorXd after = both.head(size_);
    if (of_.passed().size() > before)
      transfers_.push_back({t, Eigen::Map<const Eigen::MatrixXd>(both.data() + size_, size_, of_.columns()),
                            {of_.passed().begin() + static_cast<std::ptrdiff_t>(before), of_.passed().end()}});
    y = after;
  }

  VariationalEquations& of_;
  std::vector<Transfer> transfers_;
};

// A number and its slopes at a moment.
struct TermAt {
  double value = 0.0, by_t = 0.0;
  double size = 0.0;  // of what the value may be a difference of
  Eigen::VectorXd by_y{}, by_p{};
};
using Term = std::function<void(double t, const Eigen::VectorXd& y, TermAt& at)>;  // none for zero

template <class = void>  // compiled only where it is made
class AdjointEquations {
  static constexpr int stages = 7;

 public:
  AdjointEquations(VariationalEquations& equations, const DenseOutput& motion, Term g, double rtol)
      : equations_(equations), motion_(motion), g_(std::move(g)), fine_(std::sqrt(rtol)), starts_(static_cast<Eigen::Index>(equations.start_entries().size())),
        parameters_(equations.columns() - starts_), rates_(equations.size()) {
    lambda = Eigen::VectorXd::Zero(starts_);
    by_p = Eigen::VectorXd::Zero(parameters_);
    total_ = Eigen::VectorXd::Zero(parameters_ + 1);
    whole_ = Eigen::VectorXd::Zero(equations.state_size());
    K_.resize(stages, starts_);
    equations_.leaves_parameters_out = equations_.goes_backwards() && parameters_ > 0;
  }
  AdjointEquations(const AdjointEquations&) = delete;
  ~AdjointEquations() { equations_.leaves_parameters_out = false; }

  Eigen::VectorXd lambda;  // of the entries that Φ has columns for
  Eigen::VectorXd by_p;
  double integral = 0.0;
  bool exact = true;  // no part of a step was left too long

  // From the end of the motion to its start.
  void go_back(const std::vector<Transfer>& transfers) {
    const std::vector<double> times = motion_.times();
    std::size_t left = transfers.size();
    const bool forwards = times.back() >= times.front();
    halvings_left_ = 1000 + 10 * static_cast<long>(times.size());
    for (std::size_t k = times.size(); k-- > 0;) {
      while (left > 0 && (k == 0 || (forwards ? transfers[left - 1].t > times[k - 1] : transfers[left - 1].t < times[k - 1]))) pass(transfers[--left]);
      if (k > 0) over(times[k], times[k - 1]);
    }
  }

  double g(double t, const Eigen::VectorXd& y) const {
    if (!g_) return 0.0;
    TermAt at;
    g_(t, y, at);
    return at.value;
  }

 private:
  struct Node {
    Eigen::MatrixXd A, B;  // of what varies
    Eigen::VectorXd y, f, by_p;
    double t = 0.0;
    TermAt g;
    Eigen::VectorXd lambda;
  };

  void pass(const Transfer& jump) {
    H_before_ = 0.0;
    Eigen::VectorXd behind = Eigen::VectorXd::Zero(jump.Phi.rows());
    for (Eigen::Index i = 0; i < starts_; ++i) behind[entry(i)] = lambda[i];
    Eigen::VectorXd moved = Eigen::VectorXd::Zero(jump.Phi.cols());
    for (const EventSlope& each : jump.passed)
      if (g_ && each.before.size() > 0) moved += (g(jump.t, each.before) - g(jump.t, each.after)) * each.time;
    for (Eigen::Index j = 0; j < jump.Phi.cols(); ++j) {
      double& to = j < starts_ ? lambda[j] : by_p[j - starts_];
      const double change = jump.Phi.col(j).dot(behind) + moved[j];
      to = j < starts_ ? change : to + change;
    }
  }

  Eigen::Index entry(Eigen::Index i) const { return equations_.start_entries()[static_cast<std::size_t>(i)]; }

  void look(double t, Node& node) {
    node.t = t;
    node.y.resize(motion_.size());
    motion_.evaluate(t, node.y);
    const Eigen::Index size = node.y.size();
    if (both_.size() == 0) both_ = equations_.seeded(node.y);
    both_.head(size) = node.y;
    equations_.write_rates(t, both_.data(), rates_.data());
    node.f = rates_.head(size);
    node.A.resize(starts_, starts_);
    node.B.resize(starts_, parameters_);
    for (Eigen::Index j = 0; j < starts_ + (equations_.leaves_parameters_out ? 0 : parameters_); ++j)
      for (Eigen::Index i = 0; i < starts_; ++i) (j < starts_ ? node.A(i, j) : node.B(i, j - starts_)) = rates_[size * (j + 1) + entry(i)];
    if (g_) g_(t, node.y, node.g);
  }

  // Bᵀλ + ∂g/∂p, where λ is known, and how fast λ·f is: p ∂F/∂p is made of that.
  double weigh(Node& node) {
    double fast = 0.0;
    for (Eigen::Index i = 0; i < starts_; ++i) {
      whole_[entry(i)] = node.lambda[i];
      fast += std::abs(node.lambda[i] * node.f[entry(i)]);
    }
    if (equations_.leaves_parameters_out) {
      node.by_p = equations_.parameter_gradient(node.t, node.y.data(), node.f.data(), whole_);
    } else {
      node.by_p.resize(parameters_);
      for (Eigen::Index j = 0; j < parameters_; ++j) node.by_p[j] = node.B.col(j).dot(node.lambda);
    }
    if (node.g.by_p.size() > 0) node.by_p += node.g.by_p;
    return fast;
  }

  // K where the polynomial of the part before goes on: half of the sweeps are spared.
  void guess(const GaussTable& gauss, double ratio) {
    K_.setZero();
    for (Eigen::Index i = 0; i < stages; ++i)
      for (Eigen::Index k = 0; k < stages; ++k) {
        const double weight = gauss.lagrange(k, 1.0 + ratio * gauss.c[i]);
        for (Eigen::Index j = 0; j < starts_; ++j) K_(i, j) += weight * K_before_(k, j);
      }
  }

  // λ̇ of an entry at a node; or what the sizes of its terms add up to, with a minus.
  double slope(const Node& node, Eigen::Index j, bool sizes) const {
    const double *const A = node.A.data() + starts_ * j, *const l = node.lambda.data();
    double sum = node.g.by_y.size() > 0 ? node.g.by_y[entry(j)] : 0.0;
    if (sizes) sum = std::abs(sum);
    for (Eigen::Index i = 0; i < starts_; ++i) sum += sizes ? std::abs(A[i] * l[i]) : A[i] * l[i];
    return -sum;
  }

  // What is known at the nodes of a part of a step, and a first K.
  //
  // @return  sizes of what is added to λ
  Eigen::VectorXd begin_part(const GaussTable& gauss, double from, double H) {
    for (Eigen::Index i = 0; i < stages; ++i) {
      look(from + gauss.c[i] * H, nodes_[i]);
      nodes_[i].lambda = lambda;
    }
    Eigen::VectorXd rough = Eigen::VectorXd::Zero(starts_);
    for (Eigen::Index i = 0; i < stages; ++i)
      for (Eigen::Index j = 0; j < starts_; ++j) {
        K_(i, j) = slope(nodes_[i], j, false);
        rough[j] = std::max(rough[j], std::abs(lambda[j]) - std::abs(H) * slope(nodes_[i], j, true));
      }
    if (H_before_ != 0.0 && std::abs(H) <= 2.0 * std::abs(H_before_)) guess(gauss, H / H_before_);
    return rough;
  }

  // Iterates K and λ at the nodes; whether they settle.
  bool iterate(const GaussTable& gauss, double H, Eigen::VectorXd& rough) {
    constexpr int most_sweeps = 60;
    const double exact_to = std::max(4 * std::numeric_limits<double>::epsilon(), 1e-3 * fine_ * fine_);
    bool settled = false;
    for (int sweep = 0; sweep < most_sweeps && !settled; ++sweep) {
      settled = true;
      for (Eigen::Index i = 0; i < stages; ++i) {
        Node& node = nodes_[i];
        for (Eigen::Index j = 0; j < starts_; ++j) {
          const double* const K = K_.data() + stages * j;
          double sum = 0.0;
          for (Eigen::Index k = 0; k < stages; ++k) sum += gauss.a(i, k) * K[k];
          node.lambda[j] = lambda[j] + H * sum;
          rough[j] = std::max(rough[j], std::abs(node.lambda[j]));
        }
        for (Eigen::Index j = 0; j < starts_; ++j) {
          const double now = slope(node, j, false);
          double& K = K_(i, j);
          settled = settled && std::abs(H * (now - K)) <= exact_to * rough[j];
          K = now;
        }
      }
    }
    return settled;
  }

  // The integral over a part of what `row` says at a node: the value, and the size of its terms, to whose rounding it is known.
  //
  // @param size    of what the integral is added to
  // @param smooth  becomes false where the polynomial of the values has not converged
  double integrated(const GaussTable& gauss, double H, const auto& row, double size, bool& smooth) const {
    double sum = 0.0, highest = 0.0, most = 0.0;
    for (Eigen::Index i = 0; i < stages; ++i) {
      const auto [value, of] = row(nodes_[i]);
      sum += gauss.b[i] * value;
      highest += gauss.b[i] * gauss.highest[i] * value;
      most = std::max(most, of);
    }
    smooth = smooth && std::abs(H * highest) * (2 * stages - 1) <= fine_ * (size + std::abs(H) * most);
    return H * sum;
  }

  // λ and the integrals over a part of a step, from its later end to its earlier one.
  void over(double from, double to) {
    static const GaussTable gauss(stages);
    const double H = to - from;
    Eigen::VectorXd rough = begin_part(gauss, from, H);
    bool smooth = iterate(gauss, H, rough);
    // What is integrated, by rows: K, then g, then Bᵀλ + ∂g/∂p.
    const auto summed = [&](const auto& row, double size) { return integrated(gauss, H, row, size, smooth); };
    Eigen::VectorXd next = lambda, part(parameters_ + 1);
    for (Eigen::Index j = 0; j < starts_; ++j)
      next[j] += summed([&](const Node& node) { return std::pair(K_(&node - nodes_, j), -slope(node, j, true)); }, std::abs(lambda[j]));
    part[parameters_] = -summed([&](const Node& node) { return std::pair(node.g.value, node.g.size); }, total_[parameters_]);
    const bool last = smooth || halvings_left_ <= 0;  // what depends on parameters is not asked for in vain
    double fast = 0.0;
    if (last && parameters_ > 0)
      for (Node& node : nodes_) fast = std::max(fast, weigh(node));
    for (Eigen::Index j = 0; last && j < parameters_; ++j) {
      const double rounded = fast / equations_.parameter_size(starts_ + j);
      part[j] = -summed([&](const Node& node) { return std::pair(node.by_p[j], std::abs(node.by_p[j]) + rounded); }, total_[j]);
    }
    if (!smooth && halvings_left_ > 0) {
      --halvings_left_;
      const double middle = from + 0.5 * H;
      over(from, middle);
      over(middle, to);
      return;
    }
    exact = exact && smooth;
    H_before_ = H;
    K_before_ = K_;
    lambda = next;
    by_p += part.head(parameters_);
    integral += part[parameters_];
    for (Eigen::Index j = 0; j <= parameters_; ++j) total_[j] += std::abs(part[j]);
  }

  VariationalEquations& equations_;
  const DenseOutput& motion_;
  Term g_;
  double fine_;
  Eigen::Index starts_, parameters_;
  Eigen::VectorXd rates_, both_, total_, whole_;
  Node nodes_[stages];
  Eigen::MatrixXd K_, K_before_;  // λ̇ at the nodes, a column for each entry; of the part before
  double H_before_ = 0.0;         // its length; 0 where a jump or nothing is in front
  long halvings_left_ = 0;
};

}  // namespace qdot::detail
