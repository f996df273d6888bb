#pragma once
// SPDX-License-Identifier: MIT
//
// What a motion predicts of a measurement, and how that depends on parameters and start:
//
//     h(q(t_k), q̇(t_k), p) ,     dh = ∂h/∂y Φ dx + ∂h/∂p dp        a directional derivative of h for each column of Φ, by duals
//
// one run with its sensitivities, at the measurement's times. Behind Predict fits are compiled once, whatever moves and is measured.

#include <cstddef>
#include <functional>
#include <string>
#include <type_traits>

#include <Eigen/Core>

#include "qdot/ad/forward/functor_result.hpp"
#include "qdot/ad/dual.hpp"
#include "qdot/ad/dual_eigen.hpp"
#include "qdot/analysis/sensitivity.hpp"
#include "qdot/error.hpp"

namespace qdot::detail {

// Of one motion at its times.
struct Predicted {
  std::string trouble{};     // why there is none; empty where there is
  Eigen::MatrixXd values{};  // outputs × times
  Eigen::MatrixXd slopes{};  // outputs·times × columns: of the start, if they were asked for, then of the parameters
};

using Predict = std::function<Predicted(const Eigen::VectorXd& p, const Eigen::VectorXd& start, bool by_start)>;

// h(q), h(q, q̇) or h(q, q̇, p), a number or a vector of them, as a vector.
template <class Outputs, class X, class P>
auto outputs_at(const Outputs& h, const X& q, const X& qdot, const P& p) {
  using S = typename X::Scalar;
  const auto asked = [&] {
    if constexpr (detail::is_callable<const Outputs&, const X&>) return h(q);
    else if constexpr (detail::is_callable<const Outputs&, const X&, const X&>) return h(q, qdot);
    else return h(q, qdot, p);
  };
  using H = std::remove_cvref_t<decltype(asked())>;
  if constexpr (requires(H value) { value.size(); }) {
    return Vector<S, Eigen::Dynamic>(asked());
  } else {
    Vector<S, Eigen::Dynamic> one(1);
    one[0] = S(asked());
    return one;
  }
}

// Values and slopes of h where a run with its derivatives, [y; columns of Φ], was sampled.
template <int n, class Outputs>
Predicted measured(const Outputs& h, const Eigen::MatrixXd& samples, Eigen::Index dof, Eigen::Index state_size, Eigen::Index starts, const Eigen::VectorXd& p) {
  using D = Dual<double, 1, AlongColumn>;
  Predicted out;
  const Eigen::Index columns = samples.rows() / state_size - 1;
  Vector<D, Eigen::Dynamic> parameters = p.template cast<D>();
  for (Eigen::Index k = 0; k < samples.cols(); ++k) {
    const double* const y = samples.col(k).data();
    for (Eigen::Index j = 0; j < columns; ++j) {
      const double* const along = y + state_size * (j + 1);
      const Eigen::Map<const Vector<double, n>> at(y, dof), moving(y + dof, dof);
      const Vector<D, n> q = with_rates<D>(at, along), qdot = with_rates<D>(moving, along + dof);
      if (j >= starts) parameters[j - starts].tangent[0] = 1.0;
      const Vector<D, Eigen::Dynamic> value = outputs_at(h, q, qdot, parameters);
      if (j >= starts) parameters[j - starts].tangent[0] = 0.0;
      if (k == 0 && j == 0) {
        out.values.resize(value.size(), samples.cols());
        out.slopes.resize(value.size() * samples.cols(), columns);
      }
      for (Eigen::Index i = 0; i < value.size(); ++i) {
        out.values(i, k) = value[i].value;
        out.slopes(k * value.size() + i, j) = value[i].tangent[0];
      }
    }
  }
  return out;
}

// The prediction of one run, as sensitivities() gives it.
template <int n, class Outputs>
Predicted predicted(const Outputs& h, const Sensitivities<n>& s, std::size_t times, const Eigen::VectorXd& p) {
  if (s.run.samples.t.size() < times) return {s.message.empty() ? "the run ended before the last measurement" : s.message};
  return measured<n>(h, s.run.samples.y, s.run.trajectory.dof(), s.y.size(), s.start_columns, p);
}

}  // namespace qdot::detail
