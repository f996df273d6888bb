// SPDX-License-Identifier: MIT

#include "catch2_bridge.hpp"
#include "qdot/integrate/steps/spectral_radius.hpp"

using qdot::detail::SpectralRadius;

namespace {

// x″ = −ω² x − 2 ζ ω x′ for pairs of components, ω from 1 to `fastest`.
struct Oscillators {
  double fastest, zeta;

  double omega(Eigen::Index i, Eigen::Index n) const { return 1.0 + (fastest - 1.0) * static_cast<double>(i) / static_cast<double>(n - 1); }
  void derivative(const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> f) const {
    const Eigen::Index n = y.size() / 2;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double w = omega(i, n);
      f[i] = y[n + i];
      f[n + i] = -w * w * y[i] - 2 * zeta * w * y[n + i];
    }
  }
};

SpectralRadius radius_of(const Oscillators& o, Eigen::Index size) {
  const auto jacobian = [o](double, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::MatrixXd> J) {
    for (Eigen::Index j = 0; j < y.size(); ++j) o.derivative(Eigen::VectorXd::Unit(y.size(), j), J.col(j));
  };
  return SpectralRadius(size, jacobian, [o](double, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> f) { o.derivative(y, f); });
}

}  // namespace

TEST_CASE("the fastest of many oscillators is found without a matrix as it is with one, and so is its damping") {
  constexpr double some_percent = 0.1;  // twenty powers do not single out one of many
  for (const Eigen::Index size : {Eigen::Index(200), SpectralRadius::most_components + 2, Eigen::Index(20'000)}) {
    INFO(size);
    SpectralRadius radius = radius_of({50.0, 0.0}, size);
    const Eigen::VectorXd y = Eigen::VectorXd::Ones(size);
    CHECK_THAT(radius.at(0.0, y), WithinRel(50.0, some_percent));
    CHECK_THAT(radius.damping(), WithinAbs(0.0, some_percent));
    SpectralRadius damped = radius_of({50.0, 0.5}, size);
    CHECK_THAT(damped.at(0.0, y), WithinRel(50.0, some_percent));
    CHECK_THAT(damped.damping(), WithinAbs(0.5, some_percent));
  }
}
