#pragma once
// SPDX-License-Identifier: MIT
//
// How fast motions part that begin close together
// ===============================================
//
//     Φ = U diag(σ) Vᵀ         Φ = ∂y(t)/∂y₀: the deviation V_i at the start becomes σ_i U_i at the end
//     λ_i = (1/t) ln σ_i       Lyapunov's exponents, for t → ∞; chaos is a bounded motion with a positive one
//
// Over a long time Φ overflows, and its columns all become the first axis. So it is made in pieces, and orthonormalized:
//
//     Φ_k Q_{k−1} = Q_k R_k ,       λ_i = Σ ln (R_k)_ii / Σ t_k        counted from `settle` on.
//
// The limit is reached like 1/t for zeros and like 1/√t for chaos, whatever the tolerance. The standard error takes ten
// parts of the time as independent, so it is too small near islands of regular motion. Σ λ_i is the mean of div f; without
// dissipation exponents come in pairs ±λ, and two are 0 for each conserved quantity that flows. Deviations are of q, q̇
// and the effects' states, not of momenta: the exponents are the same while M stays bounded. Events and impacts are in Φ.

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SVD>

#include "qdot/analysis/sensitivity.hpp"
#include "qdot/analysis/variations/flow_in_pieces.hpp"
#include "qdot/error.hpp"

namespace qdot {

/// The axes of the ellipsoid that a sphere of small deviations becomes.
struct FiniteTimeLyapunov {
  Eigen::VectorXd sigma;  ///< lengths, falling
  Eigen::MatrixXd start;  ///< in columns, what is stretched so: at the start
  Eigen::MatrixXd end;    ///< and what becomes of it, both of length 1

  /// The exponents ln(σ)/|t| of a Φ over a time t that is not 0, falling; −∞ where σ is 0.
  Eigen::VectorXd exponents(double t) const { return sigma.array().log() / std::abs(t); }
};

/// The singular values σ of Φ and their directions; Lyapunov's exponents for a finite time t are ln(σ)/|t|, `.exponents(t)`.
///
/// Small ones are good to some ε σ₁, not to their own size.
///
/// @param Phi  square or not, finite
/// @throws InvalidValue  when Φ is not finite
template <class MatrixXd = Eigen::MatrixXd>  // compiled only where it is called
FiniteTimeLyapunov finite_time_lyapunov(const std::type_identity_t<MatrixXd>& Phi) {
  if (!Phi.allFinite())
    throw InvalidValue("finite_time_lyapunov: Phi must be finite, but it has NaN or infinity in it; end the run earlier, or ask for lyapunov_spectrum()");
  const Eigen::JacobiSVD<MatrixXd> svd(Phi, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return {svd.singularValues(), svd.matrixV(), svd.matrixU()};
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template FiniteTimeLyapunov finite_time_lyapunov<Eigen::MatrixXd>(const Eigen::MatrixXd&);
#endif

/// How exponents are measured.
struct LyapunovOptions {
  double interval = 1.0;            ///< between two orthonormalizations; halved where directions part too far for it
  std::optional<double> settle = {};  ///< from the start, not counted; a tenth of the time unless given
  Eigen::Index directions = -1;     ///< the first so many exponents; all, unless given. Φ has all its columns in any case
};

/// Lyapunov's exponents of a motion.
struct LyapunovSpectrum : RunEnd {
  Eigen::VectorXd lambda{};                ///< 1/time, falling as far as the time was long enough; empty if the run ended before anything was counted
  Eigen::VectorXd standard_error{};        ///< of each, from ten parts of the time; infinite where fewer than ten intervals were counted
  std::vector<double> times{};             ///< ends of the intervals that were counted
  std::vector<Eigen::VectorXd> running{};  ///< the exponents from `settle` to these times
};

namespace detail {

inline constexpr int parts_of_time = 10;

template <class = void>  // compiled only where it is called
Eigen::VectorXd standard_errors(const LyapunovSpectrum& found, double begun) {
  const Eigen::Index count = found.lambda.size();
  Eigen::VectorXd error = Eigen::VectorXd::Constant(count, std::numeric_limits<double>::infinity());
  if (found.times.size() < parts_of_time) return error;
  error.setZero();
  const double duration = std::abs(found.times.back() - begun);
  std::size_t k = 0;
  Eigen::VectorXd passed = Eigen::VectorXd::Zero(count);  // λ t up to the last part
  for (int part = 1; part <= parts_of_time; ++part) {
    const double from = k == 0 ? 0.0 : std::abs(found.times[k - 1] - begun);
    while (k < found.times.size() && (part == parts_of_time || std::abs(found.times[k] - begun) <= part * duration / parts_of_time)) ++k;
    const double to = k == 0 ? 0.0 : std::abs(found.times[k - 1] - begun);
    if (!(to > from)) continue;
    const Eigen::VectorXd until = found.running[k - 1] * to;
    error += ((until - passed) / (to - from) - found.lambda).cwiseAbs2();
    passed = until;
  }
  return (error / (parts_of_time * (parts_of_time - 1))).cwiseSqrt();
}

// The exponents as they are at the end, and their errors.
template <class = void>  // compiled only where it is called
void write_exponents(LyapunovSpectrum& result, double begun) {
  if (result.message.empty()) result.message = sentence({name(result.outcome), " at t = ", result.t});
  if (result.running.empty()) return;
  result.lambda = result.running.back();
  result.standard_error = standard_errors(result, begun);
}

// @param resolved  the shortest interval that times of this size resolve
template <class = void>  // compiled only where it is called
void require_exponents(double t0, double t_end, double interval, double settle, double resolved) {
  if (!std::isfinite(t_end) || t_end == t0)
    throw_invalid_value({"the end of the run must be finite and not its start, but it is ", t_end, " from ", t0, "; give it a time"});
  if (interval > 0.0 && interval <= resolved)
    throw_invalid_value({"the interval between orthonormalizations must be longer than the times resolve, but ", interval, " is below ", {resolved, 3},
                         "; make it longer, or count the time from a moment that is near"});
  if (!(interval > 0.0) || !std::isfinite(interval))
    throw_invalid_value({"the interval between orthonormalizations must be positive, but is ", interval,
                         "; give it some fraction of the time in which deviations grow tenfold"});
  const double forward = t_end < t0 ? -1.0 : 1.0;
  if (!(settle >= 0.0) || !(forward * (t_end - (t0 + forward * settle)) > 0.0))
    throw_invalid_value({"the time to settle must lie within the run, but is ", settle, " of ", std::abs(t_end - t0), "; give it less, or run longer"});
}

// The end of a run whose deviations have become too much alike.
//
// @param length  of each deviation, orthonormalized, at t
template <class = void>  // compiled only where it is called
void end_without_deviations(RunEnd& end, double t, const Eigen::VectorXd& length) {
  const double longest = length.maxCoeff(), shortest = length.minCoeff();
  end.outcome = Outcome::not_differentiable;
  const Eigen::Index left = longest > 0.0 ? (length.array() * parts_too_far > longest).count() : 0;
  end.message = sentence({name(end.outcome), ": ", length.size(), " deviations must remain different, but at t = ", t, " one has shrunk to ", shortest,
                          " of its length at once; ", left > 0 ? "ask for fewer directions, of which there are left " : "none is left, so end the run earlier",
                          left > 0 ? std::to_string(left) : std::string()});
}

template <class MatrixXd>
LyapunovSpectrum lyapunov_spectrum_of(const FlowInPieces& flow, double t0, const Eigen::VectorXd& y0, double t_end, const LyapunovOptions& options) {
  const double duration = std::abs(t_end - t0), forward = t_end < t0 ? -1.0 : 1.0;
  const double settle = options.settle.value_or(0.1 * duration);
  const double resolved = 8.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(t0), std::abs(t_end));
  require_exponents(t0, t_end, options.interval, settle, resolved);
  double settled = t0 + forward * settle;
  LyapunovSpectrum result{{.t = t0, .y = y0}};
  MatrixXd Q = first_deviations<MatrixXd>(flow, t0, y0, options.directions);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(Q.cols());
  double begun = t0, interval = std::max(std::min(options.interval, duration - settle), resolved);
  bool counts = settled == t0;
  const double smallest = std::max(1e-9 * interval, resolved);
  while (forward * (t_end - result.t) > 0.0) {
    double next = result.t + forward * interval;
    if (!counts && forward * (next - settled) > 0.0) next = settled;
    if (forward * (t_end - next) < 1e-3 * interval) next = t_end;
    const PieceOfFlow piece = flow(result.t, result.y, next);
    if (piece.outcome != Outcome::completed) {
      static_cast<RunEnd&>(result) = piece;
      break;
    }
    if (!piece.may_end_here && next == settled && std::abs(next - result.t) > smallest) {
      settled = result.t + 0.83 * (settled - result.t);
      continue;
    }
    if (!piece.may_end_here && next != t_end) {
      if (can_be_shortened(result, piece.t, interval, smallest)) continue;
      break;
    }
    MatrixXd along = piece.Phi * Q;
    const Eigen::VectorXd length = lengths_of_orthonormalized(along);
    if (!(length.minCoeff() > 0.0 && length.maxCoeff() <= parts_too_far * length.minCoeff())) {
      if (interval > smallest) {
        interval *= 0.5;
        continue;
      }
      end_without_deviations(result, piece.t, length);
      break;
    }
    if (counts) sum += length.array().log().matrix();
    Q = along;
    result.t = piece.t;
    result.y = piece.y;
    if (counts) {
      result.times.push_back(result.t);
      result.running.push_back(sum / std::abs(result.t - begun));
    } else if (result.t == settled) {
      counts = true;
      begun = result.t;
    }
  }
  write_exponents(result, begun);
  return result;
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template LyapunovSpectrum lyapunov_spectrum_of<Eigen::MatrixXd>(const FlowInPieces&, double, const Eigen::VectorXd&, double, const LyapunovOptions&);
#endif

}  // namespace detail

/// Lyapunov's exponents of the motion of a system or scene from a start.
///
/// One run of the motion with its derivatives, begun anew after each interval. On m constraints, closed contacts among them, 2m directions lead out and have no
/// exponent; sticking friction takes one. Where a contact comes to rest or a friction begins to stick on the way, deviations are lost. The run
/// then ends as not_differentiable, and its message tells how many directions are left; ask for so many.
///
/// @param start   State{t, q, qdot}, or FirstOrderState{t, y}; on the constraints, if there are any
/// @param method  Dop853{} or Dopri5{}
/// @param events  events(…)
/// @return        exponents, their running values, and how the run ended; what was counted before a failure stays
/// @throws        as sensitivities(); InvalidValue for an interval, a time to settle or a number of directions that cannot be
template <class System, class Start, class Method, class... Events>
LyapunovSpectrum lyapunov_spectrum(const System& system, const Start& start, double t_end, const Method& method, const Options& options = {},
                                   const LyapunovOptions& wanted = {}, const EventList<Events...>& events = {}) {
  const auto flow = detail::flow_in_pieces(system, method, options, events);
  return detail::lyapunov_spectrum_of<Eigen::MatrixXd>(flow, start.t, detail::packed(first_order_form(system), start), t_end, wanted);
}

// Old names, accepted until 0.4.

using Stretching [[deprecated("qdot: say FiniteTimeLyapunov")]] = FiniteTimeLyapunov;

/// finite_time_lyapunov() by its old name.
template <class MatrixXd = Eigen::MatrixXd>  // compiled only where it is called
[[deprecated("qdot: say finite_time_lyapunov()")]]
FiniteTimeLyapunov stretching(const std::type_identity_t<MatrixXd>& Phi) {
  return finite_time_lyapunov(Phi);
}

}  // namespace qdot
