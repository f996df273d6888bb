// SPDX-License-Identifier: MIT
//
// Formulas against what the lecture and books have. Momenta, mass matrices and equations were derived by hand from T and V.
#include "qdot/report/equations.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "catch2_bridge.hpp"
#include "qdot/report/equation_text.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/heavy_top.hpp"
#include "scenes/kepler.hpp"
#include "scenes/rod_and_ring.hpp"
#include "scenes/spherical_pendulum.hpp"

namespace {

using namespace qdot;

template <class E, int n>
report::Equations equations_of_scene(const scenes::Scene<E, n>& scene, const E& energies = {}) {
  std::vector<std::string> names;
  std::vector<report::NamedParameter<E>> parameters;
  for (const auto& c : scene.coordinates(energies)) names.push_back(c.name);
  for (const auto& p : scene.parameters) parameters.push_back({p.name, std::get<double E::*>(p.member)});
  return equations(mechanical_system<n>(energies).with_names(names), parameters);
}

std::string plain(const report::Expression& e) { return text_of(e, report::PlainNotation{}); }
std::string latex(const report::Expression& e) { return text_of(e, report::LatexNotation{}); }

const std::string rod_and_ring_text = R"(Lagrangian
  L = ½ m (ṙ² + r² φ̇²) + ⅙ M L² φ̇² − g (m r + ½ M L) sin φ

Momenta
  p_r = m ṙ
  p_φ = (⅓ M L² + m r²) φ̇

Mass matrix
  M₁₁ = m
  M₂₂ = ⅓ M L² + m r²

Equations of motion
  r̈ = r φ̇² − g sin φ
  (⅓ M L² + m r²) φ̈ = −2 m r ṙ φ̇ − g (m r + ½ M L) cos φ

Accelerations
  r̈ = r φ̇² − g sin φ
  φ̈ = −(2 m r ṙ φ̇ + g (m r + ½ M L) cos φ)/(⅓ M L² + m r²)
)";

struct Pendulum {
  double m = 1.0, l = 1.0, g = 9.81;
  constexpr auto T(const auto& qdot) const { return 0.5 * m * l * l * qdot[0] * qdot[0]; }
  constexpr auto V(const auto& q) const {
    using std::cos;
    return -m * g * l * cos(q[0]);
  }
};

const std::vector<report::NamedParameter<Pendulum>> pendulum_parameters = {{"m", &Pendulum::m}, {"l", &Pendulum::l}, {"g", &Pendulum::g}};

}  // namespace

TEST_CASE("the rod with the ring has the lecture's equations") {
  // I_O = M L²/3:  r̈ = r φ̇² − g sin φ,  (I_O + m r²) φ̈ + 2 m r ṙ φ̇ + (m r + ½ M L) g cos φ = 0.
  CHECK(plain_text(equations_of_scene(scenes::rod_and_ring())) == rod_and_ring_text);
}

TEST_CASE("T and V alone are what one wrote") {
  const auto energies = report::energies_of(report::equation_source(mechanical_system<1>(Pendulum{}).with_names({"theta"}),
                                                                    {{"m", &Pendulum::m}, {"l", &Pendulum::l}, {"g", &Pendulum::g}}));
  REQUIRE(energies.size() == 2);
  CHECK(plain(energies[0].left) == "T");
  CHECK(plain(energies[0].right) == "½ m l² θ̇²");
  CHECK(plain(energies[1].left) == "V");
  CHECK(plain(energies[1].right) == "−m g l cos θ");
}

TEST_CASE("formulas do not depend on the values of parameters") {
  for (const scenes::RodAndRing values : {scenes::RodAndRing{1.0, 1.0, 1.0, 1.0}, scenes::RodAndRing{2.0, 2.0, 0.5, 4.0},
                                          scenes::RodAndRing{1e-3, 700.0, 3e5, 0.0},
                                          scenes::RodAndRing{0.0, 1.0, 1.0, 9.81}})
    CHECK(plain_text(equations_of_scene(scenes::rod_and_ring(), values)) == rod_and_ring_text);
}

TEST_CASE("a letter is seen beside one of quite another size") {
  const report::Equations e = equations_of_scene(scenes::double_pendulum(), scenes::DoublePendulum{.m1 = 6e24, .m2 = 1e-12});
  CHECK(plain(e.M[0][0]) == "(m₁ + m₂) l₁²");
}

TEST_CASE("the double pendulum has a book's equations") {
  const report::Equations e = equations_of_scene(scenes::double_pendulum());
  CHECK(plain(e.L) == "½ (m₁ + m₂) l₁² θ̇₁² + ½ m₂ l₂² θ̇₂² + m₂ l₁ l₂ θ̇₁ θ̇₂ cos(θ₁ − θ₂) + (m₁ + m₂) g l₁ cos θ₁ + m₂ g l₂ cos θ₂");
  CHECK(plain(e.p[0]) == "(m₁ + m₂) l₁² θ̇₁ + m₂ l₁ l₂ θ̇₂ cos(θ₁ − θ₂)");
  CHECK(plain(e.M[0][0]) == "(m₁ + m₂) l₁²");
  CHECK(plain(e.M[1][0]) == "m₂ l₁ l₂ cos(θ₁ − θ₂)");
  CHECK(plain(e.rows[0].left) == "(m₁ + m₂) l₁ θ̈₁ + m₂ l₂ θ̈₂ cos(θ₁ − θ₂)");
  CHECK(plain(e.rows[0].right) == "−m₂ l₂ θ̇₂² sin(θ₁ − θ₂) − (m₁ + m₂) g sin θ₁");
  CHECK(plain(e.rows[1].left) == "l₁ θ̈₁ cos(θ₁ − θ₂) + l₂ θ̈₂");
  CHECK(plain(e.rows[1].right) == "l₁ θ̇₁² sin(θ₁ − θ₂) − g sin θ₂");
  CHECK(plain(e.qddot[0].right) ==
        "(−m₂ l₁ θ̇₁² sin(θ₁ − θ₂) cos(θ₁ − θ₂) − m₂ l₂ θ̇₂² sin(θ₁ − θ₂) + g (−(m₁ + m₂) sin θ₁ + m₂ sin θ₂ cos(θ₁ − θ₂)))/(l₁ (m₁ + m₂ sin²(θ₁ − θ₂)))");
  CHECK(plain(e.qddot[1].right) == "(−l₁ θ̈₁ cos(θ₁ − θ₂) + l₁ θ̇₁² sin(θ₁ − θ₂) − g sin θ₂)/l₂");
}

TEST_CASE("Kepler's problem has a book's equations") {
  const report::Equations e = equations_of_scene(scenes::kepler());
  CHECK(plain(e.L) == "½ ẋ² + ½ ẏ² + μ/√(x² + y²)");
  CHECK(plain(e.M[1][1]) == "1");
  CHECK(plain(e.qddot[0].right) == "−μ x/(x² + y²)^(3/2)");
  CHECK(plain(e.qddot[1].right) == "−μ y/(x² + y²)^(3/2)");
}

TEST_CASE("the heavy top has a book's equations") {
  const report::Equations e = equations_of_scene(scenes::heavy_top());
  CHECK(plain(e.L) == "½ I₁ (θ̇² + φ̇² sin² θ) + ½ I₃ (φ̇ cos θ + ψ̇)² − m g l cos θ");
  CHECK(plain(e.p[1]) == "(I₁ sin² θ + I₃ cos² θ) φ̇ + I₃ ψ̇ cos θ");
  CHECK(plain(e.p[2]) == "I₃ φ̇ cos θ + I₃ ψ̇");
  CHECK(plain(e.rows[0].right) == "(I₁ − I₃) φ̇² sin θ cos θ − I₃ φ̇ ψ̇ sin θ + m g l sin θ");
  CHECK(plain(e.rows[1].left) == "(I₁ sin² θ + I₃ cos² θ) φ̈ + I₃ ψ̈ cos θ");
  CHECK(plain(e.rows[1].right) == "2 (I₃ − I₁) θ̇ φ̇ sin θ cos θ + I₃ θ̇ ψ̇ sin θ");
  CHECK(plain(e.rows[2].left) == "φ̈ cos θ + ψ̈");
  CHECK(plain(e.rows[2].right) == "θ̇ φ̇ sin θ");
  CHECK(plain(e.qddot[1].right) == "((I₃ − 2 I₁) θ̇ φ̇ cos θ + I₃ θ̇ ψ̇)/(I₁ sin θ)");
}

TEST_CASE("the spherical pendulum has a book's equations") {
  const report::Equations e = equations_of_scene(scenes::spherical_pendulum());
  CHECK(plain(e.L) == "½ m l² (θ̇² + φ̇² sin² θ) + m g l cos θ");
  CHECK(plain(e.p[1]) == "m l² φ̇ sin² θ");
  CHECK(plain(e.qddot[0].right) == "φ̇² sin θ cos θ − (g/l) sin θ");
  CHECK(plain(e.qddot[1].right) == "−2 θ̇ φ̇ cos θ/sin θ");
}

TEST_CASE("what has no name appears as its number, and coordinates as q₀, q₁") {
  const auto system = mechanical_system<1>(Pendulum{.m = 3.0, .l = 0.5});
  CHECK(plain(equations(system).L) == "⅜ q̇₀² + 14.715 cos q₀");
  CHECK(plain(equations(system, {{"m", &Pendulum::m}}).L) == "⅛ m q̇₀² + 4.905 m cos q₀");
  CHECK(plain(equations(system.with_names({"theta"}), pendulum_parameters).qddot[0].right) == "−(g/l) sin θ");
}

namespace {

// One over a sum, a root, sines, a parameter that does nothing, and others that can only be numbers.
struct Odd {
  double a = 1.0, b = 1.0, k = 4.0, alpha = 0.3, nothing = 5.0, beta = 2.5, c = 0.0;
  auto T(const auto& qdot) const { return 0.5 * qdot[0] * qdot[0] / (a + b); }
  auto V(const auto& q) const {
    using std::cos, std::exp, std::pow, std::sin;
    return std::sqrt(k * a) * sin(q[0]) - a * std::sin(alpha) * q[0] + c * q[0] * q[0] + pow(q[0], beta);
  }
};

}  // namespace

TEST_CASE("quotients, roots and sines of parameters are found, and what is none of these is a number") {
  const auto e = equations(mechanical_system<1>(Odd{}).with_names({"x"}), {{"a", &Odd::a}, {"b", &Odd::b}, {"k", &Odd::k},
                                                                           {"alpha", &Odd::alpha}, {"nothing", &Odd::nothing},
                                                                               {"beta", &Odd::beta}, {"c", &Odd::c}});
  CHECK(plain(e.M[0][0]) == "1/(a + b)");
  CHECK(plain(e.L) == "ẋ²/(2 (a + b)) − x^(5/2) − c x² + a x sin α − √a √k sin x");
}

namespace {

struct Decaying {
  double tau = 2.0, k = 3.0;
  auto T(const auto& qdot) const { return 0.5 * qdot[0] * qdot[0]; }
  auto V(const auto& q) const { return k * std::exp(-tau) * q[0] + 0.1234567890123 * q[0] * q[0]; }
};

}  // namespace

TEST_CASE("a parameter that enters in another way is a number, and those beside it stay letters") {
  const auto e = equations(mechanical_system<1>(Decaying{}).with_names({"width"}), {{"tau", &Decaying::tau}, {"k", &Decaying::k}});
  CHECK(plain(e.L).substr(0, 12) == "½ widtḣ²");
  CHECK(plain(e.L).find("0.13533528323661") != std::string::npos);  // exp(−2) = 0.1353352832366127
  CHECK(plain(e.L).find(" k width") != std::string::npos);
  CHECK(plain(e.L).find("0.1234567890123 width²") != std::string::npos);
}

TEST_CASE("a T that branches on the state has no equations") {
  const auto branches = mechanical_system<1>([](const auto& qdot) { return 0.5 * qdot[0] * qdot[0]; },
                                             [](const auto& q) {
                                               using S = std::decay_t<decltype(q[0])>;
                                               return q[0] > 0.0 ? S(q[0] * q[0]) : S(2.0 * q[0] * q[0]);
                                             });
  CHECK_THROWS_AS(equations(branches), NotAnalytic);
}

namespace {

struct DecidesByParameter {
  double m = 1.0, k = 1.0;
  auto T(const auto& qdot) const { return 0.5 * m * qdot[0] * qdot[0]; }
  auto V(const auto& q) const {
    using std::cos;
    using S = std::decay_t<decltype(q[0])>;
    return k > 1.0 ? S(k * q[0] * q[0]) : k < 1.0 ? S(k * cos(q[0])) : S(0.5 * q[0]);
  }
};

}  // namespace

TEST_CASE("operations that depend on a named parameter are refused, and written down when it is a number") {
  const auto system = mechanical_system<1>(DecidesByParameter{});
  CHECK_THROWS_AS(equations(system, {{"k", &DecidesByParameter::k}}), NotOneFormula);
  CHECK(plain(equations(system, {{"m", &DecidesByParameter::m}}).qddot[0].right) == "−1/(2 m)");
}

TEST_CASE("a kinetic energy that is no quadratic form has its derivatives") {
  // T = ½ v² + ¼ v⁴:  p = v + v³,  M = 1 + 3 v².
  const auto system = mechanical_system<1>([](const auto& qdot) { return 0.5 * qdot[0] * qdot[0] + 0.25 * qdot[0] * qdot[0] * qdot[0] * qdot[0]; },
                                           [](const auto& q) { return 0.5 * q[0] * q[0]; })
                          .with_names({"x"});
  const report::Equations e = equations(system);
  CHECK(plain(e.qddot[0].right) == "−x/(3 ẋ² + 1)");
}

TEST_CASE("formulas for LaTeX and MathML") {
  const report::Equations e = equations_of_scene(scenes::double_pendulum());
  CHECK(latex(e.M[1][0]) == "m_{2} l_{1} l_{2} \\cos \\left(\\theta_{1} - \\theta_{2}\\right)");
  CHECK(latex(e.rows[1].right) == "l_{1} \\dot{\\theta}_{1}^{2} \\sin \\left(\\theta_{1} - \\theta_{2}\\right) - g \\sin \\theta_{2}");
  const report::Equations pendulum = equations(mechanical_system<1>(Pendulum{}).with_names({"theta"}), pendulum_parameters);
  CHECK(latex_text(pendulum).find("  L &= \\frac{1}{2} m l^{2} \\dot{\\theta}^{2} + m g l \\cos \\theta\n") != std::string::npos);
  CHECK(latex(pendulum.qddot[0].right) == "-\\frac{g}{l} \\sin \\theta");
  CHECK(text_of(pendulum.p[0], report::MathmlNotation{}) ==
        "<mi>m</mi><mspace width=\"0.17em\"/><msup><mrow><mi>l</mi></mrow><mrow><mn>2</mn></mrow></msup><mspace width=\"0.17em\"/>"
        "<mover accent=\"true\"><mi>θ</mi><mo stretchy=\"false\">˙</mo></mover>");
  CHECK(text_of(e.M[0][0], report::MathmlNotation{}).find("<msubsup><mi>l</mi><mn>1</mn><mrow><mn>2</mn></mrow></msubsup>") != std::string::npos);
}
