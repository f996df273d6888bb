#pragma once
// SPDX-License-Identifier: MIT
//
// Linearization: small motions beside a state
// ===========================================
//
//     ẋ = A x + B u ,    y = C x + D u        A = P F W ,   F = ∂f/∂y, exact
//
// x holds deviations of *minimal coordinates* from a state, of their velocities, and of the effects' own states; u those of
// the inputs (effects/input.hpp). On constraints only tangent vectors δy = W x are possible:
//
//     J δq = 0  (holonomic rows) ,      J δq̇ + ∂(J q̇)/∂q δq = 0  (all rows).
//
// x are coordinates that are free to choose, which P picks from y, so no multiplier has to be differentiated. With n
// coordinates, h independent holonomic and m − h velocity constraints, x has n − h positions and n − m velocities. Closed
// contacts and sticking friction are constraints. At the edge of a phase, and on a kink of T, V or a force, the state is
// refused. It need not rest: `drift` is P f. Modes and regulators ask that it is zero but for cyclic coordinates that turn.

#include <cmath>
#include <cstddef>
#include <string>
#include <type_traits>
#include <vector>

#include "qdot/ad/derivatives.hpp"
#include "qdot/analysis/linear/flow.hpp"
#include "qdot/analysis/linear/tangent_space.hpp"
#include "qdot/analysis/steady_state.hpp"
#include "qdot/effects/input.hpp"
#include "qdot/effects/scene_at_state.hpp"

namespace qdot {

/// ẋ = drift + A x + B u, y = C x + D u in minimal coordinates, at a state.
struct Linearization {
  Eigen::MatrixXd A;                     ///< N×N for N = positions + velocities + own states
  Eigen::MatrixXd B;                     ///< N×inputs
  Eigen::MatrixXd C;                     ///< outputs×N; the identity until observed() says otherwise
  Eigen::MatrixXd D;                     ///< outputs×inputs
  Eigen::VectorXd drift;                 ///< ẋ at the state itself, N
  Eigen::MatrixXd W;                     ///< 2n×N: how q and q̇ deviate, δ(q, q̇) = W x
  Eigen::VectorXd q, qdot, u;            ///< where it was taken
  Eigen::Index positions = 0;            ///< the first entries of x
  Eigen::Index velocities = 0;           ///< those behind them
  std::vector<std::string> coordinates;  ///< names of q, n
  std::vector<std::string> states;       ///< names of x, N
  std::vector<std::string> inputs;       ///< names of u
  bool autonomous = true;  ///< whether A is the same at other times; only then do its exponents say something
};

namespace detail {

struct SlopeOfOutput {};  // the tag of perturbations of what an output reads

template <class F>
void require_on_constraints(const F& flow, double t, const Eigen::VectorXd& y, const ConstraintsAt& rows) {
  const Eigen::Index n = flow.dof();
  for (Eigen::Index i = 0; i < rows.phi.size(); ++i) {
    const double length = rows.slopes.row(i).tail(n).norm(), place = y.head(n).cwiseAbs().maxCoeff(), speed = y.segment(n, n).cwiseAbs().maxCoeff();
    for (const bool position : {true, false}) {
      const double off = position ? rows.phi[i] : rows.velocity[i], size = position ? place : speed + rows.slopes.row(i).head(n).norm() * place / length;
      if (std::abs(off) <= 1e-8 * (length > 0.0 ? length : 1.0) * (size > 0.0 ? size : 1.0)) continue;
      throw_invalid_value({"linearization: the state must satisfy its constraints, but ",
                           position ? "" : "the velocity of ",
                           "'",
                           flow.constraint_names()[static_cast<std::size_t>(i)],
                           "' is off by ",
                           {off, 6},
                           " at t = ",
                           {t, 6},
                           "; take it from consistent_state() or equilibrium_near()"});
    }
  }
}

// The linearization at y = [q; q̇; z].
template <class F>
Linearization linearized(const F& flow, double t, const Eigen::VectorXd& y) {
  using Matrix = Eigen::MatrixXd;
  const Eigen::Index n = flow.dof(), others = flow.size() - 2 * n;
  for (Eigen::Index i = 0; i < y.size(); ++i)
    if (!std::isfinite(y[i]))
      throw_invalid_value(
          {"linearization: the state must be finite, but ", flow.name(i), " is not; give every entry a number"});
  const ConstraintsAt rows = flow.constraints(t, y);
  require_on_constraints(flow, t, y, rows);
  flow.require_slopes("linearization", t, y);
  const Eigen::Index m = rows.phi.size();
  Matrix J = Matrix::Zero(m, n), holonomic = J, of_q = J;
  for (Eigen::Index i = 0; i < m; ++i) {
    J.row(i) = rows.slopes.row(i).tail(n);
    of_q.row(i) = rows.slopes.row(i).head(n);
    if (rows.holonomic[static_cast<std::size_t>(i)]) holonomic.row(i) = J.row(i);
  }
  const TangentSpace places(holonomic), speeds(J);
  const Eigen::Index a = n - places.rank(), b = n - speeds.rank();

  Linearization result;
  result.positions = a;
  result.velocities = b;
  std::vector<Eigen::Index> picked = places.free();
  for (const Eigen::Index i : speeds.free()) picked.push_back(n + i);
  const std::vector<Eigen::Index> inputs = flow.inputs();
  std::vector<bool> is_held(static_cast<std::size_t>(others), false);
  for (const Eigen::Index i : inputs) is_held[static_cast<std::size_t>(i - 2 * n)] = true;
  for (const Eigen::Index i : flow.phases()) is_held[static_cast<std::size_t>(i - 2 * n)] = true;  // held as well
  for (Eigen::Index i = 0; i < others; ++i)
    if (!is_held[static_cast<std::size_t>(i)]) picked.push_back(2 * n + i);

  const auto N = static_cast<Eigen::Index>(picked.size());
  Matrix W = Matrix::Zero(2 * n + others, N);
  W.topLeftCorner(n, a) = places.basis();
  if (m > 0) W.block(n, 0, n, a) = speeds.particular(Matrix(-of_q * places.basis()));
  W.block(n, a, n, b) = speeds.basis();
  for (Eigen::Index k = a + b; k < N; ++k) W(picked[static_cast<std::size_t>(k)], k) = 1.0;

  const Matrix slopes = flow.slopes(t, y);
  for (const double later : {1.0, 3.7}) {
    const auto there = elsewhere_in_time(t, later, [&](double at) { return flow.slopes(at, y); });
    result.autonomous = result.autonomous && (!there || (*there - slopes).norm() <= 1e-9 * slopes.norm());
  }
  result.A = (slopes * W)(picked, Eigen::indexing::all);
  result.B = slopes(picked, inputs);
  result.drift = flow.rates(t, y)(picked);
  result.u = y(inputs);
  for (const Eigen::Index row : picked) result.states.push_back(flow.name(row));
  result.C = Matrix::Identity(N, N);
  result.D = Matrix::Zero(N, result.B.cols());
  result.W = W.topRows(2 * n);
  result.q = y.head(n);
  result.qdot = y.segment(n, n);
  for (Eigen::Index i = 0; i < n; ++i) result.coordinates.push_back(flow.name(i));
  result.inputs = flow.input_names();
  return result;
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template Linearization linearized<Flow>(const Flow&, double, const Eigen::VectorXd&);
#endif

template <class Sc>
Linearization linearization_of(const Sc& scene, double t, const Eigen::Ref<const Eigen::VectorXd>& q,
                               const Eigen::Ref<const Eigen::VectorXd>& qdot, const EffectStates<Sc>& z) {
  require_sizes(scene, q, qdot);
  if constexpr (Sc::has_phases) PhasesAtState<Sc>(scene).require_within(t, Coordinates<Sc>(q), Coordinates<Sc>(qdot), z);
  const FlowOf<Sc> flow(scene);
  Eigen::VectorXd y(flow.size());
  y << q, qdot, z;
  return linearized(static_cast<const Flow&>(flow), t, y);
}

}  // namespace detail

/// The linearization of a scene at a state, with the effects' own states at their initial values, and contacts and friction in the phases that fit.
///
/// O(n³) beside one Jacobian of the equations of motion. The inputs are those in the scene and the ones given here.
///
/// @param state   on its constraints
/// @param inputs  from input()
/// @throws        InvalidValue when the state is not finite, not on its constraints, at the edge of a phase or on a kink; as acceleration() where M is
///     singular or constraints contradict each other
template <class Sys, class... Effects, class... Inputs>
Linearization linearization(const Scene<Sys, Effects...>& scene, const State<Sys::dof_at_compile_time>& state,
                            const Inputs&... inputs) {
  if constexpr (sizeof...(Inputs) > 0) {
    return linearization(qdot::scene(scene, inputs...), state);
  } else {
    return detail::linearization_of(scene, state.t, state.q, state.qdot, detail::states_at(scene, state));
  }
}

/// The linearization of a system.
template <class E, int n, Inertia inertia, class... Inputs>
Linearization linearization(const System<E, n, inertia>& system, const State<n>& state, const Inputs&... inputs) {
  return linearization(scene(system, inputs...), state);
}

/// The linearization at a steady state of the scene, from equilibrium_near() or steady_motion_near().
template <class Sys, class... Effects, class... Inputs>
Linearization linearization(const Scene<Sys, Effects...>& scene, const SteadyState<Scene<Sys, Effects...>>& found,
                            const Inputs&... inputs) {
  const auto whole = qdot::scene(scene, inputs...);
  auto z = whole.initial_states();
  for (Eigen::Index i = 0; i < found.z.size(); ++i) z[i] = found.z[i];
  return detail::linearization_of(whole, found.state.t, found.state.q, found.state.qdot, z);
}

/// The same linearization with other outputs: C = ∂g/∂(q, q̇) W and D = ∂g/∂u.
///
/// @param g  g(q, qdot) or g(q, qdot, u): one number, or a vector of them
template <class Output>
Linearization observed(Linearization linear, const Output& g) {
  const Eigen::Index n = linear.q.size(), inputs = linear.u.size();
  Eigen::VectorXd all(2 * n + inputs);
  all << linear.q, linear.qdot, linear.u;
  const Eigen::MatrixXd slopes = jacobian(
      detail::marked<detail::SlopeOfOutput>([&](const auto& x) {
        using S = typename std::remove_cvref_t<decltype(x)>::Scalar;
        const Vector<S, Dynamic> q = x.head(n), qdot = x.segment(n, n), u = x.tail(inputs);
        if constexpr (std::is_invocable_v<const Output&, decltype(q), decltype(q), decltype(q)>) {
          return detail::as_rows(g(q, qdot, u));
        } else {
          return detail::as_rows(g(q, qdot));
        }
      }),
      all);
  linear.C = slopes.leftCols(2 * n) * linear.W;
  linear.D = slopes.rightCols(inputs);
  return linear;
}

}  // namespace qdot
