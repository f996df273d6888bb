#pragma once
// SPDX-License-Identifier: MIT
//
// A reference: the same motion with more digits, by another method, so that the error of a run can be seen.
//
//     const auto exact = reference_motion(system, start, {1.0, 2.0, 5.0});        exact.y.col(2), exact.uncertainty
//
// A tighter tolerance of the same stepper shares its faults, and its rounding, amplified by the motion. Here T and V compute
// in long double, or a quadruple type, and a basic step H is extrapolated from n₁ < … < n_K substeps h = H/n of the midpoint
// rule:
//
//     z_{k+1} = z_{k−1} + 2 h f(z_k) ,      T_{j,k} = T_{j,k−1} + (T_{j,k−1} − T_{j−1,k−1}) / ((n_j / n_{j−k})² − 1) .
//
// Its error for even n has even powers of h alone, so T_{K,K} has order 2K. It is done twice, with two sequences n_j, orders
// and tolerances, relative to the largest value of each component; the larger difference is the uncertainty. A third run from
// a start moved by 1e-10 gives the gain: gain · 1.1e-16 is the floor of any method that carries its state in double. (Gragg,
// SIAM J. Numer. Anal. 2 (1965) 384; Bulirsch, Stoer, Numer. Math. 8 (1966) 1; Hairer, Nørsett, Wanner, I, II.8–II.9.)

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "qdot/analysis/reference_equations.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/integrate/steps/fixed_step.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot {

/// The reference could not be computed: it took too long, or the equations of motion have no value on the way.
class NoReference : public Error {
 public:
  using Error::Error;
};

/// A motion at chosen times, better known than a run in double knows it.
struct ReferenceMotion {
  std::vector<double> t;                                ///< as asked for, the start not among them unless asked for
  Matrix<long double, Dynamic, Dynamic> y;              ///< [q; q̇; …] at each time, a column each
  Eigen::VectorXd scale;                                ///< largest |yᵢ| over the start and all times; errors are relative to it
  Eigen::VectorXd rate;                                 ///< largest |ẏᵢ|
  double uncertainty = 0.0;                             ///< largest difference of two computations, relative to scale
  double gain = std::numeric_limits<double>::quiet_NaN();  ///< largest amplification of a relative change of the start; NaN: unknown
  long evaluations = 0;                                 ///< of the equations of motion, all computations together
  std::string made_by;                                  ///< one line for people

  /// What one rounding of the start has become at the worst time; NaN where the gain is unknown.
  double rounding_floor() const noexcept { return 0.5 * std::numeric_limits<double>::epsilon() * gain; }

  /// Largest error of a state at time k, relative to scale.
  double error(std::size_t k, const Eigen::Ref<const Eigen::VectorXd>& state) const {
    double largest = 0.0;
    for (Eigen::Index i = 0; i < state.size(); ++i) {
      const auto e = static_cast<double>(std::abs(static_cast<long double>(state[i]) - y(i, static_cast<Eigen::Index>(k)))) / scale[i];
      if (!(e <= largest)) largest = e;  // NaN, once seen, stays
    }
    return largest;
  }
};

/// What a reference may cost.
struct ReferenceOptions {
  double max_seconds = 60.0;  ///< of all computations together
  bool with_gain = true;      ///< compute the gain as well: a third of the time
};

namespace detail {

// A component that stays below this part of the largest one is zero, and is measured beside the largest.
inline constexpr double negligible_error = 1e-12;

/// How one of the two computations is done.
template <class S>
struct ExtrapolationPlan {
  std::vector<int> substeps;
  S tolerance;
};

// Extrapolates the motion of ẏ = f(t, y); f(t, y, ydot) writes ydot and may throw Errors.
template <class S, class F>
class Extrapolation {
  using Y = Vector<S, Dynamic>;

 public:
  // The error of component i is controlled beside scale[i]; without a scale, beside the largest value so far.
  Extrapolation(const F& f, ExtrapolationPlan<S> plan, std::chrono::steady_clock::time_point deadline, Y scale = {})
      : f_(f), plan_(std::move(plan)), deadline_(deadline), given_scale_(std::move(scale)), rows_(plan_.substeps.size()) {}

  long evaluations() const noexcept { return evaluations_; }
  const Y& largest_values() const noexcept { return seen_; }
  const Y& largest_rates() const noexcept { return rate_; }

  // y at each of the times, which go one way from t0.
  Matrix<S, Dynamic, Dynamic> motion(double t0, const Y& start, const std::vector<double>& times) {
    Matrix<S, Dynamic, Dynamic> result(start.size(), static_cast<Eigen::Index>(times.size()));
    y_ = start;
    lost_ = Y::Zero(start.size());
    f0_ = f1_ = step_ = lost_;
    seen_ = y_.cwiseAbs();
    rate_ = lost_;
    t_ = S(t0);
    planned_ = S(0);
    for (std::size_t k = 0; k < times.size(); ++k) {
      advance_to(S(times[k]));
      result.col(static_cast<Eigen::Index>(k)) = y_;
    }
    return result;
  }

 private:
  void evaluate(const S& t, const Y& y, Y& ydot) {
    ++evaluations_;
    f_(t, y, ydot);
  }

  void advance_to(const S& t_limit) {
    using std::abs, std::ceil, std::max, std::min, std::pow;
    const S span = t_limit - t_;
    if (span == S(0)) return;
    while (t_ != t_limit) {
      if (std::chrono::steady_clock::now() > deadline_)
        throw NoReference("the reference took too long and had come to t = " + text_of(static_cast<double>(t_)) +
                          "; allow it more seconds or ask for a shorter motion");
      evaluate(t_, y_, f0_);
      if (planned_ == S(0)) planned_ = first_step(abs(span));
      const S rest = t_limit - t_;
      const S count = max(S(1), S(ceil(abs(rest) / planned_)));
      const S H = rest / count;
      S error = S(-1);  // none: the equations had no value on the way
      try {
        error = attempted(H);
      } catch (const NoReference&) {
        throw;
      } catch (const Error&) {
      }
      const S order = S(2 * static_cast<int>(plan_.substeps.size()) - 1);
      const S least = plan_.tolerance / S(1e6);
      const S factor = error < S(0) || !(error < S(1e30)) ? S(0.25)
                                                          : S(0.75) * S(pow(plan_.tolerance / max(error, least), S(1) / order));
      if (error >= S(0) && error <= plan_.tolerance) {
        for (Eigen::Index i = 0; i < y_.size(); ++i) add_compensated(y_[i], lost_[i], step_[i]);
        t_ = count == S(1) ? t_limit : t_ + H;
        seen_ = seen_.cwiseMax(y_.cwiseAbs());
        rate_ = rate_.cwiseMax(f0_.cwiseAbs());
        const S next = abs(H) * min(factor, S(3));
        planned_ = count == S(1) ? max(next, min(planned_, abs(H) * S(3))) : next;
      } else {
        planned_ = abs(H) * min(max(factor, S(0.1)), S(0.7));
        if (planned_ <= S(64) * std::numeric_limits<S>::epsilon() * max(abs(t_), abs(t_limit)))
          throw NoReference("the reference stuck at t = " + text_of(static_cast<double>(t_)) +
                            ", where its step became nothing; end the motion before the singularity");
      }
    }
  }

  // A tenth of the time in which y would change by its own size.
  S first_step(const S& span) const {
    using std::max, std::min;
    S fastest(0);
    const S size = seen_.maxCoeff();
    for (Eigen::Index i = 0; i < y_.size(); ++i) {
      const S own = f0_[i] < S(0) ? -f0_[i] : f0_[i];
      fastest = max(fastest, own / max(seen_[i], max(size / S(100), S(1e-30))));
    }
    return fastest > S(0) ? min(span, S(0.1) / fastest) : span / S(16);
  }

  // step_ ← the increment over H; returns the error beside what has been seen of each component.
  S attempted(const S& H) {
    using std::abs, std::max;
    const std::size_t K = plan_.substeps.size();
    for (std::size_t j = 0; j < K; ++j) {
      Y increment = midpoint(H, plan_.substeps[j]);
      for (std::size_t k = 0; k < j; ++k) {  // rows_[k] holds T_{j−1,k}
        const S ratio = S(plan_.substeps[j]) / S(plan_.substeps[j - k - 1]);
        const Y finer = increment + (increment - rows_[k]) / (ratio * ratio - S(1));
        rows_[k] = std::exchange(increment, finer);
      }
      rows_[j] = increment;
    }
    step_ = rows_[K - 1];
    S error(0);
    const S least = max(S(seen_.maxCoeff() * S(negligible_error)), S(std::numeric_limits<double>::min()));
    for (Eigen::Index i = 0; i < y_.size(); ++i) {
      const S scale = given_scale_.size() > 0 ? given_scale_[i] : max(seen_[i], max(S(abs(step_[i])), least));
      const S e = abs(step_[i] - rows_[K - 2][i]) / scale;
      if (!(e <= error)) error = e;
    }
    return error;
  }

  // z − y after n substeps of the midpoint rule: extrapolation multiplies rounding errors, and those of increments are small.
  Y midpoint(const S& H, int n) {
    const S h = H / S(n);
    Y before = Y::Zero(y_.size());
    Y now = h * f0_;
    Y z(y_.size());
    for (int k = 1; k < n; ++k) {
      z = y_ + now;
      evaluate(t_ + S(k) * h, z, f1_);
      before += (S(2) * h) * f1_;
      now.swap(before);
    }
    return now;
  }

  const F& f_;
  ExtrapolationPlan<S> plan_;
  std::chrono::steady_clock::time_point deadline_;
  Y given_scale_;
  std::vector<Y> rows_;
  Y y_, lost_, f0_, f1_, step_, seen_, rate_;
  S t_ = S(0), planned_ = S(0);
  long evaluations_ = 0;
};

// Both computations, their difference, and the gain, for any ẏ = f(t, y, ydot).
template <class S, class F>
ReferenceMotion extrapolated_reference(const F& f, double t0, const Eigen::VectorXd& start, const std::vector<double>& times,
                                       const ReferenceOptions& options) {
  const auto deadline = std::chrono::steady_clock::now() +
                        std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(
                            std::min(options.max_seconds, 1e8)));
  for (std::size_t k = 0; k < times.size(); ++k) {
    const double before = k == 0 ? t0 : times[k - 1];
    if (!std::isfinite(times[k]) || (times[k] - before) * (times.back() - t0) < 0)
      throw InvalidValue("the times of a reference must follow each other from the start t = " + text_of(t0) +
                         " in one direction, but " + text_of(times[k]) + " comes after " + text_of(before) + "; sort them");
  }
  const S epsilon = std::numeric_limits<S>::epsilon();
  using Y = Vector<S, Dynamic>;
  const Y y0 = start.template cast<S>();

  ReferenceMotion result;
  result.t = times;
  // A quick look first: how large the components become, so that errors can be controlled beside that.
  Extrapolation<S, F> look(f, {{2, 4, 6, 8, 12, 16}, S(1e-9)}, deadline);
  look.motion(t0, y0, times);
  result.scale = look.largest_values().template cast<double>();
  result.rate = look.largest_rates().template cast<double>();
  const double largest = std::max(result.scale.maxCoeff(), std::numeric_limits<double>::min());
  for (double& s : result.scale)
    if (!(s > negligible_error * largest)) s = largest;
  const Y scale = result.scale.template cast<S>();

  // These multiply rounding errors by 16 and 9; 2, 4, 6 … 18 would by 256.
  Extrapolation<S, F> first(f, {{2, 4, 6, 8, 10, 14, 18, 24, 32}, S(5) * epsilon}, deadline, scale);
  const Matrix<S, Dynamic, Dynamic> a = first.motion(t0, y0, times);
  Extrapolation<S, F> second(f, {{2, 4, 6, 8, 12, 16, 24, 32}, S(10) * epsilon}, deadline, scale);
  const Matrix<S, Dynamic, Dynamic> b = second.motion(t0, y0, times);
  result.y = a.template cast<long double>();
  const auto distance = [&](const auto& other) {
    double worst = 0.0;
    for (Eigen::Index k = 0; k < a.cols(); ++k)
      for (Eigen::Index i = 0; i < a.rows(); ++i) {
        using std::abs;
        worst = std::max(worst, static_cast<double>(S(abs(S(a(i, k) - other(i, k))))) / result.scale[i]);
      }
    return worst;
  };
  result.uncertainty = distance(b);
  result.evaluations = look.evaluations() + first.evaluations() + second.evaluations();
  if (options.with_gain) {
    constexpr double move = 1e-10;
    Extrapolation<S, F> third(f, {{2, 4, 6, 8, 12, 16, 24, 32}, std::max(S(1e-16), S(200) * epsilon)}, deadline, scale);
    Y moved = y0;
    for (Eigen::Index i = 0; i < moved.size(); ++i) moved[i] += S((i % 3 == 1 ? -move : move) * result.scale[i]);
    result.gain = distance(third.motion(t0, moved, times)) / move;
    result.evaluations += third.evaluations();
  }
  result.made_by = "extrapolation with " + std::to_string(std::numeric_limits<S>::digits10) + " digits, orders 18 and 16";
  return result;
}

}  // namespace detail

/// The motion of a system, or of a scene without constraints, at given times, with more digits than double has.
///
/// Costs two computations (three with the gain) at about 100 evaluations a step, each several times dearer than in double.
///
/// @tparam S      a scalar with more digits than double that T and V accept: long double, a quadruple type
/// @param system  a mechanical system, or a scene whose effects are forces
/// @param start   State{t, q, qdot}
/// @param times   in the direction of the motion
/// @throws NoReference   when it takes too long, or the motion meets a singularity
/// @throws InvalidValue  when the times are not in order
template <class S = long double, class Sys, class Start>
ReferenceMotion reference_motion(const Sys& system, const Start& start, const std::vector<double>& times,
                                 const ReferenceOptions& options = {}) {
  static_assert(std::numeric_limits<S>::digits > std::numeric_limits<double>::digits,
                "qdot: a reference needs a scalar with more digits than double; where long double is double, pass a quadruple type");
  const Eigen::VectorXd y0 = detail::packed(first_order_form(system), start);
  return detail::extrapolated_reference<S>(
      [&system](const S& t, const Vector<S, Dynamic>& y, Vector<S, Dynamic>& ydot) { detail::write_derivative(system, t, y, ydot); },
      start.t, y0, times, options);
}

}  // namespace qdot
