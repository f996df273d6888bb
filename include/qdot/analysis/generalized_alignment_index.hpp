#pragma once
// SPDX-License-Identifier: MIT
//
// Whether a motion is regular or chaotic, found out soon
// ======================================================
//
//     GALI_k(t) = | ŵ₁ ∧ ŵ₂ ∧ … ∧ ŵ_k | ,     ŵ_i = w_i / |w_i| ,     w_i(t) = Φ(t) w_i(0)
//
// is the volume that the directions of k deviations span: 1 at right angles, 0 where one depends on the others. In chaos
// all turn into the direction that grows fastest, long before an exponent is known. For N coordinates and conserved energy:
//
//     chaotic        ∝ exp(−[(λ₁ − λ₂) + … + (λ₁ − λ_k)] t)         below 10⁻⁸ after some 18/λ₁, for k = 2
//     regular        about constant for 2 ≤ k ≤ N ,  ∝ t^(−2(k−N)) for N < k ≤ 2N ;    GALI₂ ∝ 1/t² for N = 1
//
// With dissipation, directions may align without chaos. So a motion is called chaotic only where
// growth = ln(|w₁(t)|/|w₁(0)|), the fast Lyapunov indicator, has grown like λ₁ t as well (ln t on regular motions, less
// with dissipation). Skokos, Bountis, Antonopoulos, Physica D 231 (2007) 30.

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "qdot/analysis/variations/flow_in_pieces.hpp"
#include "qdot/error.hpp"

namespace qdot {

/// How an alignment is watched.
struct GeneralizedAlignmentOptions {
  Eigen::Index deviations = 2;  ///< k, at least two and at most as many as the motion allows
  double interval = 0.0;        ///< time between two looks; a hundredth of the run for 0. Shorter where deviations part too far for it
  double aligned = 1e-8;        ///< below this index the run ends as chaotic, where deviations have grown, too; 0: goes on to its end
};

/// How k deviations have aligned.
struct GeneralizedAlignmentIndex : RunEnd {
  bool chaotic = false;          ///< whether the index fell below `aligned` while deviations grew; the run then is completed, too, where it was left early
  std::vector<double> times{};   ///< of the looks
  std::vector<double> index{};   ///< GALI_k at these times, from 1 at the start
  std::vector<double> growth{};  ///< ln of what the first deviation has grown by
};

namespace detail {

// Deviations that grow by more than this within one interval cannot be told from each other at its end.
inline constexpr double grows_too_far = 1e7;

// Deviations may align because all of them decay, or all but one. Then growth follows a power of the time at most: by ln 2 times that power within
// the second half of the time. Chaos makes half of its growth there.
template <class = void>  // compiled only where it is called
bool grows_as_chaos_does(const GeneralizedAlignmentIndex& found, double t0) {
  const double half = 0.5 * std::abs(found.t - t0), growth = found.growth.back();
  std::size_t k = 0;
  while (k < found.times.size() && std::abs(found.times[k] - t0) < half) ++k;
  return growth > 4.5 && growth - found.growth[std::min(k, found.growth.size() - 1)] > 0.35 * growth;
}

template <class = void>  // compiled only where it is called
void require_alignment(double t0, double t_end, const GeneralizedAlignmentOptions& options) {
  if (!std::isfinite(t_end) || t_end == t0)
    throw_invalid_value({"the end of the run must be finite and not its start, but it is ", t_end, " from ", t0, "; give it a time"});
  if (!(options.interval >= 0.0) || !std::isfinite(options.interval))
    throw_invalid_value({"the time between two looks must be positive, or 0 for a hundredth of the run, but is ", options.interval});
  if (!(options.aligned >= 0.0 && options.aligned < 1.0))
    throw_invalid_value({"the index below which deviations are aligned must lie from 0 to 1, but is ", options.aligned, "; 1e-8 is usual"});
  if (options.deviations < 2)
    throw_invalid_value({"an alignment is of two deviations or more, but ", options.deviations, " were asked for; ask for 2"});
}

// Scales deviations to length 1; returns ln of the length that the first one had.
template <class MatrixXd>
double scale_to_directions(MatrixXd& deviations) {
  double growth = 0.0;
  for (Eigen::Index j = 0; j < deviations.cols(); ++j) {
    const double length = deviations.col(j).norm();
    deviations.col(j) /= length;
    if (j == 0) growth = std::log(length);
  }
  return growth;
}

// GALI of directions, which are orthonormalized.
template <class MatrixXd>
double volume_of_directions(MatrixXd directions) {
  const double volume = lengths_of_orthonormalized(directions).prod();
  return volume > 0.0 ? volume : 0.0;  // one depends on the others exactly
}

// The end of a run that has taken deviations away.
//
// @param lengths  of deviations at t, orthonormalized
template <class = void>  // compiled only where it is called
void end_with_lost_deviations(RunEnd& end, double t, const Eigen::VectorXd& lengths) {
  end.outcome = Outcome::not_differentiable;
  end.message = sentence({name(end.outcome), ": ", lengths.size(), " deviations must remain different, but at t = ", t,
                          " a contact that closes or a friction that sticks leaves ", (lengths.array() * parts_too_far > lengths.maxCoeff()).count(),
                          " of them, which says nothing of chaos; ask for so many, if they are two or more"});
}

template <class MatrixXd>
GeneralizedAlignmentIndex gali_of(const FlowInPieces& flow, double t0, const Eigen::VectorXd& y0, double t_end, const GeneralizedAlignmentOptions& options) {
  require_alignment(t0, t_end, options);
  const double forward = t_end < t0 ? -1.0 : 1.0, duration = std::abs(t_end - t0);
  const double resolved = 8.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(t0), std::abs(t_end));
  double interval = std::max(options.interval > 0.0 ? std::min(options.interval, duration) : duration / 100.0, resolved);
  GeneralizedAlignmentIndex result{{.t = t0, .y = y0}};
  MatrixXd W = first_deviations<MatrixXd>(flow, t0, y0, options.deviations);
  MatrixXd Q = W;  // the same deviations, kept at right angles
  double growth = 0.0;
  const double smallest = std::max(1e-9 * interval, 1e3 * resolved);
  while (forward * (t_end - result.t) > 0.0) {
    double next = result.t + forward * interval;
    if (forward * (t_end - next) < 1e-3 * interval) next = t_end;
    const PieceOfFlow piece = flow(result.t, result.y, next);
    if (piece.outcome != Outcome::completed) {
      static_cast<RunEnd&>(result) = piece;
      return result;
    }
    if (!piece.may_end_here && next != t_end) {
      if (can_be_shortened(result, piece.t, interval, smallest)) continue;
      return result;
    }
    MatrixXd directions = piece.Phi * W, basis = piece.Phi * Q;
    const Eigen::VectorXd lengths = lengths_of_orthonormalized(basis);
    const bool parts = !(lengths.minCoeff() > 0.0 && lengths.maxCoeff() <= parts_too_far * lengths.minCoeff());
    if ((parts || !(piece.Phi.cwiseAbs().maxCoeff() <= grows_too_far)) && interval > smallest) {
      interval *= 0.5;
      continue;
    }
    if (parts) {
      end_with_lost_deviations(result, piece.t, lengths);
      return result;
    }
    growth += scale_to_directions(directions);
    W = directions;
    Q = basis;
    const double volume = volume_of_directions(directions);
    result.t = piece.t;
    result.y = piece.y;
    result.times.push_back(result.t);
    result.index.push_back(volume);
    result.growth.push_back(growth);
    if (!(volume > options.aligned) && options.aligned > 0.0 && grows_as_chaos_does(result, t0)) {
      result.chaotic = true;
      result.message = sentence({"chaotic: ", options.deviations, " deviations have aligned to ", {volume, 3}, " at t = ", result.t,
                                 ", below ", {options.aligned, 3}});
      return result;
    }
  }
  const bool fell = !(result.index.back() > options.aligned) && options.aligned > 0.0;
  result.message = sentence({name(result.outcome), " at t = ", result.t, " without a sign of chaos: the index of alignment is ", {result.index.back(), 3},
                             fell ? ", but deviations have not grown as they do in chaos: the motion falls onto what attracts it" : ""});
  return result;
}

}  // namespace detail

/// Whether the motion of a system or scene from a start is chaotic, by the alignment of k deviations.
///
/// Costs a run with its derivatives, which ends early where there is chaos.
///
/// @param start   State{t, q, qdot}, or FirstOrderState{t, y}; on the constraints, if there are any
/// @param method  Dop853{} or Dopri5{}
/// @param events  events(…)
/// @return        the index over the time and the verdict; what was seen before a failure stays
/// @throws        as sensitivities(); InvalidValue for options that cannot be
template <class System, class Start, class Method, class... Events>
GeneralizedAlignmentIndex generalized_alignment_index(const System& system, const Start& start, double t_end, const Method& method, const Options& options = {},
                                                      const GeneralizedAlignmentOptions& wanted = {}, const EventList<Events...>& events = {}) {
  const auto flow = detail::flow_in_pieces(system, method, options, events);
  return detail::gali_of<Eigen::MatrixXd>(flow, start.t, detail::packed(first_order_form(system), start), t_end, wanted);
}

// Old names, accepted until 0.4.

using AlignmentOptions [[deprecated("qdot: say GeneralizedAlignmentOptions")]] = GeneralizedAlignmentOptions;
using Alignment [[deprecated("qdot: say GeneralizedAlignmentIndex")]] = GeneralizedAlignmentIndex;

/// generalized_alignment_index() by its old name.
template <class System, class Start, class Method, class... Events>
[[deprecated("qdot: say generalized_alignment_index()")]]
GeneralizedAlignmentIndex alignment(const System& system, const Start& start, double t_end, const Method& method, const Options& options = {},
                                    const GeneralizedAlignmentOptions& wanted = {}, const EventList<Events...>& events = {}) {
  return generalized_alignment_index(system, start, t_end, method, options, wanted, events);
}

}  // namespace qdot
