#pragma once
// SPDX-License-Identifier: MIT
//
// Φ over a long time, made in pieces: what lies between two looks at the deviations, y and Φ = ∂x(t_end)/∂x(t) from a start that is the end of the piece
// before. Behind this interface exponents and alignments are compiled once, not for each system.
//
// x is what can deviate: q, q̇ and the own states of effects but phases, which are whole numbers, and inputs, which are held. A contact that closes and a
// friction that sticks take deviations away for good: their directions have no exponent, and that is said.

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/QR>

#include "qdot/analysis/sensitivity.hpp"
#include "qdot/error.hpp"

namespace qdot::detail {

// Directions that part further than this within one piece have lost half of their digits.
inline constexpr double parts_too_far = 1e8;

struct PieceOfFlow : RunEnd {
  Eigen::MatrixXd Phi{};     // square
  bool may_end_here = true;  // whether a run can begin where it ends: not in the moment of a blow, or where phases are about to change
};

// From y at t to t_end.
using FlowInPieces = std::function<PieceOfFlow(double t, const Eigen::VectorXd& y, double t_end)>;

// Whether phases and velocities are what they remain.
template <class Form>
bool may_begin(const Form& form, double t, const Eigen::VectorXd& y, const Options& options) {
  if constexpr (SwitchingSystem<Form>) {
    const Eigen::VectorXd tolerance = options.rtol * y.cwiseAbs() + each_atol(options, y.size());
    Eigen::VectorXd settled = y;
    form.switched(t, settled, std::vector<bool>(static_cast<std::size_t>(form.guard_count())), tolerance);
    return ((settled - y).array().abs() <= 1e-9 * y.array().abs() + 100 * tolerance.array()).all();
  }
  return (void)form, (void)t, (void)y, (void)options, true;
}

template <class System, class Method, class... Events>
FlowInPieces flow_in_pieces(System system, Method method, Options options, EventList<Events...> events = {}) {
  options.keep_trajectory = false;
  return [system = std::move(system), method = std::move(method), options = std::move(options),
          events = std::move(events)](double t, const Eigen::VectorXd& y, double until) {
    using Form = FormOf<System>;
    FixedModel<Form, EventList<Events...>> model{first_order_form(system), events};
    const std::vector<Eigen::Index> all = own_states_of(model.form, true);
    auto s = sensitivities_of(model, FirstOrderState{t, y}, events, until, method, options, WithRespectTo{}, FixedStart{}, 1, true);
    PieceOfFlow piece{static_cast<RunEnd&&>(s), std::move(s.Phi)};
    if (piece.outcome == Outcome::completed) piece.may_end_here = may_begin(model.form, piece.t, piece.y, options);
    if (piece.Phi.rows() == piece.Phi.cols() && all.empty()) return piece;
    const Eigen::Index known = piece.Phi.cols() - static_cast<Eigen::Index>(all.size());  // of q and q̇
    std::vector<Eigen::Index> rows, columns;
    for (Eigen::Index i = 0; i < known; ++i) rows.push_back(i);
    for (const Eigen::Index place : own_states_of(model.form, false)) rows.push_back(place);
    for (const Eigen::Index place : rows) {
      const auto found = std::find(all.begin(), all.end(), place);
      columns.push_back(found == all.end() ? place : known + (found - all.begin()));
    }
    piece.Phi = Eigen::MatrixXd(piece.Phi(rows, columns));
    return piece;
  };
}

// Shortens a piece that cannot end where it does; false, with outcome and message of the end, where it would be too short.
template <class = void>  // compiled only where it is called
bool can_be_shortened(RunEnd& end, double t, double& interval, double smallest) {
  interval *= 0.83;
  if (interval > smallest) return true;
  end.outcome = Outcome::not_differentiable;
  end.message = sentence({name(end.outcome), ": contacts or friction change at t = ", t, 
                          " and at all moments in front of it that were tried, so that no deviation can be followed from there; end the run earlier"});
  return false;
}

// Gram's and Schmidt's columns in place of those given, whose order they keep; R_ii of each.
template <class MatrixXd>
Eigen::VectorXd lengths_of_orthonormalized(MatrixXd& A) {
  Eigen::VectorXd length = Eigen::VectorXd::Zero(A.cols());
  for (Eigen::Index i = 0; i < A.cols(); ++i) {
    for (int twice = 0; twice < 2; ++twice)  // the second time for what rounding left
      for (Eigen::Index j = 0; j < i; ++j) A.col(i) -= A.col(j).dot(A.col(i)) * A.col(j);
    length[i] = A.col(i).stableNorm();  // whose squares may be no numbers
    if (length[i] > 0.0) A.col(i) /= length[i];
  }
  return length;
}

// `count` orthonormal deviations that the motion allows, all of them for count < 0: along the constraints, if there are any. Their directions are
// no eigenvectors: a deviation that begins along one never leaves it.
template <class MatrixXd>
MatrixXd first_deviations(const FlowInPieces& flow, double t0, const Eigen::VectorXd& y0, Eigen::Index count) {
  const PieceOfFlow first = flow(t0, y0, t0);
  Eigen::ColPivHouseholderQR<MatrixXd> basis(first.Phi);
  basis.setThreshold(1e-9);
  const Eigen::Index most = basis.rank();
  if (most == 0)
    throw_invalid_value({"something must be free to deviate, but the constraints and phases at t = ", {t0, 6},
                         " determine all of the motion; begin where it is free"});
  if (count < 0) count = most;
  if (count < 1 || count > most)
    throw_invalid_value({"there must be from 1 to ", most, " directions, one for each deviation that the motion allows, but ", count, " were asked for"});
  MatrixXd Q(first.Phi.rows(), count);
  for (Eigen::Index j = 0; j < count; ++j)
    for (Eigen::Index i = 0; i < Q.rows(); ++i) Q(i, j) = std::cos(1.0 + 2.3 * static_cast<double>(i * i) + 1.7 * static_cast<double>((i + 1) * j));
  Q = MatrixXd(first.Phi * Q);
  lengths_of_orthonormalized(Q);
  return Q;
}

}  // namespace qdot::detail
