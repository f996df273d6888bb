#pragma once
// SPDX-License-Identifier: MIT
//
// Which phases follow from the accelerations, when velocities are known.
//
// A contact at φ = 0 without velocity may be closed, friction at v = 0 may stick; these are the candidates, all others have no choice.
// Their forces minimize ½ λᵀA λ + bᵀλ within their bounds (effects/rows/bounded_minimum.hpp), b the accelerations without them: this is Gauss's
// principle with one-sided constraints, and its accelerations w are unique, whether rows depend on each other or not. Then
//
//     contact      opens where w > 0; is closed where λ > 0, or where it was closed and is not asked to open
//     friction     slides where w ≠ 0, in that direction; sticks otherwise
//
// With F_k < F_s that is not all: what slides has F_k, and the rest is judged again. What slid before, or has left its limit of sticking
// in this moment, goes on to slide as long as w agrees. If no phases agree, no motion is made up: ConstraintError.
//
// Friction whose v the lasting constraints alone decide (a slider at its dead centre, a driven coordinate) is no candidate: no friction, however
// strong, could hold it there. It slides on to where they take it.

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "qdot/effects/equations/shared_forces.hpp"
#include "qdot/effects/scene_motion.hpp"

namespace qdot::detail {

// What is known of one effect while phases are chosen.
struct Switch {
  bool contact = false, fired = false, touches = false, candidate = false;
  double u = 0.0;       // φ̇ or v
  double still = 0.0;   // the size of velocities that count as none
  double lowest = 0.0;  // the height of hops that count as none
  int slips = 0;        // the direction in which it slips, where it has left its limit of sticking
};

inline constexpr double negligible_force = 1e-9;  // to which forces and accelerations are told from zero

template <class J, class Weights>
double weighted(const J& jacobian, Eigen::Index row, const Weights& weights) {
  return jacobian.row(row).cwiseAbs().dot(weights.transpose());
}

// The multiplier that would balance the applied forces along a row.
template <class J, class Q>
double force_scale(const J& jacobian, const Q& f, Eigen::Index row) {
  const double square = jacobian.row(row).squaredNorm();
  return square > 0 ? weighted(jacobian, row, f.cwiseAbs()) / square : 0.0;
}

template <class Sc>
class PhaseChoice {
  static constexpr int n = Sc::dof_at_compile_time, m = Sc::constraints_at_compile_time;
  using Q = Vector<double, n>;
  using Z = EffectStates<Sc>;

 public:
  PhaseChoice(const Sc& scene, double t, const Q& q, const Q& qdot, const Z& before, std::vector<Switch>& all)
      : scene_(scene), t_(t), q_(q), qdot_(qdot), before_(before), all_(all) {}

  // z ← the phases, from those before.
  void choose(Z& z) {
    begin(z);
    if (candidates_.empty()) return;
    std::vector<Eigen::Index> rows;
    for (const Candidate& c : candidates_) rows.push_back(c.row);
    const Responses<Sc> responses(scene_, t_, q_, qdot_, z, rows);
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
  void begin(Z& z) {
    for_each_switching(scene_, [&](Eigen::Index k, const auto& e, Eigen::Index zi, Eigen::Index row) {
      Switch& one = all_[at(k)];
      one.candidate = std::abs(one.u) <= one.still && (one.touches || !one.contact);
      z[zi] = one.contact ? 0.0 : one.u > 0 ? 1.0 : -1.0;
      if (!one.candidate) return;
      Candidate c{k, zi, row, one.contact, e.is_active(before_[zi])};
      if constexpr (!UnilateralEffect<std::remove_cvref_t<decltype(e)>, n>) {
        c.F_s = e.sticking_limit(q_, qdot_, t_);
        c.direction = !one.fired && std::abs(before_[zi]) == 1.0 ? (before_[zi] > 0 ? 1 : -1) : one.slips;
        z[zi] = 2.0;
      }
      candidates_.push_back(c);
    });
  }

  void take_decided(const Z& z, const Responses<Sc>& responses) {
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(candidates_.size()); ++i) {
      Candidate& c = candidates_[at(i)];
      c.decided = responses.is_decided(i);
      if (!c.decided || c.contact) continue;
      const Q a = acceleration_without_lines(scene_, q_, qdot_, t_, z);
      const double rate = rates(a)[c.row], before = before_[c.zi];
      const int onward = std::abs(before) == 1.0 ? (all_[at(c.effect)].fired ? -1 : 1) * (before > 0 ? 1 : -1) : 1;
      c.direction = std::abs(rate) <= negligible_force * size_of(responses, a, rate, c.row) ? onward : rate > 0 ? 1 : -1;
    }
  }

  Vector<double, m> rates(const Q& a) const { return constraint_acceleration(scene_, q_, qdot_, a, t_, with_all_active(scene_, before_)); }

  // Of the terms in a row's acceleration.
  static double size_of(const Responses<Sc>& responses, const Q& a, double rate, Eigen::Index row) {
    return weighted(responses.J(), row, a.cwiseAbs()) + std::abs(rate - responses.J().row(row).dot(a));
  }

  // Accelerations without the forces that are sought, and the bounds of these.
  void load(Z& z, const Responses<Sc>& responses, BoundedMinimum& p) const {
    for (const Candidate& c : candidates_)
      if (!c.contact) z[c.zi] = c.direction == 0 ? 2.0 : static_cast<double>(c.direction);
    const auto gamma = constraint_rows(scene_, q_, qdot_, t_, with_none_active(scene_, z)).gamma;
    const Q a = responses.factors().solution(Q(rhs(scene_, q_, qdot_, t_, z)), gamma, t_, SceneNames<Sc>{scene_}).qddot;
    const auto rate = rates(a);
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
  void finish(Z& z, const Responses<Sc>& responses, const BoundedMinimum& p) const {
    std::vector<Eigen::Index> held;
    for (Eigen::Index i = 0; i < p.b.size(); ++i) {
      const Candidate& c = candidates_[at(i)];
      if (!c.decided && c.direction == 0 && std::abs(p.w[i]) <= p.least(i)) held.push_back(i);
    }
    const Q f = rhs(scene_, q_, qdot_, t_, z);
    Z all_held = z;
    Vector<double, m> lambda = Vector<double, m>::Zero();
    for (const Eigen::Index i : held) {
      const Candidate& c = candidates_[at(i)];
      lambda[c.row] = p.x[i] / responses.length(i);
      all_held[c.zi] = c.contact ? 1.0 : 0.0;
    }
    SharedForces shared;
    if (null_space(part_of(p.A, held)).cols() > 0) {
      const ActiveRows<Sc> rows(scene_, t_, q_, qdot_, all_held, lambda);
      rows.split(t_, q_, qdot_, all_held, lambda);
      shared = rows.shared(static_cast<Eigen::Index>(all_.size()));
    }
    for (const Eigen::Index i : held) {
      const Candidate& c = candidates_[at(i)];
      const bool pressed = lambda[c.row] > negligible_force * force_scale(responses.J(), f, c.row);
      const bool shares = !shared.set.empty() && shared.set[at(c.effect)] >= 0 && shared.ease[at(c.effect)] > negligible_force;
      if (!c.contact || pressed || shares || (c.was_active && !all_[at(c.effect)].fired)) z[c.zi] = all_held[c.zi];
    }
  }

  [[noreturn]] void refuse(Eigen::Index i) const {
    std::string name;
    for_each_switching(scene_, [&](Eigen::Index k, const auto& e, Eigen::Index, Eigen::Index) {
      if (k == candidates_[at(i)].effect) name = e.name;
    });
    throw ConstraintError(name, t_, 0.0,
                          sentence({"contacts must not contradict each other, but at t = ", t_, " no finite force keeps the gap of '", name,
                                    "' from closing further, as the other constraints press against it; leave a gap, or remove one of them"}));
  }

  const Sc& scene_;
  double t_;
  const Q &q_, &qdot_;
  const Z& before_;
  std::vector<Switch>& all_;
  std::vector<Candidate> candidates_;
};

}  // namespace qdot::detail
