// SPDX-License-Identifier: MIT
//
// The C file is compiled by the C compiler, without a warning, and compared with q̈ and its Jacobian from duals.
#include "qdot/report/c_code.hpp"

#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include "catch2_bridge.hpp"
#include "qdot/mechanics/acceleration_jacobian.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/report/number.hpp"
#include "scenes/bead_on_hoop.hpp"
#include "scenes/cartpole.hpp"
#include "scenes/chain.hpp"
#include "scenes/charged_particle.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/heavy_top.hpp"
#include "scenes/kepler.hpp"
#include "scenes/mathieu.hpp"
#include "scenes/morse.hpp"
#include "scenes/rod_and_ring.hpp"

namespace {

using namespace qdot;

// M of the systems below has a condition of at most 1e3; two ways to add up the same terms.
constexpr double rounding = 1e-10;

// C files of several systems with a program that prints what they return, and what is expected of it.
class CProgram {
 public:
  CProgram() {
    std::string pattern = (std::filesystem::temp_directory_path() / "qdot-c-test-XXXXXX").string();
    REQUIRE(mkdtemp(pattern.data()) != nullptr);
    folder_ = pattern;
  }
  CProgram(const CProgram&) = delete;
  CProgram& operator=(const CProgram&) = delete;
  ~CProgram() { std::filesystem::remove_all(folder_); }

  // At random states and values of the parameters, the file being made for those of `energies`.
  template <int n, class E>
  void add(const std::string& name, const E& energies, std::vector<std::string> coordinates, const std::vector<report::NamedParameter<E>>& parameters) {
    const auto dof = static_cast<Eigen::Index>(coordinates.size());
    std::ofstream(folder_ / (name + ".c")) << report::c_code(report::equation_source<n>(energies, coordinates, parameters), name);
    files_ += " " + name + ".c";
    calls_ += "int " + name + "_acceleration(const double *, const double *, double, const double *, double *);\n" + "int " + name +
              "_jacobian(const double *, const double *, double, const double *, double *, double *, double *);\nstatic void run_" + name + "(void) {\n";
    for (int trial = 0; trial < 4; ++trial) {
      E changed = energies;
      Eigen::VectorXd p(static_cast<Eigen::Index>(parameters.size()));
      for (std::size_t j = 0; j < parameters.size(); ++j) {
        double& value = changed.*parameters[j].member;
        if (trial > 0) value = value * random(0.6, 1.5) + (value == 0.0 ? random(0.1, 0.5) : 0.0);
        p[static_cast<Eigen::Index>(j)] = value;
      }
      Vector<double, n> q(dof), v(dof);
      for (Eigen::Index i = 0; i < dof; ++i) {
        q[i] = random(0.3, 1.3);
        v[i] = random(-1.0, 1.0);
      }
      const double t = random(0.0, 2.0);
      const auto system = [&] {
        if constexpr (n == Dynamic) {
          return mechanical_system(dof, changed);
        } else {
          return mechanical_system<n>(changed);
        }
      }();
      const auto a = acceleration(system, q, v, t);
      AccelerationJacobian<n> J;
      J.d_q.setZero(dof, dof);
      J.d_qdot.setZero(dof, dof);
      qdot::detail::jacobian_by_duals(system, q, v, t, J);
      for (Eigen::Index i = 0; i < dof; ++i) expected_.push_back(a[i]);
      for (Eigen::Index i = 0; i < dof; ++i) expected_.push_back(a[i]);
      for (Eigen::Index i = 0; i < dof; ++i)
        for (Eigen::Index j = 0; j < dof; ++j) expected_.push_back(J.d_q(i, j));
      for (Eigen::Index i = 0; i < dof; ++i)
        for (Eigen::Index j = 0; j < dof; ++j) expected_.push_back(J.d_qdot(i, j));
      const std::string size = std::to_string(dof), squared = std::to_string(dof * dof);
      calls_ += "  {\n    const double q[] = {" + listed(q) + "}, v[] = {" + listed(v) + "}, p[] = {" + listed(p) + "};\n    double a[" +
                size + "], dq[" + squared + "], dv[" + squared + "];\n    if (" + name + "_acceleration(q, v, " + report::exact_text(t) +
                ", p, a)) exit(1);\n    print(a, " + size + ");\n    if (" + name + "_jacobian(q, v, " + report::exact_text(t) +
                ", p, a, dq, dv)) exit(1);\n    print(a, " + size + ");\n    print(dq, " + squared + ");\n    print(dv, " + squared +
                ");\n  }\n";
    }
    calls_ += "}\n";
    main_ += "  run_" + name + "();\n";
  }

  template <class E, int n>
  void add_scene(const scenes::Scene<E, n>& scene) {
    const E energies{};
    std::vector<std::string> names;
    std::vector<report::NamedParameter<E>> parameters;
    for (const auto& c : scene.coordinates(energies)) names.push_back(c.name);
    for (const auto& p : scene.parameters)
      if (const auto* member = std::get_if<double E::*>(&p.member)) parameters.push_back({p.name, *member});
    this->template add<n>(scene.name, energies, names, parameters);
  }

  const std::vector<double>& expected() const { return expected_; }

  std::vector<double> returned() const {
    std::ofstream(folder_ / "main.c")
        << "#include <stdio.h>\n#include <stdlib.h>\nstatic void print(const double *x, int n) {\n  int i;\n  for (i = 0; i < n; ++i) "
           "printf(\"%.17g\\n\", x[i]);\n}\n"
        << calls_ << "int main(void) {\n"
        << main_ << "  return 0;\n}\n";
    const std::string folder = folder_.string();
    REQUIRE(std::system(("cd '" + folder + "' && cc -std=c99 -O1 -Wall -Wextra -pedantic -Werror main.c" + files_ + " -o main -lm").c_str()) == 0);
    REQUIRE(std::system(("cd '" + folder + "' && ./main > out").c_str()) == 0);
    std::ifstream in(folder_ / "out");
    std::vector<double> numbers;
    for (double x = 0.0; in >> x;) numbers.push_back(x);
    return numbers;
  }

 private:
  double random(double least, double most) { return std::uniform_real_distribution<double>(least, most)(engine_); }
  template <class X>
  static std::string listed(const X& x) {
    std::string text;
    for (Eigen::Index i = 0; i < x.size(); ++i) text += (i == 0 ? "" : ", ") + report::exact_text(x[i]);
    return text.empty() ? "0.0" : text;
  }

  std::filesystem::path folder_;
  std::string files_, calls_, main_;
  std::vector<double> expected_;
  std::mt19937 engine_{7};
};

// A kinetic energy that is no quadratic form, with a potential of the time, a quotient and functions of more than one name.
struct NoQuadraticForm {
  double m = 1.0, k = 1.0;
  auto T(const auto& q, const auto& qdot) const {
    using std::sqrt;
    return m * sqrt(1.0 + qdot[0] * qdot[0] + qdot[1] * qdot[1]) + 0.5 * k * qdot[1] * qdot[1] * (1.0 + q[0] * q[0]);
  }
  auto V(const auto& q, const auto& t) const {
    using std::atan2, std::exp, std::log, std::sin, std::tanh;
    return k * sin(t) * q[0] / (1.0 + q[1] * q[1]) + atan2(q[1], q[0]) + exp(-q[0]) * log(2.0 + q[1]) + tanh(m * q[1]);
  }
};

}  // namespace

TEST_CASE("the C file compiles without a warning and has q̈ and its Jacobian") {
  CProgram program;
  program.add_scene(scenes::double_pendulum());
  program.add_scene(scenes::heavy_top());
  program.add_scene(scenes::rod_and_ring());
  program.add_scene(scenes::kepler());
  program.add_scene(scenes::cartpole());
  program.add_scene(scenes::bead_on_hoop());
  program.add_scene(scenes::charged_particle());
  program.add_scene(scenes::mathieu());
  program.add_scene(scenes::morse());
  program.add_scene(scenes::chain());
  program.add<2>("no_quadratic_form", NoQuadraticForm{}, {"x", "y"}, {{"m", &NoQuadraticForm::m}, {"k", &NoQuadraticForm::k}});
  program.add<2>("numbers_only", NoQuadraticForm{}, {"x", "y"}, {});
  const std::vector<double> returned = program.returned();
  REQUIRE(returned.size() == program.expected().size());
  for (std::size_t i = 0; i < returned.size(); ++i) {
    INFO("number " << i);
    CHECK_THAT(returned[i], WithinAbs(program.expected()[i], rounding * (1.0 + std::abs(program.expected()[i]))));
  }
}
