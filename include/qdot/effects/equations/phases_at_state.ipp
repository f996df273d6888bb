#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of phases_at_state.hpp. A program that links qdot::compiled has them from there.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "qdot/effects/equations/phase_choice.hpp"
#include "qdot/effects/equations/phases_at_state.hpp"
#include "qdot/effects/equations/switching.ipp"
#include "qdot/effects/equations/switching_scene.hpp"
#include "qdot/error.hpp"
#include "qdot/mechanics/equations/ordinary_size.hpp"

namespace qdot::detail {

template <class>
Eigen::VectorXd resolution_of(const Eigen::VectorXd& q, const Eigen::VectorXd& qdot) {
  Eigen::VectorXd tolerance(2 * q.size());
  const auto least = [](double most) { return most > 0.0 ? std::min(1e-12, 1e-9 * most) : 1e-12; };  // as runs have it
  tolerance << 1e-9 * q.cwiseAbs().array() + least(q.cwiseAbs().maxCoeff()), 1e-9 * qdot.cwiseAbs().array() + least(qdot.cwiseAbs().maxCoeff());
  return tolerance;
}

// What phases fit a state.
template <class = void>  // compiled only where it is called
class FittingPhases {
  using VectorXd = Eigen::VectorXd;

 public:
  explicit FittingPhases(const SwitchingScene& scene) : scene_(scene) {}

  VectorXd chosen(double t, const VectorXd& q, const VectorXd& qdot) const {
    const VectorXd before = scene_.initial_states();
    VectorXd z = before;
    std::vector<Switch> all(static_cast<std::size_t>(scene_.count()));
    const Switching<> switching(scene_);
    switching.look(t, q, qdot, z, std::vector<bool>(all.size()), resolution_of(q, qdot), all);
    switching.come_to_rest(t, q, qdot, z, all);
    choose_phases(scene_, t, q, qdot, before, all, z);
    require_one_choice(t, q, qdot, z, all);
    return z;
  }

  void require_lasting(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z) const {
    std::vector<Switch> all(static_cast<std::size_t>(scene_.count()));
    Switching<>(scene_).look(t, q, qdot, z, std::vector<bool>(all.size()), resolution_of(q, qdot), all);
    const Eigen::MatrixXd J = scene_.jacobian(t, q, qdot, scene_.with_all_active(z));
    const auto now = rank_and_forces(t, q, qdot, z);
    const VectorXd f = scene_.rhs(t, q, qdot, z);
    for (std::size_t k = 0; k < all.size(); ++k) {
      const SwitchingPart& part = scene_.parts()[k];
      const Switch& one = all[k];
      const double force = part.size_in(now.lambda), phase = z[part.state];
      const auto shares = [&] {  // whether others hold with it, so that its part of a sum decides nothing
        VectorXd other = z;
        other[part.state] = part.is_contact ? PhaseNumber::apart : PhaseNumber::undecided;
        return rank_and_forces(t, q, qdot, other).rank == now.rank;
      };
      if (part.is_contact) {
        if (phase == PhaseNumber::closed && !(force > negligible_force * force_scale(J, f, part.row)) && !shares())
          refuse_edge(t, {"'", part.name, "' is closed with a reaction of ", {force + 0.0, 6}, ", and opens below 0"});
        if (phase != PhaseNumber::closed && one.touches)
          refuse_edge(t, {"'", part.name, "' touches without being pressed, with ", {one.u, 6}, " as the rate of its gap"});
      } else if (phase == PhaseNumber::sticks) {
        const double F_s = scene_.sticking_limit(static_cast<Eigen::Index>(k), t, q, qdot);
        if (!(std::abs(force) < (1 - negligible_force) * F_s) && !shares())
          refuse_edge(t, {"'", part.name, "' holds with ", {std::abs(force), 6}, " of at most ", {F_s, 6}});
      } else if (std::abs(one.u) <= one.still) {
        refuse_edge(t, {"'", part.name, "' slides without a velocity"});
      }
    }
  }

  VectorXd of_rest(double t, const VectorXd& q, const VectorXd& qdot) const {
    VectorXd z = scene_.initial_states();
    const VectorXd every = scene_.with_all_active(z), phi = scene_.residual(t, q, every), u = scene_.velocity(t, q, qdot, every);
    for (const SwitchingPart& part : scene_.parts()) {
      if (part.is_contact) z[part.state] = phi[part.row] <= touching(q) ? PhaseNumber::closed : PhaseNumber::apart;
      else if (part.size_in(u) == 0.0) z[part.state] = PhaseNumber::sticks;
      else z[part.state] = part.is_plane() ? PhaseNumber::begins : part.size_in(u) > 0.0 ? 1.0 : -1.0;
    }
    return z;
  }

  bool revise(double t, const VectorXd& q, const VectorXd& qdot, VectorXd& z) const {
    const VectorXd every = scene_.with_all_active(z), phi = scene_.residual(t, q, every), f = scene_.rhs(t, q, qdot, z);
    const Eigen::MatrixXd J = scene_.jacobian(t, q, qdot, every);
    const auto now = rank_and_forces(t, q, qdot, z);
    for (Eigen::Index k = 0; k < scene_.count(); ++k) {
      const SwitchingPart& part = scene_.parts()[static_cast<std::size_t>(k)];
      const double force = part.size_in(now.lambda);
      double& phase = z[part.state];
      if (part.is_contact) {
        const bool closed = phase == PhaseNumber::closed;
        if (closed ? force < -negligible_force * force_scale(J, f, part.row) : phi[part.row] < -touching(q)) {
          phase = closed ? PhaseNumber::apart : PhaseNumber::closed;
          return true;
        }
      } else if (phase == PhaseNumber::sticks) {
        const double F_s = scene_.sticking_limit(k, t, q, qdot);
        if (!(std::abs(force) > (1 + negligible_force) * F_s)) continue;
        throw_invalid_value({"friction must hold what rests, but near the start '", part.name, "' would have to hold ", {std::abs(force), 6},
                             " and holds up to ", {F_s, 6}, "; start where it can"});
      }
    }
    return false;
  }

  bool close_nearest(double t, const VectorXd& q, VectorXd& z) const {
    const VectorXd phi = scene_.residual(t, q, scene_.with_all_active(z));
    const SwitchingPart* nearest = nullptr;
    for (const SwitchingPart& part : scene_.parts())
      if (part.is_contact && z[part.state] != PhaseNumber::closed && (nearest == nullptr || phi[part.row] < phi[nearest->row])) nearest = &part;
    if (nearest != nullptr) z[nearest->state] = PhaseNumber::closed;
    return nearest != nullptr;
  }

 private:
  // A gap that is none.
  static double touching(const VectorXd& q) { return 1e-9 * reach_of(q.cwiseAbs().maxCoeff()); }

  // Rank and λ in given phases.
  SwitchingScene::Forces rank_and_forces(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z) const {
    if (scene_.is_free(z)) return {VectorXd::Zero(scene_.rows()), 0};
    return scene_.forces_without_lines(t, q, qdot, z);
  }

  // Refuses a state that fits another phase of an effect as well, with another acceleration.
  void require_one_choice(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z, const std::vector<Switch>& all) const {
    const VectorXd every = scene_.with_all_active(z), phi = scene_.residual(t, q, every), u = scene_.velocity(t, q, qdot, every);
    const Eigen::MatrixXd J = scene_.jacobian(t, q, qdot, every);
    const auto now = rank_and_forces(t, q, qdot, z);
    for (std::size_t k = 0; k < all.size(); ++k) {
      const SwitchingPart& part = scene_.parts()[k];
      const Eigen::Index row = part.row;
      const double phase = z[part.state];
      const auto limit = [&] { return scene_.sticking_limit(static_cast<Eigen::Index>(k), t, q, qdot); };
      constexpr double blurred = 1e-4;
      const double speed = part.size_in(u);
      const bool slow = std::abs(speed) <= blurred * weighted(J, row, part.rows, qdot.cwiseAbs());
      // The force that would keep its constraint, if that is none of others.
      const auto if_active = [&]() -> std::optional<double> {
        VectorXd other = z;
        other[part.state] = every[part.state];
        const auto then = rank_and_forces(t, q, qdot, other);
        return then.rank > now.rank ? std::optional<double>(part.size_in(then.lambda)) : std::nullopt;
      };
      if (part.is_contact) {
        if (all[k].candidate || phase == PhaseNumber::closed || !slow || !(phi[row] <= blurred * weighted(J, row, q.cwiseAbs()))) continue;
        if (const auto force = if_active(); force && *force > 0)
          refuse(t, {"'", part.name, "' may be open or closed, with a gap of ", {phi[row], 3}, " that changes at the rate ", {u[row], 3}});
      } else if (phase != PhaseNumber::sticks) {
        if (all[k].candidate || !slow) continue;
        if (const auto force = if_active(); force && std::abs(*force) <= limit())
          refuse(t, {"'", part.name, "' may slide or stick, with a velocity of ", {speed, 3}});
      } else if (const double F_s = limit(); F_s > 0 && std::abs(part.size_in(now.lambda)) >= (1 - negligible_force) * F_s &&
                                             slips_there(t, q, qdot, z, part, now.lambda, J)) {
        refuse(t, {"'", part.name, "' may hold or begin to slip, at its limit of sticking of ", {F_s, 6}});
      }
    }
  }

  // Whether what holds with a force at its limit would go on to slide if it slid.
  bool slips_there(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z, const SwitchingPart& part, const VectorXd& lambda,
                   const Eigen::MatrixXd& J) const {
    VectorXd other = z;
    const VectorXd along = -lambda.segment(part.row, part.rows).normalized();
    other[part.state] = part.is_plane() ? PhaseNumber::begins : std::copysign(1.0, along[0]);
    if (part.is_plane()) part.reference(other) = along;
    const VectorXd a = scene_.acceleration_without_lines(t, q, qdot, other);
    const VectorXd rates = scene_.row_accelerations(t, q, qdot, a, scene_.with_all_active(z));
    return along.dot(rates.segment(part.row, part.rows)) > 1e3 * negligible_force * weighted(J, part.row, part.rows, a.cwiseAbs());
  }

  [[noreturn, gnu::cold]] static void refuse(double t, std::initializer_list<Phrase> what) {
    throw_invalid_value({"a state must decide the phases of contacts and friction, but at t = ", {t, 6}, " ", sentence(what),
                         "; pass the effects' own states z as well, which stand behind q and qdot in run.trajectory.y(t)"});
  }
  [[noreturn, gnu::cold]] static void refuse_edge(double t, std::initializer_list<Phrase> what) {
    throw_invalid_value({"small motions need phases of contacts and friction that last, but at t = ", {t, 6}, " ", sentence(what),
                         "; take a state off this edge, or put a constraint in place of what holds"});
  }

  const SwitchingScene& scene_;
};

template <class>
Eigen::VectorXd phases_at_state(const SwitchingScene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot) {
  return FittingPhases<>(scene).chosen(t, q, qdot);
}

template <class>
void require_lasting_phases(const SwitchingScene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& z) {
  FittingPhases<>(scene).require_lasting(t, q, qdot, z);
}

template <class>
Eigen::VectorXd phases_of_rest(const SwitchingScene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot) {
  return FittingPhases<>(scene).of_rest(t, q, qdot);
}

template <class>
bool revise_phases(const SwitchingScene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, Eigen::VectorXd& z) {
  return FittingPhases<>(scene).revise(t, q, qdot, z);
}

template <class>
bool close_nearest(const SwitchingScene& scene, double t, const Eigen::VectorXd& q, Eigen::VectorXd& z) {
  return FittingPhases<>(scene).close_nearest(t, q, z);
}

}  // namespace qdot::detail
