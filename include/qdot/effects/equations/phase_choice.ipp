#pragma once
// SPDX-License-Identifier: MIT
//
// The function of phase_choice.hpp. A program that links qdot::compiled has it from there.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "qdot/effects/equations/phase_choice.hpp"
#include "qdot/effects/equations/shared_forces.hpp"
#include "qdot/effects/equations/shared_forces.ipp"
#include "qdot/effects/equations/switching_scene.hpp"
#include "qdot/effects/rows/bounded_minimum.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/error.hpp"

namespace qdot::detail {

template <class = void>  // compiled only where it is called
class PhaseChoice {
  using VectorXd = Eigen::VectorXd;

 public:
  PhaseChoice(const SwitchingScene& scene, double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& before, std::vector<Switch>& all)
      : scene_(scene), t_(t), q_(q), qdot_(qdot), before_(before), all_(all) {}

  // z ← the phases, from those before.
  void choose(VectorXd& z) {
    begin(z);
    if (candidates_.empty()) return;
    std::vector<Eigen::Index> rows;
    for (const Candidate& c : candidates_) rows.push_back(c.row);
    const Responses<> responses(scene_, t_, q_, qdot_, z, rows);
    take_decided(z, responses);
    BoundedMinimum p;
    p.A = responses.A();
    p.relative = negligible_force;
    // Each friction may begin to slide, be called back, and begin again.
    for (std::size_t round = 0; round < 3 * candidates_.size() + 1; ++round) {
      load(z, responses, p);
      if (!solve(p)) break;
      if (p.contradicting >= 0) refuse(p.contradicting);
      if (!change_sliding(p)) return finish(z, responses, p);
    }
    throw ConstraintError("contacts and friction", t_, 0.0,
                          sentence({"the phases of contacts and friction must fit together, but at t = ", t_,
                                    " no choice of closed and open, sticking and sliding does; look for contacts that depend on each other, "
                                    "or for a sliding friction larger than the sticking one"}));
  }

 private:
  struct Candidate {
    Eigen::Index effect, zi, row;
    bool contact, was_active;
    double F_s = 0.0;
    int direction = 0;       // of sliding, 0 while it may stick
    bool decided = false;    // by the lasting constraints
    bool came_back = false;  // from sliding
  };
  static std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

  // Phases of what has no choice, and which effects have one.
  void begin(VectorXd& z) {
    for (Eigen::Index k = 0; k < scene_.count(); ++k) {
      const SwitchingPart& part = scene_.parts()[at(k)];
      Switch& one = all_[at(k)];
      one.candidate = std::abs(one.u) <= one.still && (one.touches || !one.contact);
      z[part.state] = one.contact ? PhaseNumber::apart : one.u > 0 ? 1.0 : -1.0;
      if (!one.candidate) continue;
      Candidate c{k, part.state, part.row, one.contact, part.is_active(before_)};
      if (!part.is_contact) {
        const double phase = before_[part.state];
        c.F_s = scene_.sticking_limit(k, t_, q_, qdot_);
        c.direction = !one.fired && std::abs(phase) == 1.0 ? (phase > 0 ? 1 : -1) : one.slips;
        z[part.state] = PhaseNumber::undecided;
      }
      candidates_.push_back(c);
    }
  }

  void take_decided(const VectorXd& z, const Responses<>& responses) {
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(candidates_.size()); ++i) {
      Candidate& c = candidates_[at(i)];
      c.decided = responses.is_decided(i);
      if (!c.decided || c.contact) continue;
      const VectorXd a = scene_.acceleration_without_lines(t_, q_, qdot_, z);
      const double rate = rates(a)[c.row], before = before_[c.zi];
      const int onward = std::abs(before) == 1.0 ? (all_[at(c.effect)].fired ? -1 : 1) * (before > 0 ? 1 : -1) : 1;
      c.direction = std::abs(rate) <= negligible_force * size_of(responses, a, rate, c.row) ? onward : rate > 0 ? 1 : -1;
    }
  }

  VectorXd rates(const VectorXd& a) const { return scene_.row_accelerations(t_, q_, qdot_, a, scene_.with_all_active(before_)); }

  // Of the terms in a row's acceleration.
  static double size_of(const Responses<>& responses, const VectorXd& a, double rate, Eigen::Index row) {
    return weighted(responses.J(), row, a.cwiseAbs()) + std::abs(rate - responses.J().row(row).dot(a));
  }

  // Accelerations without the forces that are sought, and the bounds of these.
  void load(VectorXd& z, const Responses<>& responses, BoundedMinimum& p) const {
    for (const Candidate& c : candidates_)
      if (!c.contact) z[c.zi] = c.direction == 0 ? PhaseNumber::undecided : static_cast<double>(c.direction);
    const VectorXd gamma = scene_.gamma(t_, q_, qdot_, scene_.with_none_active(z));
    const VectorXd a = responses.factors().solution(scene_.rhs(t_, q_, qdot_, z), gamma, t_, NamesOfRows{scene_}).qddot;
    const VectorXd rate = rates(a);
    const auto size = static_cast<Eigen::Index>(candidates_.size());
    p.b = p.size = p.lower = p.upper = Eigen::VectorXd::Zero(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      const Candidate& c = candidates_[at(i)];
      const double of_row = size_of(responses, a, rate[c.row], c.row);
      if (c.decided) {
        if (c.contact && rate[c.row] < -negligible_force * of_row) refuse(i);
        continue;
      }
      p.b[i] = rate[c.row] / responses.length(i);
      p.size[i] = of_row / responses.length(i);
      if (c.contact) p.upper[i] = std::numeric_limits<double>::infinity();
      else if (c.direction == 0) p.upper[i] = c.F_s * responses.length(i), p.lower[i] = -p.upper[i];
    }
  }

  // Whether a friction begins to slide, or is called back.
  bool change_sliding(const BoundedMinimum& p) {
    bool changed = false;
    for (Eigen::Index i = 0; i < p.b.size(); ++i) {
      Candidate& c = candidates_[at(i)];
      if (c.contact || c.decided || std::abs(p.w[i]) <= p.least(i)) continue;
      const int goes = p.w[i] > 0 ? 1 : -1;
      if (c.direction == goes) continue;
      changed = true;
      if (c.direction == 0) c.direction = goes;
      else if (!c.came_back) c.direction = 0, c.came_back = true;
    }
    return changed;
  }

  // What is pressed is closed, and what could be pressed as another shares its force; what was closed stays so if it need not open.
  void finish(VectorXd& z, const Responses<>& responses, const BoundedMinimum& p) const {
    std::vector<Eigen::Index> held;
    for (Eigen::Index i = 0; i < p.b.size(); ++i) {
      const Candidate& c = candidates_[at(i)];
      if (!c.decided && c.direction == 0 && std::abs(p.w[i]) <= p.least(i)) held.push_back(i);
    }
    const VectorXd f = scene_.rhs(t_, q_, qdot_, z);
    VectorXd all_held = z, lambda = VectorXd::Zero(scene_.rows());
    for (const Eigen::Index i : held) {
      const Candidate& c = candidates_[at(i)];
      lambda[c.row] = p.x[i] / responses.length(i);
      all_held[c.zi] = c.contact ? PhaseNumber::closed : PhaseNumber::sticks;
    }
    SharedForces shared;
    if (null_space(part_of(p.A, held)).cols() > 0) {
      const ActiveRows<> rows(scene_, t_, q_, qdot_, all_held, lambda);
      rows.split(t_, q_, qdot_, all_held, lambda);
      shared = rows.shared(scene_.count());
    }
    for (const Eigen::Index i : held) {
      const Candidate& c = candidates_[at(i)];
      const bool pressed = lambda[c.row] > negligible_force * force_scale(responses.J(), f, c.row);
      const bool shares = !shared.set.empty() && shared.set[at(c.effect)] >= 0 && shared.ease[at(c.effect)] > negligible_force;
      if (!c.contact || pressed || shares || (c.was_active && !all_[at(c.effect)].fired)) z[c.zi] = all_held[c.zi];
    }
  }

  [[noreturn]] void refuse(Eigen::Index i) const {
    const std::string& name = scene_.parts()[at(candidates_[at(i)].effect)].name;
    throw ConstraintError(name, t_, 0.0,
                          sentence({"contacts must not contradict each other, but at t = ", t_, " no finite force keeps the gap of '", name,
                                    "' from closing further, as the other constraints press against it; leave a gap, or remove one of them"}));
  }

  const SwitchingScene& scene_;
  double t_;
  const VectorXd &q_, &qdot_, &before_;
  std::vector<Switch>& all_;
  std::vector<Candidate> candidates_;
};

template <class>
void choose_phases(const SwitchingScene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& before,
                   std::vector<Switch>& all, Eigen::VectorXd& z) {
  PhaseChoice<>(scene, t, q, qdot, before, all).choose(z);
}

}  // namespace qdot::detail
