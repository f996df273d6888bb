// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "../catch2_bridge.hpp"
#include "accurate_scenes.hpp"
#include "qdot/integrate/simulate_to_accuracy.hpp"
#include "qdot/integrate/cvode.hpp"

namespace {

using namespace qdot;

// y₀ and y₁ turn; y₂ is drawn to y₀ a thousand times as fast: y₂ = cos t + e^{−1000 t} from y₂(0) = 2.
struct Drawn {
  static constexpr int size_at_compile_time = 3;
  Eigen::Index size() const { return 3; }
  void derivative(double, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot) const {
    ydot << -y[1], y[0], -1000 * (y[2] - y[0]) - y[1];
  }
  void jacobian(double, const Eigen::Ref<const Eigen::VectorXd>&, Eigen::Ref<Eigen::MatrixXd> J) const {
    J << 0, -1, 0, 1, 0, 0, 1000, -1, -1000;
  }
  std::string component_name(Eigen::Index i) const { return "y" + std::to_string(i); }
};

TEST_CASE("a stiff system is as accurate as asked with multistep methods, whose orders vary") {
  std::vector<double> times;
  for (int k = 0; k <= 40; ++k) times.push_back(0.25 * k);
  for (const double accuracy : {1e-3, 1e-6, 1e-9}) {
    const auto result = simulate_to_accuracy(Drawn{}, FirstOrderState{0.0, Eigen::Vector3d(1, 0, 2)}, 10.0, CvodeBdf{}, accuracy,
                                             {.output_times = times, .keep_trajectory = false});
    double error = 0;
    for (std::size_t k = 0; k < times.size(); ++k) {
      const double t = times[k];
      const Eigen::Vector3d exact(std::cos(t), std::sin(t), std::cos(t) + std::exp(-1000 * t)), sizes(1, 1, 2);
      error = std::max(error, (result.run.samples.y.col(static_cast<Eigen::Index>(k)) - exact).cwiseQuotient(sizes).cwiseAbs().maxCoeff());
    }
    INFO("accuracy " << accuracy << ": error " << error << ", estimate " << result.error_estimate << ", runs " << result.trials.size());
    CHECK(result.reached());
    CHECK(error <= accuracy);
    CHECK(error <= 3 * result.error_estimate);
    CHECK(result.evaluations < 40'000);
  }
}

TEST_CASE("multistep methods, which err alike at neighbouring tolerances, are not believed too much") {
  for (const accurate_scenes::Scene& scene : accurate_scenes::all()) {
    if (!scene.name.starts_with("Kepler") && scene.name != "double pendulum, t = 10") continue;
    const auto times = accurate_scenes::equal_times(scene.t_end, 50);
    const Eigen::MatrixXd exact = accurate_scenes::columns(scene.exact(times));
    const Eigen::VectorXd sizes = exact.cwiseAbs().rowwise().maxCoeff();
    const FirstOrderState start{0.0, Eigen::Map<const Eigen::VectorXd>(scene.start.data(), sizes.size())};
    for (const double accuracy : {1e-6, 1e-9}) {
      const auto result = simulate_to_accuracy(scene.equations, start, scene.t_end, CvodeAdams{}, accuracy,
                                               {.output_times = times, .keep_trajectory = false});
      const Eigen::ArrayXXd errors = (result.run.samples.y - exact).cwiseAbs().array().colwise() / sizes.array();
      const double error = errors.maxCoeff();
      INFO(scene.name << ", accuracy " << accuracy << ": error " << error << ", estimate " << result.error_estimate);
      CHECK(error <= 3 * result.error_estimate);
      CHECK((result.reached() || accuracy == 1e-9));
    }
  }
}

}  // namespace
