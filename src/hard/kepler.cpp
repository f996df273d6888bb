// SPDX-License-Identifier: MIT
//
// Kepler ellipses. D1 … D5: T. Hull, W. Enright, B. Fellen, A. Sedgwick, Comparing numerical methods for ordinary differential
// equations (1972). The table of energy errors: SUNDIALS 7.5, example ark_kepler, method MCLACHLAN_4_4. The ends are the closed
// form E − e sin E = t, x = cos E − e, y = √(1 − e²) sin E, evaluated with 40 digits.
#include <cstdio>

#include "hard/motion.hpp"
#include "qdot/integrate/symplectic.hpp"
#include "qdot/integrate/taylor.hpp"

namespace qdot::hard {
namespace {

struct Kepler {
  auto T(const auto& v) const { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }
  auto V(const auto& q) const {
    using std::sqrt;
    return -1.0 / sqrt(q[0] * q[0] + q[1] * q[1]);
  }
};

struct Ellipse {
  const char* name;
  double e, t_end;
  double gain;  // relative: the nearest point is 1 − e, the farthest 1 + e
  double x, y, vx, vy;
};

constexpr Ellipse ellipses[] = {
    {"Kepler D1, e = 0.1", 0.1, 20, 60, 0.219883535200839661284947, 0.9427076846341813085211993, -0.9787659841058176514576667, 0.3287977990962036082625254},
    {"Kepler D2, e = 0.3", 0.3, 20, 60, -0.1777027357140411693319956, 0.9467784719905892580435366, -1.030294163192969574010956, 0.1211074890053952163348994},
    {"Kepler D3, e = 0.5", 0.5, 20, 60, -0.5780432953035361232751458, 0.8633840009194192801335731, -0.959508373038072735626449, -0.06504915126712090167719355},
    {"Kepler D4, e = 0.7", 0.7, 20, 90, -0.9538990293416394397392429, 0.690740902421943151698712, -0.8212674270877433094538376, -0.1539574259125824707993972},
    {"Kepler D5, e = 0.9", 0.9, 20, 280, -1.295266250987574367717139, 0.4003938963792321527297696, -0.6775390924707565887476366, -0.1270838154278686187668703},
    {"Kepler, e = 0.99", 0.99, 20, 2.8e3, -1.438132493154337110448681, 0.1261095858558247437103698, -0.6192404172999148556859457,
     -0.04378957260582536169138919},
    {"Kepler, e = 0.999", 0.999, 20, 2.8e4, -1.452085435535782060884368, 0.03985765249763959701663151, -0.6136907928983808225444341,
     -0.01394539395018451461151255},
    {"Kepler, e = 0.9, t = 50", 0.9, 50, 1.1e3, -0.3963843386276691560577371, -0.3765774030234645667675589, 1.58012671920874933503456,
     0.4015045664128602396797605},
    {"Kepler, e = 0.999, t = 50", 0.999, 50, 1.1e5, -0.6316456375183806277480687, -0.0415840894328477544896533, 1.469292208546569778629612,
     0.02594651148919511711044292},
};

// H(50) − H(0) as published; digits: how many of them our own H(50) − H(0) has.
struct EnergyError {
  double step, published, digits;
};
constexpr EnergyError energy_errors[] = {
    {0.1, -5.3723049984188975e-06, 6}, {0.05, -2.77646171387147e-07, 6}, {0.025, -1.725032383603775e-08, 6}};

std::vector<Row> rows() {
  const auto planet = mechanical_system<2>(Kepler{});
  const auto moving = motion(planet);
  std::vector<Row> rows;
  for (const Ellipse& o : ellipses) {
    const double root = std::sqrt((1 + o.e) * (1 - o.e));
    const Problem problem{.name = o.name,
                          .t_end = o.t_end,
                          .start = numbers({1 - o.e, 0.0, 0.0, root / (1 - o.e)}),
                          .exact = numbers({o.x, o.y, o.vx, o.vy}),
                          .reference_digits = 22,
                          .gain = o.gain};
    rows.push_back(solved(problem, moving, By::dop853, {.rtol = 2.5e-15, .atol = 1e-17}));
    rows.push_back(solved(problem, moving, planet, Taylor{}, "taylor, 2.5e-15", {.rtol = 2.5e-15, .atol = 1e-17}));
  }
  for (const EnergyError& known : energy_errors) {
    char name[64];
    std::snprintf(name, sizeof name, "Kepler e = 0.6, energy error at h = %g", known.step);
    const Problem problem{.name = name,
                          .t_end = 50,
                          .start = numbers({0.4, 0.0, 0.0, 2.0}),
                          .exact = numbers({known.published}),
                          .reference_digits = known.digits,
                          .best_published = "SUNDIALS SPRK, its own table",
                          .scale = numbers({std::abs(known.published)}),
                          .seen = [&](const State_& y) { return numbers({moving.energy(50, y) + 0.5}); }};
    rows.push_back(solved(problem, moving, planet, Splitting{.step = known.step, .scheme = SplittingScheme::mclachlan_atela_4},
                          "mclachlan_atela_4", {}));
  }
  return rows;
}

}  // namespace

Case kepler() {
  return {"kepler", "Kepler ellipses",
          "Eccentricities 0.1 to 0.9 are the DETEST problems D1 to D5; at 0.999 the speed changes by a factor of 2000 in each "
          "turn. With the steps of a published run of a symplectic method the error of its energy comes out to all digits that "
          "rounding leaves.",
          rows};
}

}  // namespace qdot::hard
