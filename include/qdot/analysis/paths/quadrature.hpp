#pragma once
// SPDX-License-Identifier: MIT
//
// The integral of a function over an interval, to a tolerance.
//
// Gauss' formula of 7 points and Kronrod's of 15, which contains them, disagree by far more than the error of the second. The part of the interval
// where they disagree most is halved until all parts together agree to the tolerance: a smooth function takes 15 evaluations or 30, a kink
// some thousand. Nodes and weights: R. Piessens et al., QUADPACK, 1983.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <vector>

namespace qdot::detail {

struct Integral {
  double value = 0.0, error = 0.0;
  double worst_from = 0.0, worst_to = 0.0;  // the part with the largest error
  int evaluations = 0;
};

struct IntegralPart {
  double from, to, value, error, size;  // size: ∫|f|
};

template <class = void>  // compiled only where it is called
IntegralPart integral_part(const std::function<double(double)>& f, double from, double to) {
  static constexpr std::array<double, 8> node{0.991455371120812639206854697526329, 0.949107912342758524526189684047851, 0.864864423359769072789712788640926,
                                              0.741531185599394439863864773280788, 0.586087235467691130294144691838259, 0.405845151377397166906606412076949,
                                              0.207784955007898467600689403773245, 0.0};
  static constexpr std::array<double, 8> kronrod{0.022935322010529224963732008058970, 0.063092092629978553290700663189204, 0.104790010322250183839876322541518,
                                                 0.140653259715525918745189590510238, 0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
                                                 0.204432940075298892414161999234649, 0.209482141084727828012999174891714};
  static constexpr std::array<double, 4> gauss{0.129484966168869693270611432679082, 0.279705391489276667901467771423780, 0.381830050505118944950369775488975,
                                               0.417959183673469387755102040816327};
  const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
  double fine = 0.0, coarse = 0.0, size = 0.0;
  for (std::size_t i = 0; i < node.size(); ++i) {
    const double right = f(middle + half * node[i]), left = i + 1 < node.size() ? f(middle - half * node[i]) : 0.0;
    fine += kronrod[i] * (right + left);
    size += kronrod[i] * (std::abs(right) + std::abs(left));
    if (i % 2 == 1) coarse += gauss[i / 2] * (right + left);
  }
  return {from, to, half * fine, std::abs(half * (fine - coarse)), std::abs(half * size)};
}

// ∫ f dt; the error is that of the coarser formula, and at least what rounding leaves.
template <class = void>  // compiled only where it is called
Integral integral_of(const std::function<double(double)>& f, double from, double to, double tolerance, int most_evaluations) {
  std::vector<IntegralPart> parts{integral_part(f, from, to)};
  Integral result;
  for (int evaluations = 15;; evaluations += 30) {
    double size = 0.0;
    result = {0.0, 0.0, from, to, evaluations};
    std::size_t worst = 0;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      result.value += parts[k].value;
      result.error += parts[k].error;
      size += parts[k].size;
      if (!(parts[k].error <= parts[worst].error)) worst = k;
    }
    result.error = std::max(result.error, 4.0 * std::numeric_limits<double>::epsilon() * size);
    const IntegralPart whole = parts[worst];
    result.worst_from = whole.from;
    result.worst_to = whole.to;
    const double middle = 0.5 * (whole.from + whole.to);
    if (!std::isfinite(result.value) || result.error <= tolerance * size || evaluations + 30 > most_evaluations || middle == whole.from || middle == whole.to)
      return result;
    parts[worst] = integral_part(f, whole.from, middle);
    parts.push_back(integral_part(f, middle, whole.to));
  }
}

}  // namespace qdot::detail
