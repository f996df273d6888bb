// SPDX-License-Identifier: MIT
#include "program/accurate_run.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

namespace qdot::program {

namespace {

/// Largest difference of two motions at their samples, relative where a component is larger than 1.
double largest_difference(const Result& a, const Result& b) {
  double largest = 0;
  for (std::size_t i = 0; i < std::min(a.samples.size(), b.samples.size()); ++i) {
    const Eigen::VectorXd& y = b.samples[i].y;
    const Eigen::VectorXd scale = y.cwiseAbs().cwiseMax(1.0);
    largest = std::max(largest, (a.samples[i].y - y).cwiseQuotient(scale).cwiseAbs().maxCoeff());
  }
  return largest;
}

}  // namespace

Result simulated_to_accuracy(const std::shared_ptr<const Model>& model, Request& request, double accuracy,
                             const Watcher& watcher) {
  constexpr double tightest = 1e-14;
  request.rtol = request.atol = std::clamp(accuracy / 10, 10 * tightest, 1e-3);
  Result coarse = simulated(model, request, watcher);
  while (coarse.outcome == Outcome::completed) {
    request.rtol = request.atol = std::max(request.rtol / 10, tightest);
    Result fine = simulated(model, request, watcher);
    if (fine.outcome != Outcome::completed) return fine;
    fine.error_estimate = largest_difference(coarse, fine);
    if (*fine.error_estimate <= accuracy) return fine;
    if (request.rtol <= tightest) {
      fine.outcome = Outcome::accuracy_not_reached;
      fine.message = "accuracy_not_reached: the whole motion must be accurate to " + detail::text_of(accuracy) +
                     ", but at the tightest tolerances its error is about " + detail::text_of(*fine.error_estimate) +
                     "; ask for less accuracy or a shorter time";
      return fine;
    }
    coarse = std::move(fine);
  }
  return coarse;
}

}  // namespace qdot::program
