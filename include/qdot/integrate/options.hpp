#pragma once
// SPDX-License-Identifier: MIT
//
// Options of a run: how accurate, how far, at what price.
//
// An adaptive method accepts a step when its estimate e of the local error satisfies
//
//     ‖ eᵢ / (rtol |yᵢ| + atolᵢ) ‖ ≤ 1,
//
// so rtol is a number of digits and atolᵢ is the size below which component i no longer matters.
// Both are *local*: what is left of them at t_end depends on how the motion amplifies errors. Since
// angles and metres, positions and velocities share one vector, atol may be given per component.
//
// Everything that limits a run is here as well, and never raises: a run that meets a limit returns
// what it has with a named outcome. All of it has defaults; write what you want to change:
//
//     Options{.rtol = 1e-10, .atol = {1e-12, 1e-9}, .max_wall_seconds = 5}

#include <Eigen/Core>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/mechanics/by.hpp"

namespace qdot {

namespace detail {

inline constexpr double default_atol = 1e-12;  // suits motions of ordinary size

}  // namespace detail

/// Absolute tolerance: one number for all components, or one for each; or left to the run: 1e-12, and less for components whose motion is smaller than a
/// thousandth (integrate/driver/natural_tolerances.hpp).
class AbsoluteTolerance {
 public:
  AbsoluteTolerance() : AbsoluteTolerance(detail::default_atol) { is_default_ = true; }
  AbsoluteTolerance(double all) : values_(1) { values_[0] = all; }
  AbsoluteTolerance(Eigen::VectorXd each) : values_(std::move(each)) {}
  AbsoluteTolerance(std::initializer_list<double> each)
      : values_(Eigen::Map<const Eigen::VectorXd>(each.begin(), static_cast<Eigen::Index>(each.size()))) {}

  /// A number that the run may lower for components whose motion is small.
  static AbsoluteTolerance at_most(double all) {
    AbsoluteTolerance result(all);
    result.is_default_ = true;
    return result;
  }

  /// Number of values given: 1, or one for each component of y.
  Eigen::Index size() const noexcept { return values_.size(); }

  /// The tolerance of component i.
  double operator[](Eigen::Index i) const { return values_[values_.size() == 1 ? 0 : i]; }

  /// Whether it is left to the run.
  bool is_default() const noexcept { return is_default_; }

 private:
  Eigen::VectorXd values_;
  bool is_default_ = false;
};

/// What a run is asked to do. Times in the units of t.
struct Options {
  double rtol = 1e-9;              ///< relative tolerance of the local error, every component
  AbsoluteTolerance atol = {};     ///< absolute tolerance, one or per component of y, in its units; left out, 1e-12 or what a smaller motion asks for
  double initial_step = 0.0;       ///< |h| to try first; 0 lets the method choose
  double max_step = std::numeric_limits<double>::infinity();          ///< largest |h|
  long max_steps = 10'000'000;                                        ///< accepted steps
  long max_evaluations = std::numeric_limits<long>::max();            ///< right-hand sides; checked after each attempt at a step
  double max_wall_seconds = std::numeric_limits<double>::infinity();  ///< checked after each attempt at a step
  double state_norm_limit = std::numeric_limits<double>::infinity();  ///< largest |yᵢ|; a guard against finite nonsense
  double rcond_limit = 1e-13;             ///< least rcond(M), below which accelerations have three digits left; 0: never ends a run
  double constraint_rcond_limit = 0.0;    ///< the same of J M⁻¹ Jᵀ; 0, because dependent constraints are allowed
  double energy_drift_limit = 1e3;        ///< times what the tolerances allow, of a conserved energy (integrate/watch/any_watch.ipp); infinity: never
  std::vector<double> stop_times = {};    ///< switching times: landed on exactly, and the method starts afresh there
  std::vector<double> output_times = {};  ///< times at which Run::samples is filled, in the direction of the run
  By by = By::fastest;                    ///< how T and V are evaluated; as the system has it where that is left out (mechanics/by.hpp)
  bool keep_trajectory = true;            ///< keep dense output of every step: about 8·size·(order + 1) bytes a step
};

namespace detail {

// Shortest text that is good to read; 17 digits where a number must read back exactly are the report layer's business.
[[gnu::cold]] inline std::string text_of(double x) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.10g", x);
  return buffer;
}

[[noreturn, gnu::cold, gnu::noinline]] inline void refuse_option(const char* option, const char* rule, double given, const char* remedy) {
  throw_invalid_value({option, " ", rule, ", but is ", given, "; ", remedy});
}
inline void require_option(bool holds, const char* option, const char* rule, double given, const char* remedy) {
  if (!holds) refuse_option(option, rule, given, remedy);
}

// What stands for atol = 0: a component that is 0 before and after a step has no error, and 0/0 is no part of it.
inline double positive_atol(double atol) { return atol > 0.0 ? atol : std::numeric_limits<double>::min(); }

inline constexpr double least_rtol = 10 * std::numeric_limits<double>::epsilon();

/// Checks everything in the options that does not depend on the run's times.
///
/// @throws InvalidValue    a number outside its range
/// @throws DimensionError  atol has neither 1 nor `size` entries
template <class Number = double>
[[gnu::cold]] void require_valid(const Options& options, Eigen::Index size) {
  const auto is_limit = [](double x) { return x > 0; };  // false for NaN, true for infinity
  require_option(options.rtol >= least_rtol && options.rtol < 1, "rtol",
                 "must lie between 2.3e-15 (double has no more digits) and 1", options.rtol, "try 1e-9");
  if (options.atol.size() != 1 && options.atol.size() != size)
    throw DimensionError("atol", static_cast<long>(size), static_cast<long>(options.atol.size()),
                         "give one number for all components, or one for each (positions first, then velocities)");
  for (Eigen::Index i = 0; i < options.atol.size(); ++i) {
    const double atol = options.atol[i];
    const bool vanishes = atol > 0 && atol < std::numeric_limits<double>::min();  // 1/atol may be infinite
    require_option(atol >= 0 && std::isfinite(atol) && !vanishes, options.atol.size() == 1 ? "atol" : sentence({"atol[", i, "]"}).c_str(),
                   vanishes ? "must be 0 or at least 2.3e-308 (smaller numbers lose their digits)" : "must be finite and not negative", atol,
                   "give the size below which the component no longer matters");
  }
  require_option(is_limit(options.max_step), "max_step", "must be positive", options.max_step,
                 "leave it out for no limit");
  require_option(options.initial_step >= 0 && options.initial_step <= options.max_step, "initial_step",
                 "must lie between 0 (chosen by the method) and max_step", options.initial_step,
                 "leave it out; the sign is that of the run");
  require_option(options.max_steps >= 1, "max_steps", "must be at least 1", static_cast<double>(options.max_steps),
                 "leave it out for the default of ten million");
  require_option(options.max_evaluations >= 1, "max_evaluations", "must be at least 1",
                 static_cast<double>(options.max_evaluations), "leave it out for no limit");
  require_option(is_limit(options.max_wall_seconds), "max_wall_seconds", "must be positive", options.max_wall_seconds,
                 "leave it out for no limit");
  require_option(is_limit(options.state_norm_limit), "state_norm_limit", "must be positive", options.state_norm_limit,
                 "leave it out for no limit");
  require_option(options.rcond_limit >= 0 && options.rcond_limit < 1, "rcond_limit", "must lie between 0 and 1", options.rcond_limit,
                 "leave it out for 1e-13, or give 0 for no limit");
  require_option(options.constraint_rcond_limit >= 0 && options.constraint_rcond_limit < 1, "constraint_rcond_limit",
                 "must lie between 0 and 1", options.constraint_rcond_limit, "leave it out for no limit");
  require_option(options.energy_drift_limit >= 1, "energy_drift_limit", "must be at least 1", options.energy_drift_limit,
                 "leave it out for a thousand times what the tolerances allow");
  for (const double t : options.stop_times)
    require_option(std::isfinite(t), "every stop time", "must be finite", t, "remove it from stop_times");
  for (const double t : options.output_times)
    require_option(std::isfinite(t), "every output time", "must be finite", t, "remove it from output_times");
}

#ifdef QDOT_COMPILED
extern template void require_valid<double>(const Options&, Eigen::Index);
#endif

}  // namespace detail
}  // namespace qdot
