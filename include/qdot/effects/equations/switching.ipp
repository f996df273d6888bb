#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of switching.hpp. A program that links qdot::compiled has them from there.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "qdot/effects/equations/phase_choice.hpp"
#include "qdot/effects/equations/shared_forces.hpp"
#include "qdot/effects/equations/switching.hpp"
#include "qdot/effects/equations/switching_scene.hpp"
#include "qdot/effects/impact.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/error.hpp"

namespace qdot::detail {

// Contacts and frictions at one moment of a scene.
template <class = void>  // compiled only where it is called
class Switching {
  using VectorXd = Eigen::VectorXd;

 public:
  explicit Switching(const SwitchingScene& scene) : scene_(scene) {}

  void write_bands(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z, const VectorXd& tolerance, Eigen::Ref<VectorXd> out) const {
    const Eigen::MatrixXd J = scene_.jacobian(t, q, qdot, everything(z));
    const VectorXd f = scene_.rhs(t, q, qdot, z);
    for (Eigen::Index k = 0; k < scene_.count(); ++k) {
      const SwitchingPart& part = scene_.parts()[at(k)];
      if (part.is_contact) {
        out[k] = part.is_active(z) ? force_scale(J, f, part.row) * negligible_force : weighted(J, part.row, tolerance.head(q.size()));
      } else {
        const double F_s = scene_.sticking_limit(k, t, q, qdot);
        out[k] = part.is_active(z)                         ? negligible_force * F_s * F_s
                 : z[part.state] == PhaseNumber::begins ? negligible_force
                                                        : weighted(J, part.row, part.rows, tolerance.segment(q.size(), q.size()));
      }
    }
  }

  bool gap_has_moved(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z, const VectorXd& tolerance) const {
    const Eigen::MatrixXd J = scene_.jacobian(t, q, qdot, everything(z));
    const VectorXd phi = scene_.residual(t, q, everything(z));
    return std::any_of(scene_.parts().begin(), scene_.parts().end(), [&](const SwitchingPart& part) {
      return part.is_contact && part.is_active(z) && std::abs(phi[part.row]) > play(J, q, tolerance, part.row);
    });
  }

  std::vector<std::string> settle(double t, VectorXd& q, VectorXd& qdot, VectorXd& z, std::vector<bool> fired, const VectorXd& tolerance,
                                  const std::vector<bool>* left_out) const {
    std::vector<std::string> names;
    const VectorXd before = z;
    std::vector<Switch> all(at(scene_.count()));
    const auto each_left_out = [&](const auto& use) {
      for (std::size_t k = 0; k < all.size(); ++k) {
        const SwitchingPart& part = scene_.parts()[k];
        if (left_out != nullptr && (*left_out)[k] && !part.is_active(before)) use(k, part.state);
      }
    };
    each_left_out([&](std::size_t k, Eigen::Index) { fired[k] = true; });  // its gap may be negative
    if (scene_.has_lasting_constraints()) scene_.project(t, q, qdot, nothing(z));
    look(t, q, qdot, z, fired, tolerance, all, left_out != nullptr);
    each_left_out([&](std::size_t k, Eigen::Index) { all[k].fired = all[k].touches = false, all[k].still = -1.0; });  // no candidate
    strike(t, q, qdot, all, names);
    come_to_rest(t, q, qdot, z, all);
    choose_phases(scene_, t, q, qdot, before, all, z);
    each_left_out([&](std::size_t, Eigen::Index zi) { z[zi] = before[zi]; });
    VectorXd held = z;  // sliding in a plane begins from rest
    for (std::size_t k = 0; k < all.size(); ++k)
      if (const SwitchingPart& part = scene_.parts()[k]; part.is_plane() && all[k].candidate && before[part.state] != PhaseNumber::begins)
        held[part.state] = PhaseNumber::sticks;
    if (!scene_.is_free(held)) scene_.project(t, q, qdot, held);
    for (const SwitchingPart& part : scene_.parts()) {
      const double was = before[part.state], is = z[part.state];
      if (was == PhaseNumber::undecided || was == is) continue;
      if (part.is_contact) {
        if (was == PhaseNumber::closed) names.push_back(part.opens);
        if (is == PhaseNumber::closed) names.push_back(part.rests);
      } else if (!part.is_plane() || is == PhaseNumber::sticks || was == PhaseNumber::sticks) {
        names.push_back(part.name + (is == PhaseNumber::sticks ? " sticks" : was == PhaseNumber::sticks ? " slips" : " turns"));
      }
    }
    return names;
  }

  // all ← what is known of each effect at a state.
  //
  // is_displaced: beside a motion whose derivatives are asked for.
  void look(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z, const std::vector<bool>& fired, const VectorXd& tolerance,
            std::vector<Switch>& all, bool is_displaced = false) const {
    const Eigen::MatrixXd J = scene_.jacobian(t, q, qdot, everything(z));
    const VectorXd phi = scene_.residual(t, q, everything(z)), u = scene_.velocity(t, q, qdot, everything(z));
    give_way(t, q, qdot, z, fired, all);
    for (std::size_t k = 0; k < all.size(); ++k) {
      const SwitchingPart& part = scene_.parts()[k];
      const Eigen::Index row = part.row;
      Switch& one = all[k];
      one.contact = part.is_contact;
      one.u = part.size_in(u);
      one.still = 10 * weighted(J, row, part.rows, tolerance.segment(q.size(), q.size()));
      const double resolved = weighted(J, row, part.rows, tolerance.head(q.size()));
      one.lowest = 100 * resolved;
      if (!one.contact) {
        if (one.fired && !part.is_active(z) && stops_here(t, q, qdot, z, part, one, is_displaced)) one.still = std::max(one.still, std::abs(one.u));
        continue;
      }
      const bool active = part.is_active(z);
      const double known_to = z[part.state] == PhaseNumber::undecided ? negligible_force : 16 * std::numeric_limits<double>::epsilon();
      const double rounding = known_to * weighted(J, row, q.cwiseAbs());
      const double deepest = active ? play(J, q, tolerance, row) : 100 * resolved + rounding;
      one.touches = active ? phi[row] <= deepest : one.fired || phi[row] <= 10 * resolved + rounding;
      if ((active || !one.fired) && phi[row] < -deepest) refuse_gap(t, part.name, phi[row], active);
    }
  }

  // Contacts whose next hop is too low to be told from none have no velocity.
  void come_to_rest(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z, std::vector<Switch>& all) const {
    if (std::none_of(all.begin(), all.end(), [](const Switch& one) { return one.touches && one.u > one.still; })) return;
    VectorXd trial = nothing(z);
    for (std::size_t k = 0; k < all.size(); ++k) {
      const SwitchingPart& part = scene_.parts()[k];
      const Switch& one = all[k];
      if (one.contact && part.is_active(z) && one.u <= one.still) trial[part.state] = PhaseNumber::closed;
      if (!one.contact && std::abs(one.u) > one.still) trial[part.state] = one.u > 0 ? 1.0 : -1.0;
    }
    const VectorXd rate = scene_.row_accelerations(t, q, qdot, scene_.acceleration_without_lines(t, q, qdot, trial), everything(z));
    for (std::size_t k = 0; k < all.size(); ++k) {
      Switch& one = all[k];
      const Eigen::Index row = scene_.parts()[k].row;
      if (!one.touches || one.u <= one.still || rate[row] >= 0) continue;
      const double height = one.u * one.u / (-2 * rate[row]), flight = 2 * one.u / -rate[row];
      if (height < one.lowest || flight < 1e3 * std::numeric_limits<double>::epsilon() * std::abs(t)) one.u = 0.0;
    }
  }

 private:
  static std::size_t at(Eigen::Index k) { return static_cast<std::size_t>(k); }
  VectorXd everything(const VectorXd& z) const { return scene_.with_all_active(z); }
  VectorXd nothing(const VectorXd& z) const { return scene_.with_none_active(z); }

  // How far a closed gap may be from zero.
  static double play(const Eigen::MatrixXd& jacobian, const VectorXd& q, const VectorXd& tolerance, Eigen::Index row) {
    return 100 * weighted(jacobian, row, tolerance.head(q.size())) + 64 * std::numeric_limits<double>::epsilon() * weighted(jacobian, row, q.cwiseAbs());
  }

  [[noreturn, gnu::cold]] static void refuse_gap(double t, const std::string& name, double gap, bool closed) {
    throw ConstraintError(name, t, -gap,
                          closed ? sentence({"the gap of a closed contact must not be moved below zero, but at t = ", t, " that of '", name, "' is ", gap,
                                             "; leave it closed, or open"})
                                 : "the gap of a contact must not be negative, but at t = " + std::to_string(t) + " that of '" + name + "' is " +
                                       std::to_string(gap) + "; start with the contact open or just closed");
  }

  // Which effects have reached their limits: those that fired, and with the first of a set all of it.
  void give_way(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z, const std::vector<bool>& fired, std::vector<Switch>& all) const {
    bool active = false;
    for (std::size_t k = 0; k < all.size(); ++k) {
      all[k].fired = fired[k];
      active = active || (fired[k] && scene_.parts()[k].is_active(z));
    }
    if (!active) return;
    const auto [lambda, rank] = scene_.forces(t, q, qdot, z);
    SharedForces shared;
    if (rank < scene_.asked(z)) shared = shared_forces(scene_, t, q, qdot, z, lambda);
    std::vector<bool> sets(all.size(), false);
    for (std::size_t k = 0; k < shared.set.size(); ++k)
      if (shared.set[k] >= 0 && fired[k]) sets[static_cast<std::size_t>(shared.set[k])] = true;
    for (std::size_t k = 0; k < all.size(); ++k) {
      const SwitchingPart& part = scene_.parts()[k];
      if (!part.is_active(z)) continue;
      const bool shares = !shared.set.empty() && shared.set[k] >= 0;
      if (shares) all[k].fired = sets[static_cast<std::size_t>(shared.set[k])];
      if (!all[k].fired || part.is_contact) continue;
      all[k].slips = part.is_plane() ? 1 : shares ? -shared.stops[k] : lambda[part.row] > 0 ? -1 : 1;
      if (part.is_plane()) all[k].along.head(part.rows) = -lambda.segment(part.row, part.rows).normalized();
    }
  }

  // Whether what slid has come to v = 0: not yet past it, or by no more than integration and projection can tell. A v that jumps has not.
  bool stops_here(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z, const SwitchingPart& part, const Switch& one,
                  bool is_displaced) const {
    if (std::abs(one.u) <= one.still) return true;
    if (part.is_plane() && !is_displaced) {  // it may pass by v = 0
      const double slowest = slowest_slide * z.segment(part.state + 1, part.rows).norm();
      return z[part.state] != PhaseNumber::begins && one.u <= (1 + negligible_force) * slowest;
    }
    if (!part.is_plane() && one.u * z[part.state] > 0) return true;
    const VectorXd a = scene_.acceleration(t, q, qdot, z);
    return one.u * one.u < 2 * std::abs(part.size_in(VectorXd(scene_.row_accelerations(t, q, qdot, a, everything(z))))) * one.lowest;
  }

  // The blows on all contacts that approach.
  void strike(double t, const VectorXd& q, VectorXd& qdot, std::vector<Switch>& all, std::vector<std::string>& names) const {
    if (std::none_of(all.begin(), all.end(), [](const Switch& one) { return one.touches && one.u < -one.still; })) return;
    const VectorXd& z = scene_.initial_states();
    const Eigen::MatrixXd J = scene_.jacobian(t, q, qdot, everything(z));
    const ConstrainedFactors<Dynamic, Dynamic> factors(scene_.mass_matrix(t, q, qdot), scene_.jacobian(t, q, qdot, nothing(z)), default_rank_cutoff);
    std::vector<std::size_t> struck;
    std::vector<ImpactLaw> laws;
    for (std::size_t k = 0; k < all.size(); ++k)
      if (all[k].touches) struck.push_back(k), laws.push_back(scene_.parts()[k].law);
    const auto row = [&](Eigen::Index i) { return J.row(scene_.parts()[struck[at(i)]].row); };
    const auto size = static_cast<Eigen::Index>(struck.size());
    Eigen::MatrixXd W(q.size(), size), A(size, size);
    VectorXd u(size), still(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      W.col(i) = factors.solution(VectorXd(row(i).transpose()), VectorXd::Zero(scene_.rows()), t, NamesOfRows{scene_}).qddot;
      u[i] = all[struck[at(i)]].u;
      still[i] = all[struck[at(i)]].still;
    }
    for (Eigen::Index i = 0; i < size; ++i)
      for (Eigen::Index j = 0; j < size; ++j) A(i, j) = row(i).dot(W.col(j));
    VectorXd impulse;
    try {
      impulse = impulses(A, u, laws, still);
    } catch (const NoImpulse& of) {
      refuse_blow(t, scene_.parts()[struck[at(of.contact)]].name);
    }
    qdot += W * impulse;
    const VectorXd after = scene_.velocity(t, q, qdot, everything(z));
    for (std::size_t k = 0; k < all.size(); ++k) all[k].u = scene_.parts()[k].size_in(after);
    for (Eigen::Index i = 0; i < size; ++i)
      if (impulse[i] > 0) names.push_back(scene_.parts()[struck[at(i)]].hits);
  }

  [[noreturn, gnu::cold]] static void refuse_blow(double t, const std::string& name) {
    throw ConstraintError(name, t, 0.0,
                          sentence({"contacts must leave what they strike a way out, but at t = ", t, " no finite impulse keeps the gap of '", name,
                                    "' from closing, as other constraints close against it; give one of them room, or a spring"}));
  }

  const SwitchingScene& scene_;
};

template <class>
void write_guard_bands(const SwitchingScene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& z,
                       const Eigen::VectorXd& tolerance, Eigen::Ref<Eigen::VectorXd> out) {
  Switching<>(scene).write_bands(t, q, qdot, z, tolerance, out);
}

template <class>
bool gap_has_moved(const SwitchingScene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& z,
                   const Eigen::VectorXd& tolerance) {
  return Switching<>(scene).gap_has_moved(t, q, qdot, z, tolerance);
}

template <class>
std::vector<std::string> settle(const SwitchingScene& scene, double t, Eigen::VectorXd& q, Eigen::VectorXd& qdot, Eigen::VectorXd& z, std::vector<bool> fired,
                                const Eigen::VectorXd& tolerance, const std::vector<bool>* left_out) {
  return Switching<>(scene).settle(t, q, qdot, z, std::move(fired), tolerance, left_out);
}

}  // namespace qdot::detail
