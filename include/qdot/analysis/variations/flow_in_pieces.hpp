#pragma once
// SPDX-License-Identifier: MIT
//
// Φ over a long time, made in pieces: what lies between two looks at the deviations, y and Φ = ∂y(t_end)/∂y(t) from a start that is the end of the piece
// before. Behind this interface exponents and alignments are compiled once, not for each system.

#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include <Eigen/Core>
#include <Eigen/QR>

#include "qdot/analysis/sensitivity.hpp"
#include "qdot/error.hpp"

namespace qdot::detail {

struct PieceOfFlow : RunEnd {
  Eigen::MatrixXd Phi{};
};

// From y at t to t_end.
using FlowInPieces = std::function<PieceOfFlow(double t, const Eigen::VectorXd& y, double t_end)>;

template <class System, class Method, class... Events>
FlowInPieces flow_in_pieces(System system, Method method, Options options, EventList<Events...> events = {}) {
  options.keep_trajectory = false;
  return [system = std::move(system), method = std::move(method), options = std::move(options),
          events = std::move(events)](double t, const Eigen::VectorXd& y, double until) {
    auto s = sensitivities(system, FirstOrderState{t, y}, until, method, options, events);
    return PieceOfFlow{static_cast<RunEnd&&>(s), std::move(s.Phi)};
  };
}

// Gram's and Schmidt's columns in place of those given, whose order they keep; R_ii of each.
template <class MatrixXd>
Eigen::VectorXd lengths_of_orthonormalized(MatrixXd& A) {
  Eigen::VectorXd length = Eigen::VectorXd::Zero(A.cols());
  for (Eigen::Index i = 0; i < A.cols(); ++i) {
    for (int twice = 0; twice < 2; ++twice)  // the second time for what rounding left
      for (Eigen::Index j = 0; j < i; ++j) A.col(i) -= A.col(j).dot(A.col(i)) * A.col(j);
    length[i] = A.col(i).stableNorm();  // whose squares may be no numbers
    A.col(i) /= length[i];
  }
  return length;
}

// So many orthonormal deviations that the motion allows, all of them for count < 0: along the constraints, if there are any, and in directions that
// are nobody's own, for one that is, is never left.
template <class MatrixXd>
MatrixXd first_deviations(const FlowInPieces& flow, double t0, const Eigen::VectorXd& y0, Eigen::Index count) {
  const PieceOfFlow first = flow(t0, y0, t0);
  Eigen::ColPivHouseholderQR<MatrixXd> basis(first.Phi);
  basis.setThreshold(1e-9);
  const Eigen::Index most = basis.rank();
  if (count < 0) count = most;
  if (count < 1 || count > most)
    throw_invalid_value({"there must be from 1 to ", most, " directions, one for each deviation that the motion allows, but ", count, " were asked for"});
  MatrixXd Q(y0.size(), count);
  for (Eigen::Index j = 0; j < count; ++j)
    for (Eigen::Index i = 0; i < Q.rows(); ++i) Q(i, j) = std::cos(1.0 + 2.3 * static_cast<double>(i * i) + 1.7 * static_cast<double>((i + 1) * j));
  Q = MatrixXd(first.Phi * Q);
  lengths_of_orthonormalized(Q);
  return Q;
}

}  // namespace qdot::detail
