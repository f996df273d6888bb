#pragma once
// SPDX-License-Identifier: MIT
//
// Second derivatives of a motion, ∂²y(t)/∂x∂x for x = (q₀, q̇₀, p), by power series.
//
//     const auto s = second_sensitivities(system, State<2>{0.0, q, qdot}, 3.0, Taylor{}, {.rtol = 1e-13, .atol = 1e-14});
//     s.second[i](a, b)     ∂²yᵢ/∂x_a∂x_b, x as in the columns of s.Phi
//
//     y(t; x + δ) = y + Φ δ + ½ δᵀ (∂²y/∂x∂x) δ + … ,       E[yᵢ] = yᵢ + ½ tr(secondᵢ · Cov x) .
//
// They are the curvature of a cost or a target, and the first term that a linear propagation of errors leaves out. Each
// pair a ≤ b has a column x_ab that starts at zero and fulfils the linear equations of Φ with a summand of x_a and x_b
// (analysis/variations/variation_series.hpp). Errors of steps are controlled for all columns alike; options.atol holds
// for x_ab per units of x_a and x_b. Through events second derivatives jump as the first do, differenced to some ten
// digits (second_saltation.hpp). Constraints, contacts, dry friction and families of problems are refused while
// compiling.

#include <Eigen/Core>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/analysis/sensitivity.hpp"
#include "qdot/analysis/taylor_sensitivity.hpp"
#include "qdot/error.hpp"

namespace qdot {

namespace detail {

// The second derivatives in a state [y; Φ; pairs].
template <class = void>  // compiled only where it is called
std::vector<Eigen::MatrixXd> second_derivatives_in(const Eigen::VectorXd& both, Eigen::Index size, Eigen::Index columns) {
  std::vector<Eigen::MatrixXd> second(static_cast<std::size_t>(size), Eigen::MatrixXd(columns, columns));
  Eigen::Index place = size * (1 + columns);
  for (Eigen::Index a = 0; a < columns; ++a)
    for (Eigen::Index b = a; b < columns; ++b)
      for (auto& of : second) of(a, b) = of(b, a) = both[place++];
  return second;
}

}  // namespace detail

/// A run with its first and second derivatives.
///
/// @tparam n  number of coordinates, or Dynamic
template <int n = Dynamic>
struct SecondSensitivities : Sensitivities<n> {
  std::vector<Eigen::MatrixXd> second;  ///< second[i](a, b) = ∂²yᵢ/∂x_a∂x_b at the fixed time t, for the columns a and b of Φ; symmetric

  /// Second derivatives as in `second`, at a time.
  ///
  /// @throws InvalidValue  when the time is not within the run, or no trajectory was kept
  std::vector<Eigen::MatrixXd> second_at(double time) const {
    return detail::second_derivatives_in(this->run.trajectory.y(time), this->y.size(), this->Phi.cols());
  }
};

namespace detail {

template <class Model, int n, class Method, class... Events>
auto second_sensitivities_of(Model model, const State<n>& start, double t_end, const Method& method, const Options& options, const EventList<Events...>& events,
                             const WithRespectTo& wanted) {
  static_assert(std::is_same_v<Method, Taylor>, "qdot: second derivatives of a motion are made by power series: pass Taylor{}");
  static_assert(changes_of<Model> == Changes::none,
                "qdot: second derivatives of a motion take no constraints, contacts or dry friction; difference sensitivities()");
  if (wanted.start_time)
    throw InvalidValue("second derivatives are by the start and by parameters, but the time of the start is asked for; leave start_time out");
  auto first = sensitivities_of(std::move(model), start, events, t_end, method, options, wanted, FixedStart{}, 2);
  std::vector<Eigen::MatrixXd> second = second_derivatives_in(first.run.y, first.y.size(), first.Phi.cols());
  return SecondSensitivities<Variations<Model>::n>{std::move(first), std::move(second)};
}

}  // namespace detail

/// The motion of a system or scene with its first and second derivatives with respect to its start.
///
/// One run of size 2n(1 + k + k(k + 1)/2) for k columns of Φ; on a double pendulum, k = 4, it takes the time of some thirty runs without derivatives.
///
/// @param system   a system, or a scene whose forces are formulas
/// @param start    State{t, q, qdot}
/// @param method   Taylor{}
/// @param events   events(…), whose actions may be called several times at one moment, and do not read parameters
/// @param wanted   which columns Φ has; no start_time
/// @return         as sensitivities(), and `second`
/// @throws         as sensitivities(); NotAnalytic where T, V or a force compares values or has a kink
template <class System, int n, class Method, class... Events>
  requires(!std::is_invocable_v<const System&, const State<n>&>)
auto second_sensitivities(const System& system, const State<n>& start, double t_end, const Method& method, const Options& options = {},
                          const EventList<Events...>& events = {}, const WithRespectTo& wanted = {}) {
  using Form = detail::FormOf<System>;
  return detail::second_sensitivities_of(detail::FixedModel<Form, EventList<Events...>>{first_order_form(system), events}, start, t_end,
                                         method, options, events,
                                         wanted);
}

/// The motion with its first and second derivatives with respect to its start and to parameters of T and V. Other arguments are
/// those above.
///
/// @param energies_of  p ↦ an object with members T and V, for a vector p of any scalar
/// @param p            parameters
/// @throws             as above; InvalidValue for parameters that are not finite
template <class EnergiesOf, class P, int n, class Method, class... Events>
  requires std::is_invocable_v<const EnergiesOf&, const P&>
auto second_sensitivities(const EnergiesOf& energies_of, const P& p, const State<n>& start, double t_end, const Method& method, const Options& options = {},
                          const EventList<Events...>& events = {}, const WithRespectTo& wanted = {}) {
  return detail::second_sensitivities_of(detail::energies_model<n>(energies_of, p, events), start, t_end, method, options, events, wanted);
}

/// Of a family of problems there are none.
template <class Family, class P, class... More>
  requires std::is_invocable_v<const Family&, const P&>
void second_sensitivities(const Family&, const P&, double, const More&...) {
  static_assert(sizeof(Family) == 0,
                "qdot: second derivatives are by the start and by parameters of T and V, energies_of(p) and a start, not of a family of problems; difference "
                "sensitivities()");
}

}  // namespace qdot
