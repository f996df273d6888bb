#pragma once
// SPDX-License-Identifier: MIT
//
// The action of a path
// ====================
//
//     S[q] = ∫ L(q(t), q̇(t), t) dt        from t_a to t_b
//
// is a number for any path q(t), whether it is a motion or not. Hamilton's principle: of all paths with the same ends,
// motions are those at which S does not change to first order. For a small change ε η of the path, with η = 0 at both ends,
//
//     S[q + ε η] = S[q] + ½ ε² δ²S + …        if q is a motion.
//
// The path is called with t + ε, and the factor of ε in the result is its velocity: q̇(t) need not be given.
//     const auto straight = [](const auto& t) { return vector(4.0 * t + 7.0, 3.0 * t + 5.0, 2.0 * t + 1.0); };
//     action(free_particle, straight, 0.0, 10.0).S         435 for m = 3 (Sussman, Wisdom, Structure and Interpretation of
//                                                          Classical Mechanics, section 1.4)

#include <cmath>
#include <functional>
#include <type_traits>

#include <Eigen/Core>

#include "qdot/ad/dual.hpp"
#include "qdot/ad/dual_eigen.hpp"
#include "qdot/ad/dual_math.hpp"
#include "qdot/ad/forward/functor_result.hpp"
#include "qdot/analysis/paths/quadrature.hpp"
#include "qdot/effects/scene.hpp"
#include "qdot/error.hpp"
#include "qdot/mechanics/energy.hpp"

namespace qdot {

/// The action of a path, and to what it is known.
struct Action {
  double S = 0.0;       ///< ∫ L dt
  double error = 0.0;   ///< S is known to that, as two formulas agree
  int evaluations = 0;  ///< of L
};

/// How well an action is to be known.
struct ActionOptions {
  double tolerance = 1e-12;       ///< of S, as part of ∫|L| dt
  int most_evaluations = 30'000;  ///< of L
};

namespace detail {

struct SlopeAlongPath {};  // the tag of the perturbation of t

// q and q̇ of a path at t.
template <int n, class Path>
State<n> state_on_path(const Path& path, double t, Eigen::Index dof) {
  using D = Dual<double, 1, SlopeAlongPath>;
  static_assert(std::is_invocable_v<const Path&, const D&>, "qdot: a path must be callable with every scalar: take `const auto& t`");
  const auto at = result_of(path, D::variable(t, 0));
  static_assert(std::is_same_v<typename std::remove_cvref_t<decltype(at)>::Scalar, D>, "qdot: a path must return a vector of the scalar of t");
  if (at.size() != dof) throw DimensionError("a path", static_cast<long>(dof), static_cast<long>(at.size()), "let it return one entry for each coordinate");
  State<n> state{t, Vector<double, n>(dof), Vector<double, n>(dof)};
  for (Eigen::Index i = 0; i < dof; ++i) {
    state.q[i] = at[i].value;
    state.qdot[i] = at[i].tangent[0];
  }
  return state;
}

[[gnu::cold, gnu::noinline]] inline void require_duration(const char* who, double t_a, double t_b) {
  if (!(std::isfinite(t_a) && std::isfinite(t_b) && t_a < t_b))
    throw_invalid_value({who, ": the end must be later than the start, but they are t = ", t_a, " and ", t_b, "; give them in order"});
}

template <class = void>  // compiled only where it is called
Action action_of(const std::function<double(double)>& L, double t_a, double t_b, const ActionOptions& options) {
  require_duration("action", t_a, t_b);
  const Integral S = integral_of(L, t_a, t_b, options.tolerance, options.most_evaluations);
  if (!std::isfinite(S.value))
    throw_invalid_value({"action: L must be finite all along the path, but is not between t = ", {S.worst_from, 8}, " and ", {S.worst_to, 8},
                         "; ask where the path leads"});
  return {S.value, S.error, S.evaluations};
}

}  // namespace detail

/// ∫ L dt along any path of a system or scene; forces and constraints have no part in L.
///
/// One evaluation of T and V for each of 15, 45, 75 … moments, as smooth as the path is; a kink takes more than a thousand.
///
/// @param path      t ↦ q, generic: it is called with duals
/// @param t_a, t_b  where it begins and ends, t_a < t_b
/// @return          S and its error; larger than the tolerance where most_evaluations were not enough
/// @throws          InvalidValue when t_b is not later, or where L is not finite; DimensionError for a path of another size
template <class Model, class Path>
Action action(const Model& model, const Path& path, double t_a, double t_b, const ActionOptions& options = {}) {
  const auto& system = model.system();
  return detail::action_of(
      [&](double t) {
        const auto state = detail::state_on_path<Model::dof_at_compile_time>(path, t, system.dof());
        return lagrangian(system, state.q, state.qdot, t);
      },
      t_a, t_b, options);
}

}  // namespace qdot
