#pragma once
// SPDX-License-Identifier: MIT
//
// The first step of an explicit method of order p.
//
// Nothing is known yet but y and f = ẏ. In units of the tolerance, h = 0.01 ‖y‖/‖f‖ changes y by a hundredth of its own size. An explicit step of
// Euler's over that h shows how fast f changes, and so the step for a method of order p:
//
//     (0.01 / max(‖f‖, ‖f(t + h, y + h f) − f‖/h))^(1/p) ,   at most 100 h.
//
// Reference: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, II.4.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace qdot::detail {

// |h| of the first step, at most `longest`.
//
// weight(i) is what component i may be wrong by; probe(h) → the derivative after an explicit step of length h, or nullptr where there is none.
template <class Weight, class Probe>
[[gnu::cold]] double first_step(int order, Eigen::Index size, const double* y, const double* f, const Weight& weight, double longest, const Probe& probe) {
  double y_norm = 0.0, f_norm = 0.0;
  for (Eigen::Index i = 0; i < size; ++i) {
    const double scale = 1.0 / weight(i);
    y_norm += y[i] * scale * y[i] * scale;
    f_norm += f[i] * scale * f[i] * scale;
  }
  const double blind = std::min(1e-6, 1e-3 * longest);  // nothing says how fast the motion is
  double h = f_norm <= 1e-10 || y_norm <= 1e-10 ? blind : 0.01 * std::sqrt(y_norm / f_norm);
  if (!(h > 0.0)) h = blind;  // sizes whose squares are no numbers
  h = std::min(h, longest);
  const double* const later = probe(h);
  double change = 0.0;
  for (Eigen::Index i = 0; later && i < size; ++i) {
    const double d = (later[i] - f[i]) / weight(i);
    change += d * d;
  }
  if (!later || !std::isfinite(change + f_norm)) return 0.1 * h;
  const double curvature = std::max(std::sqrt(change) / h, std::sqrt(f_norm));
  const double wanted = curvature <= 1e-15 ? std::max(1e-6, h * 1e-3) : std::pow(0.01 / curvature, 1.0 / order);
  return std::min({100.0 * h, wanted, longest});
}

}  // namespace qdot::detail
