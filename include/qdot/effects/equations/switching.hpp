#pragma once
// SPDX-License-Identifier: MIT
//
// Which constraints are active: the phases of contacts and dry friction, and how they change.
//
// Between events the phases are fixed and the equations smooth. Each effect has a guard, a function that is
// ≥ 0 as long as its phase lasts:
//
//     contact apart    φ            closed    λ
//     friction slides  s v          sticks    F_s² − λ²
//
// When one falls through zero (the driver finds the moment) new phases are chosen in three steps.
//
//   1. Velocities. Contacts at φ = 0 that approach take their blow (impact.hpp), other constraints included.
//   2. Candidates. A contact at φ = 0 without velocity may be closed, friction at v = 0 may stick; all others have no
//      choice, nor has friction whose v the lasting constraints alone decide (a slider at its dead centre slides through).
//      A contact whose next hop would not rise above what the method can tell from zero has no velocity.
//   3. Accelerations. Among the candidates those phases are right in which no closed contact pulls (λ ≥ 0), no open
//      one is penetrated (φ̈ ≥ 0), no sticking friction is overcharged (|λ| ≤ F_s), and none slides against its
//      own direction. They are found by changing the first that is wrong, again and again: Murty's pivoting, which
//      arrives for frictionless contacts with independent rows. If it does not, no motion is made up: ConstraintError.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/effects/contact.hpp"
#include "qdot/effects/dry_friction.hpp"
#include "qdot/effects/projection.hpp"

namespace qdot {

namespace detail {

/// The switching effects of a scene.
template <class Sc>
class Switching {
  static constexpr int n = Sc::dof_at_compile_time;
  static constexpr int m = Sc::constraints_at_compile_time;
  static_assert(m != Dynamic, "qdot: beside contacts and dry friction every constraint must have a number of rows known at compile time");
  using Q = Vector<double, n>;
  using Z = EffectStates<Sc>;
  using Rows = Vector<double, m>;

  static constexpr double apart = 0.0, closed = 1.0, sticks = 0.0, undecided = 2.0;
  static constexpr double relative = 1e-9;  // to which forces and accelerations are told from zero

 public:
  explicit Switching(const Sc& scene) : scene_(scene) {}

  static Eigen::Index count() {
    Eigen::Index k = 0;
    visit_types([&]<class E>(Eigen::Index, Eigen::Index) { (void)sizeof(E), ++k; });
    return k;
  }

  // out ← the guards.
  void guards(double t, const Q& q, const Q& qdot, const Z& z, Eigen::Ref<Eigen::VectorXd> out) const {
    bool active = false;
    visit([&](Eigen::Index, const auto& e, Eigen::Index zi, Eigen::Index) { active = active || e.is_active(z[zi]); });
    Rows lambda = Rows::Zero();
    if (active) lambda = constrained_acceleration(scene_, q, qdot, t, z).lambda;
    visit([&](Eigen::Index k, const auto& e, Eigen::Index zi, Eigen::Index row) {
      if constexpr (is_contact<decltype(e)>) {
        out[k] = e.is_active(z[zi]) ? lambda[row] : e.phi(q, t);
      } else if (e.is_active(z[zi])) {
        const double F_s = e.sticking_limit(q, qdot, t);
        out[k] = F_s * F_s - lambda[row] * lambda[row];
      } else {
        out[k] = z[zi] * e.velocity_constraint(q, qdot, t);
      }
    });
  }

  // out ← how large each guard may be and still be zero, for tolerances of y.
  void bands(double t, const Q& q, const Q& qdot, const Z& z, const Eigen::VectorXd& tolerance, Eigen::Ref<Eigen::VectorXd> out) const {
    const auto J = constraint_jacobian(scene_, q, qdot, t, everything(z));
    const Q f = rhs(scene_, q, qdot, t, z);
    visit([&](Eigen::Index k, const auto& e, Eigen::Index zi, Eigen::Index row) {
      if constexpr (is_contact<decltype(e)>) {
        out[k] = e.is_active(z[zi]) ? force_scale(J, f, row) * relative : weighted(J, row, tolerance.head(q.size()));
      } else {
        const double F_s = e.sticking_limit(q, qdot, t);
        out[k] = e.is_active(z[zi]) ? relative * F_s * F_s : weighted(J, row, tolerance.segment(q.size(), q.size()));
      }
    });
  }

  // The name of guard k if the run ends where it falls through zero, otherwise nothing.
  std::string ending(Eigen::Index wanted) const {
    std::string name;
    visit([&](Eigen::Index k, const auto& e, Eigen::Index, Eigen::Index) {
      if constexpr (is_contact<decltype(e)>)
        if (k == wanted && e.ends_run) name = e.name;
    });
    return name;
  }

  // Chooses velocities and phases as they follow from a state and the guards that fired; names what happened.
  std::vector<std::string> settle(double t, Q& q, Q& qdot, Z& z, const std::vector<bool>& fired, const Eigen::VectorXd& tolerance) const {
    std::vector<std::string> names;
    const Z before = z;
    std::vector<One> all(static_cast<std::size_t>(count()));
    look(t, q, qdot, z, fired, tolerance, all);
    strike(t, q, qdot, all, names);
    come_to_rest(t, q, qdot, z, all);
    propose(t, q, qdot, before, z, all);
    release(t, q, qdot, before, z, all);
    correct(t, q, qdot, z, all);
    if (!is_free(scene_, z)) project(scene_, q, qdot, t, default_rank_cutoff, z);
    visit([&](Eigen::Index, const auto& e, Eigen::Index zi, Eigen::Index) {
      if (before[zi] == undecided || before[zi] == z[zi]) return;
      if constexpr (is_contact<decltype(e)>) {
        if (before[zi] == closed) names.push_back(e.events.opens);
        if (z[zi] == closed) names.push_back(e.events.rests);
      } else {
        names.push_back(e.name + (z[zi] == sticks ? " sticks" : before[zi] == sticks ? " slips" : " turns"));
      }
    });
    return names;
  }

 protected:
  // What is known of one effect while phases are chosen.
  struct One {
    bool contact = false, fired = false, touches = false, candidate = false;
    double u = 0.0;       // φ̇ or v
    double still = 0.0;   // the size of velocities that count as none
    double lowest = 0.0;  // the height of hops that count as none
    double lambda = 0.0;  // as it was before
  };

  template <class E>
  static constexpr bool is_contact = UnilateralEffect<std::remove_cvref_t<E>, n>;

  // visit(k, effect, index in z, row).
  template <class Visit>
  void visit(Visit&& visitor) const {
    Eigen::Index k = 0, zi = 0, row = 0;
    for_each(scene_.effects(), [&](const auto& e) {
      using E = std::remove_cvref_t<decltype(e)>;
      if constexpr (SwitchingEffect<E, n>) visitor(k++, e, zi, row);
      zi += states_of<E>();
      row += constraint_rows_of<E, n>();
    });
  }

  template <class Visit>
  static void visit_types(Visit&& visitor) {
    using Effects = std::remove_cvref_t<decltype(std::declval<const Sc&>().effects())>;
    [&]<class... E>(const std::tuple<E...>*) {
      ([&] { if constexpr (SwitchingEffect<E, n>) visitor.template operator()<E>(0, 0); }(), ...);
    }(static_cast<const Effects*>(nullptr));
  }

  // z with all switching constraints active, or none.
  Z everything(Z z) const {
    visit([&](Eigen::Index, const auto& e, Eigen::Index zi, Eigen::Index) { z[zi] = is_contact<decltype(e)> ? closed : sticks; });
    return z;
  }
  Z nothing(Z z) const {
    visit([&](Eigen::Index, const auto&, Eigen::Index zi, Eigen::Index) { z[zi] = undecided; });
    return z;
  }

  template <class J, class Weights>
  static double weighted(const J& jacobian, Eigen::Index row, const Weights& weights) {
    return jacobian.row(row).cwiseAbs().dot(weights.transpose());
  }

  // The multiplier that would balance the applied forces along a row.
  template <class J>
  static double force_scale(const J& jacobian, const Q& f, Eigen::Index row) {
    const double square = jacobian.row(row).squaredNorm();
    return square > 0 ? weighted(jacobian, row, f.cwiseAbs()) / square : 0.0;
  }

  void look(double t, const Q& q, const Q& qdot, const Z& z, const std::vector<bool>& fired, const Eigen::VectorXd& tolerance,
            std::vector<One>& all) const {
    const auto J = constraint_jacobian(scene_, q, qdot, t, everything(z));
    const Rows phi = constraint_residual(scene_, q, t, everything(z));
    const Rows u = constraint_velocity(scene_, q, qdot, t, everything(z));
    Rows lambda = Rows::Zero();
    bool gives_way = false;
    visit([&](Eigen::Index k, const auto& e, Eigen::Index zi, Eigen::Index) {
      gives_way = gives_way || (fired[static_cast<std::size_t>(k)] && e.is_active(z[zi]));
    });
    if (gives_way) lambda = constrained_acceleration(scene_, q, qdot, t, z).lambda;
    visit([&](Eigen::Index k, const auto& e, Eigen::Index zi, Eigen::Index row) {
      One& one = all[static_cast<std::size_t>(k)];
      one.contact = is_contact<decltype(e)>;
      one.fired = fired[static_cast<std::size_t>(k)];
      one.u = u[row];
      one.still = 10 * weighted(J, row, tolerance.segment(q.size(), q.size()));
      one.lambda = lambda[row];
      if (!one.contact) return;
      const double resolved = weighted(J, row, tolerance.head(q.size()));
      const double rounding = (z[zi] == undecided ? relative : 16 * std::numeric_limits<double>::epsilon()) * weighted(J, row, q.cwiseAbs());
      one.lowest = 100 * resolved;
      one.touches = e.is_active(z[zi]) || one.fired || phi[row] <= 10 * resolved + rounding;
      if (!one.fired && !e.is_active(z[zi]) && phi[row] < -(100 * resolved + rounding))
        throw ConstraintError(e.name, t, -phi[row],
                              "the gap of a contact must not be negative, but at t = " + std::to_string(t) + " that of '" + e.name +
                                  "' is " + std::to_string(phi[row]) + "; start with the contact open or just closed");
    });
  }

  // The blows on all contacts that approach.
  void strike(double t, const Q& q, Q& qdot, std::vector<One>& all, std::vector<std::string>& names) const {
    if (std::none_of(all.begin(), all.end(), [](const One& one) { return one.touches && one.u < -one.still; })) return;
    const Z z = scene_.initial_states();
    const auto J = constraint_jacobian(scene_, q, qdot, t, everything(z));
    const ConstrainedFactors<n, m> factors(mass_matrix(scene_, q, qdot, t), constraint_jacobian(scene_, q, qdot, t, nothing(z)),
                                           default_rank_cutoff);
    std::vector<Eigen::Index> rows, effects;
    std::vector<ImpactLaw> laws;
    visit([&](Eigen::Index k, const auto& e, Eigen::Index, Eigen::Index row) {
      if constexpr (is_contact<decltype(e)>) {
        if (!all[static_cast<std::size_t>(k)].touches) return;
        rows.push_back(row);
        effects.push_back(k);
        laws.push_back(e.law);
      }
    });
    const auto size = static_cast<Eigen::Index>(rows.size());
    Eigen::MatrixXd W(q.size(), size), A(size, size);
    Eigen::VectorXd u(size), still(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      const Q direction = J.row(rows[static_cast<std::size_t>(i)]).transpose();
      const Q change = factors.solution(direction, Rows::Zero(), t, SceneNames<Sc>{scene_}).qddot;
      for (Eigen::Index k = 0; k < q.size(); ++k) W(k, i) = change[k];
      u[i] = all[static_cast<std::size_t>(effects[static_cast<std::size_t>(i)])].u;
      still[i] = all[static_cast<std::size_t>(effects[static_cast<std::size_t>(i)])].still;
    }
    for (Eigen::Index i = 0; i < size; ++i)
      for (Eigen::Index j = 0; j < size; ++j) A(i, j) = J.row(rows[static_cast<std::size_t>(i)]).dot(W.col(j));
    const Eigen::VectorXd impulse = impulses(A, u, laws, still);
    qdot += W * impulse;
    const Rows after = constraint_velocity(scene_, q, qdot, t, everything(z));
    visit([&](Eigen::Index k, const auto& e, Eigen::Index, Eigen::Index row) {
      One& one = all[static_cast<std::size_t>(k)];
      one.u = after[row];
      if constexpr (is_contact<decltype(e)>) {
        const auto found = std::find(effects.begin(), effects.end(), k);
        if (found == effects.end() || !(impulse[found - effects.begin()] > 0)) return;
        names.push_back(e.events.hits);
      }
    });
  }

  // Contacts whose next hop is too low to be told from none have no velocity.
  void come_to_rest(double t, const Q& q, const Q& qdot, const Z& z, std::vector<One>& all) const {
    if (std::none_of(all.begin(), all.end(), [](const One& one) { return one.touches && one.u > one.still; })) return;
    Z trial = nothing(z);
    visit([&](Eigen::Index k, const auto& e, Eigen::Index zi, Eigen::Index) {
      const One& one = all[static_cast<std::size_t>(k)];
      if (one.contact && e.is_active(z[zi]) && one.u <= one.still) trial[zi] = closed;
      if (!one.contact && std::abs(one.u) > one.still) trial[zi] = one.u > 0 ? 1.0 : -1.0;
    });
    const Rows rate = constraint_acceleration(scene_, q, qdot, Q(acceleration(scene_, q, qdot, t, trial)), t, everything(z));
    visit([&](Eigen::Index k, const auto&, Eigen::Index, Eigen::Index row) {
      One& one = all[static_cast<std::size_t>(k)];
      if (!one.touches || one.u <= one.still || rate[row] >= 0) return;
      const double height = one.u * one.u / (-2 * rate[row]), flight = 2 * one.u / -rate[row];
      if (height < one.lowest || flight < 1e3 * std::numeric_limits<double>::epsilon() * std::abs(t)) one.u = 0.0;
    });
  }

  // First guess of the phases; candidates may change it.
  void propose(double, const Q&, const Q&, const Z& before, Z& z, std::vector<One>& all) const {
    visit([&](Eigen::Index k, const auto& e, Eigen::Index zi, Eigen::Index) {
      One& one = all[static_cast<std::size_t>(k)];
      const bool was_active = e.is_active(before[zi]);
      one.candidate = std::abs(one.u) <= one.still && (one.touches || !one.contact);
      if (one.contact) {
        z[zi] = one.candidate && was_active && !one.fired ? closed : apart;
      } else if (!one.candidate) {
        z[zi] = one.u > 0 ? 1.0 : -1.0;
      } else if (was_active) {
        z[zi] = !one.fired ? sticks : one.lambda > 0 ? -1.0 : 1.0;
      } else {
        z[zi] = one.fired || before[zi] == undecided ? sticks : before[zi];
      }
    });
  }

  // Friction cannot stick where the lasting constraints alone decide its velocity, as those of a slider-crank do at its dead
  // centre: no friction, however strong, could hold it there. It slides on to where they take it.
  void release(double t, const Q& q, const Q& qdot, const Z& before, Z& z, std::vector<One>& all) const {
    if constexpr (Sc::has_lasting_constraints) {
      if (std::none_of(all.begin(), all.end(), [](const One& one) { return one.candidate && !one.contact; })) return;
      const auto M = mass_matrix(scene_, q, qdot, t);
      const auto J = constraint_jacobian(scene_, q, qdot, t, everything(z));
      const auto lasting = constraint_jacobian(scene_, q, qdot, t, nothing(z));
      const Eigen::Index rank = ConstrainedFactors<n, m>(M, lasting, default_rank_cutoff).rank();
      if (rank == m) return;  // not judged, since M alone is singular
      visit([&](Eigen::Index k, const auto&, Eigen::Index zi, Eigen::Index row) {
        One& one = all[static_cast<std::size_t>(k)];
        if (one.contact || !one.candidate) return;
        auto with = lasting;
        with.row(row) = J.row(row);
        if (ConstrainedFactors<n, m>(M, with, default_rank_cutoff).rank() != rank) return;
        z[zi] = undecided;
        one.candidate = false;
        const Q a = acceleration(scene_, q, qdot, t, z);
        const double rate = constraint_acceleration(scene_, q, qdot, a, t, everything(z))[row];
        const double least = relative * (weighted(J, row, a.cwiseAbs()) + std::abs(rate - J.row(row).dot(a)));
        const double as_before = before[zi] == 1.0 || before[zi] == -1.0 ? (one.fired ? -before[zi] : before[zi]) : 1.0;
        z[zi] = std::abs(rate) <= least ? as_before : rate > 0 ? 1.0 : -1.0;
      });
    }
  }

  // Changes the first wrong phase until none is.
  void correct(double t, const Q& q, const Q& qdot, Z& z, const std::vector<One>& all) const {
    const Z every = everything(z);
    const auto J = constraint_jacobian(scene_, q, qdot, t, every);
    for (int pivot = 0; pivot < 200; ++pivot) {
      Q a;
      Rows lambda = Rows::Zero();
      if (is_free(scene_, z)) {
        a = acceleration(scene_, q, qdot, t, z);
      } else {
        const auto solution = constrained_acceleration(scene_, q, qdot, t, z);
        a = solution.qddot;
        lambda = solution.lambda;
      }
      const Q f = rhs(scene_, q, qdot, t, z);
      const Rows rate = constraint_acceleration(scene_, q, qdot, a, t, every);
      bool wrong = false;
      visit([&](Eigen::Index k, const auto& e, Eigen::Index zi, Eigen::Index row) {
        if (wrong || !all[static_cast<std::size_t>(k)].candidate) return;
        const double along = weighted(J, row, a.cwiseAbs());
        const double least = relative * (along + std::abs(rate[row] - J.row(row).dot(a)));
        if constexpr (is_contact<decltype(e)>) {
          if (z[zi] == closed ? lambda[row] < -relative * force_scale(J, f, row) : rate[row] < -least) {
            z[zi] = z[zi] == closed ? apart : closed;
            wrong = true;
          }
        } else if (z[zi] == sticks) {
          if (std::abs(lambda[row]) > (1 + relative) * e.sticking_limit(q, qdot, t)) {
            z[zi] = lambda[row] > 0 ? -1.0 : 1.0;
            wrong = true;
          }
        } else if (z[zi] * rate[row] < -least) {
          z[zi] = sticks;
          wrong = true;
        }
      });
      if (!wrong) return;
    }
    throw ConstraintError("contacts and friction", t, 0.0,
                          "the phases of contacts and friction must fit together, but at t = " + std::to_string(t) +
                              " no choice of closed and open, sticking and sliding does; look for contacts that depend on each other, "
                              "or for a sliding friction larger than the sticking one");
  }

  const Sc& scene_;
};

}  // namespace detail

}  // namespace qdot
