#pragma once
// SPDX-License-Identifier: MIT
//
// Sensitivities by power series.
//
//     const auto s = sensitivities(system, start, 3.0, Taylor{}, {.rtol = 1e-13, .atol = 1e-14});
//
// Lagrange's equations are differentiated along the motion, and their series made with the motion's (analysis/variations/variation_series.hpp).
//
// The steps, their tests and their dense output are those of integrate/taylor.hpp; events and saltation those of analysis/sensitivity.hpp.

#include <Eigen/Core>
#include <memory>
#include <string>
#include <type_traits>

#include "qdot/analysis/sensitivity.hpp"
#include "qdot/analysis/variations/recorder.hpp"
#include "qdot/analysis/variations/second_saltation.hpp"
#include "qdot/analysis/variations/variation_series.hpp"
#include "qdot/integrate/taylor.hpp"

namespace qdot::detail {

template <Changes changes>
struct is_recordable<VariationalForm<changes>> : std::true_type {};

/// The power series of a motion and of its derivatives.
template <Changes changes>
struct PowerSeriesOf<VariationalForm<changes>> {
  static std::unique_ptr<PowerSeries> of_one_formula(const VariationalForm<changes>& form, int highest_order) {
    return std::make_unique<VariationSeries<>>(form.equations(), highest_order);
  }
  static std::unique_ptr<PowerSeries> made(const VariationalForm<changes>& form, int highest_order) { return of_one_formula(form, highest_order); }
};

// What the series needs of a model.
template <class Model>
struct Preparation<Taylor, Model> {
  static constexpr bool takes_branches = false;
  static void prepare(Variations<Model>& equations) {
    attach_recorder(equations);
    equations.pairs_at = [&equations](const std::string& name, double t, const Eigen::VectorXd& both) -> std::unique_ptr<PairsBehind> {
      return std::make_unique<SecondSaltation<>>(equations, name, t, both);
    };
  }
};

}  // namespace qdot::detail
