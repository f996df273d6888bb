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
#include "qdot/effects/rows/onset_direction.hpp"
#include "qdot/error.hpp"
#include "qdot/mechanics/equations/cholesky.hpp"

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
    // Each friction may begin to slide, be called back, and begin again; in a plane directions take some rounds to agree.
    constexpr std::size_t rounds_of_directions = 60;
    for (std::size_t round = 0; round < 3 * candidates_.size() + (has_planes_ ? rounds_of_directions : 1); ++round) {
      load(z, responses, p);
      if (!solve(p)) break;
      if (p.contradicting >= 0) refuse(p.contradicting);
      if (!change_sliding(responses, p)) return finish(z, responses, p);
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
    Eigen::Index axis = 0, axes = 1;  // of friction in a plane, a row of which this is
    double F_k = 0.0;                 // of friction in a plane
    Eigen::Vector3d s = Eigen::Vector3d::Zero();  // its direction of sliding
  };
  static std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

  // Phases of what has no choice, and which effects have one.
  void begin(VectorXd& z) {
    for (Eigen::Index k = 0; k < scene_.count(); ++k) {
      const SwitchingPart& part = scene_.parts()[at(k)];
      Switch& one = all_[at(k)];
      one.candidate = std::abs(one.u) <= one.still && (one.touches || !one.contact);
      z[part.state] = one.contact ? PhaseNumber::apart : one.u > 0 ? 1.0 : -1.0;
      if (part.is_plane() && !one.candidate) slide_on(part, one, z);
      if (!one.candidate) continue;
      if (part.is_plane()) {
        begin_in_plane(k, part, z);
        continue;
      }
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

  // A candidate for each row. Friction that slid and has not stopped goes on in its direction, what has left its limit of sticking in that of its force.
  void begin_in_plane(Eigen::Index k, const SwitchingPart& part, VectorXd& z) {
    const Switch& one = all_[at(k)];
    has_planes_ = true;
    Candidate c{k, part.state, part.row, false, part.is_active(before_)};
    c.axes = part.rows;
    c.F_s = scene_.sticking_limit(k, t_, q_, qdot_);
    c.F_k = scene_.sliding_limit(k, t_, q_, qdot_);
    c.direction = one.fired ? one.slips : slides_in_plane(before_[part.state]) ? 1 : 0;
    c.s = one.along;
    if (c.direction != 0 && !one.fired) {
      const VectorXd u = scene_.velocity(t_, q_, qdot_, scene_.with_all_active(before_));
      c.s.head(part.rows) = (u.segment(part.row, part.rows) + part.reference(z)).normalized();
    }
    z[part.state] = PhaseNumber::undecided;
    for (; c.axis < c.axes; ++c.axis, ++c.row) candidates_.push_back(c);
  }

  void take_decided(const VectorXd& z, const Responses<>& responses) {
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(candidates_.size()); ++i) {
      Candidate& c = candidates_[at(i)];
      c.decided = responses.is_decided(i);
      if (c.axes > 1 && c.axis + 1 == c.axes) slide_where_decided(i + 1 - c.axes, z);
      if (!c.decided || c.contact || c.axes > 1) continue;
      const VectorXd a = scene_.acceleration_without_lines(t_, q_, qdot_, z);
      const double rate = rates(a)[c.row], before = before_[c.zi];
      const int onward = std::abs(before) == 1.0 ? (all_[at(c.effect)].fired ? -1 : 1) * (before > 0 ? 1 : -1) : 1;
      c.direction = std::abs(rate) <= negligible_force * size_of(responses, a, rate, c.row) ? onward : rate > 0 ? 1 : -1;
    }
  }

  // Friction in a plane, whose first row is i, where the lasting constraints decide all of its rows: it slides to where they take it.
  void slide_where_decided(Eigen::Index i, const VectorXd& z) {
    const Candidate& first = candidates_[at(i)];
    Eigen::Index decided = 0;
    for (Eigen::Index k = 0; k < first.axes; ++k) decided += candidates_[at(i + k)].decided ? 1 : 0;
    if (decided > 0 && decided < first.axes) refuse_in_part(first);
    if (decided == 0) return;
    const VectorXd rate = rates(scene_.acceleration_without_lines(t_, q_, qdot_, z)).segment(first.row, first.axes);
    if (rate.norm() > 0) slide(i, 1, rate.normalized());
    else slide(i, 1, first.s.norm() > 0 ? VectorXd(first.s.head(first.axes)) : VectorXd(VectorXd::Unit(first.axes, 0)));
  }

  // Gives friction in a plane, whose first row is i, a direction of sliding; 0 where it may stick.
  bool slide(Eigen::Index i, int direction, const VectorXd& s) {
    for (Eigen::Index k = 0; k < s.size(); ++k) {
      candidates_[at(i + k)].direction = direction;
      candidates_[at(i + k)].s.head(s.size()) = s;
    }
    return true;
  }

  VectorXd rates(const VectorXd& a) const { return scene_.row_accelerations(t_, q_, qdot_, a, scene_.with_all_active(before_)); }

  // Of the terms in a row's acceleration.
  static double size_of(const Responses<>& responses, const VectorXd& a, double rate, Eigen::Index row) {
    return weighted(responses.J(), row, a.cwiseAbs()) + std::abs(rate - responses.J().row(row).dot(a));
  }

  // Accelerations without the forces that are sought, and the bounds of these.
  void load(VectorXd& z, const Responses<>& responses, BoundedMinimum& p) const {
    for (const Candidate& c : candidates_) {
      if (c.contact) continue;
      z[c.zi] = c.direction == 0 ? PhaseNumber::undecided : c.axes > 1 ? PhaseNumber::begins : static_cast<double>(c.direction);
      if (c.axes > 1 && c.axis == 0) refer_to(c, beyond_rest, 0.0, z);
    }
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
      else if (c.direction == 0) p.upper[i] = c.axes > 1 ? std::numeric_limits<double>::infinity() : c.F_s * responses.length(i), p.lower[i] = -p.upper[i];
    }
  }

  // Whether a friction begins to slide, or is called back.
  bool change_sliding(const Responses<>& responses, const BoundedMinimum& p) {
    bool changed = false;
    for (Eigen::Index i = 0; i < p.b.size(); ++i) {
      Candidate& c = candidates_[at(i)];
      if (c.axes > 1) {
        if (c.axis == 0 && change_in_plane(i, responses, p)) changed = true;
        continue;
      }
      if (c.contact || c.decided || std::abs(p.w[i]) <= p.least(i)) continue;
      const int goes = p.w[i] > 0 ? 1 : -1;
      if (c.direction == goes) continue;
      changed = true;
      if (c.direction == 0) c.direction = goes;
      else if (!c.came_back) c.direction = 0, c.came_back = true;
    }
    return changed;
  }

  // Friction in a plane that slides keeps its r, or else takes the direction of its velocity: after its guard and its onset, and where a blow has turned it.
  void slide_on(const SwitchingPart& part, const Switch& one, VectorXd& z) const {
    const VectorXd all = scene_.velocity(t_, q_, qdot_, scene_.with_all_active(before_)), u = all.segment(part.row, part.rows);
    if (!one.fired && before_[part.state] == 1.0 && u.dot(part.reference(z)) > 0.0) return;
    const double slow = std::max(slowness * one.still, 64 * std::numeric_limits<double>::epsilon() * u.norm());
    part.reference(z) = slow * u.normalized();
    part.inverse_speed(z) = slow / u.norm();
  }
  static bool slides_in_plane(double phase) { return phase == 1.0 || phase == PhaseNumber::begins; }

  // Whether friction in a plane, whose first row is i, begins to slide, is called back, or turns to where its acceleration agrees with its direction. Its
  // bounds are a circle: it is held first, and where it would need more than F_s it slides (effects/rows/onset_direction.hpp).
  bool change_in_plane(Eigen::Index i, const Responses<>& responses, const BoundedMinimum& p) {
    Candidate& first = candidates_[at(i)];
    const Eigen::Index m = first.axes;
    VectorXd lengths(m), force = VectorXd::Zero(m), rate = VectorXd::Zero(m);
    for (Eigen::Index k = 0; k < m; ++k) {
      lengths[k] = responses.length(i + k);
      if (lengths[k] == 0.0) continue;  // the lasting constraints decide it
      force[k] = p.x[i + k] / lengths[k];
      rate[k] = p.w[i + k] * lengths[k];
    }
    if (first.direction == 0) return force.norm() > first.F_s * (1 + 1e-12) && slide(i, 1, -force.normalized());
    const VectorXd s = first.s.head(m);
    const Eigen::MatrixXd G = first.F_k * response_in_plane(i, m, lengths, p);
    const VectorXd braking = G * s, free = rate + braking;
    if (rate.norm() <= negligible_force * braking.norm()) return false;  // an onset without acceleration
    if (const auto turned = onset_direction(G, free)) return (*turned - s).norm() > same_direction && slide(i, 1, *turned);
    if (first.came_back) return false;
    first.came_back = true;
    return slide(i, 0, VectorXd::Zero(m));
  }

  // How the rows i, i + 1 … answer to a unit of force along each, while what is between its bounds holds.
  Eigen::MatrixXd response_in_plane(Eigen::Index i, Eigen::Index m, const VectorXd& lengths, const BoundedMinimum& p) const {
    std::vector<Eigen::Index> held;
    for (Eigen::Index k = 0; k < p.b.size(); ++k)
      if ((k < i || k >= i + m) && !candidates_[at(k)].decided && p.between(k)) held.push_back(k);
    Eigen::MatrixXd G = p.A.block(i, i, m, m);
    const auto count = static_cast<Eigen::Index>(held.size());
    Cholesky<double, Dynamic> factors;
    if (count > 0 && factors.compute(part_of(p.A, held)) && factors.smallest_pivot() > dependent_pivot)
      for (Eigen::Index k = 0; k < m; ++k) {
        VectorXd coupling(count);
        for (Eigen::Index j = 0; j < count; ++j) coupling[j] = p.A(held[at(j)], i + k);
        const VectorXd answer = factors.solve(coupling);
        for (Eigen::Index l = 0; l < m; ++l)
          for (Eigen::Index j = 0; j < count; ++j) G(l, k) -= p.A(held[at(j)], i + l) * answer[j];
      }
    return lengths.asDiagonal() * G * lengths.asDiagonal();
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
    for (Eigen::Index i = 0; i < p.b.size(); ++i) {
      const Candidate& c = candidates_[at(i)];
      if (c.axes == 1 || c.axis > 0 || c.direction == 0) continue;
      double square = 0.0;
      for (Eigen::Index k = i; k < i + c.axes; ++k) square += p.w[k] * p.w[k] * responses.length(k) * responses.length(k);
      // What it gains while t stands still counts as no velocity either.
      refer_to(c, slowness_of_onset, std::sqrt(square) * std::numeric_limits<double>::epsilon() * std::abs(t_), z);
    }
  }

  // r ← the direction in which friction in a plane begins to slide, as a velocity of a size in units of what counts as none, at least `least`.
  void refer_to(const Candidate& c, double size, double least, VectorXd& z) const {
    scene_.parts()[at(c.effect)].reference(z) = size * std::max({all_[at(c.effect)].still, least, least_still}) * c.s.head(c.axes);
  }

  [[noreturn]] void refuse_in_part(const Candidate& c) const {
    const std::string& name = scene_.parts()[at(c.effect)].name;
    throw ConstraintError(name, t_, 0.0,
                          sentence({"friction in a plane must be free to slide in all of its directions, or in none, but at t = ", t_,
                                    " constraints decide some of '", name, "'; give it a sliding velocity of the others alone"}));
  }
  [[noreturn]] void refuse(Eigen::Index i) const {
    const std::string& name = scene_.parts()[at(candidates_[at(i)].effect)].name;
    throw ConstraintError(name, t_, 0.0,
                          sentence({"contacts must not contradict each other, but at t = ", t_, " no finite force keeps the gap of '", name,
                                    "' from closing further, as the other constraints press against it; leave a gap, or remove one of them"}));
  }

  const SwitchingScene& scene_;
  double t_;
  static constexpr double slowness = 0.01, slowness_of_onset = 0.5;  // |w| of sliding and of an onset, in units of what counts as no velocity,
  static constexpr double beyond_rest = 1e12;                        // and while phases are chosen: its direction is that of w, whatever is left of v
  static constexpr double least_still = 1e-30;                       // where no tolerance says what that is
  static constexpr double same_direction = 1e-11;                    // its acceleration turns it further

  const VectorXd &q_, &qdot_, &before_;
  std::vector<Switch>& all_;
  std::vector<Candidate> candidates_;
  bool has_planes_ = false;
};

template <class>
void choose_phases(const SwitchingScene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& before,
                   std::vector<Switch>& all, Eigen::VectorXd& z) {
  PhaseChoice<>(scene, t, q, qdot, before, all).choose(z);
}

}  // namespace qdot::detail
