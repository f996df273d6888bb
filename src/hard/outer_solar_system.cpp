// SPDX-License-Identifier: MIT
//
// Sun and outer planets, data of 5 September 1994: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, I.2. The
// Sun includes the inner planets. Units: au, day, mass of the Sun. The ends are computed with 34 digits.
#include <array>

#include "hard/motion.hpp"
#include "qdot/integrate/symplectic.hpp"
#include "qdot/integrate/taylor.hpp"

namespace qdot::hard {
namespace {

// Sun, Jupiter, Saturn, Uranus, Neptune, Pluto; q = [x₀, y₀, z₀, x₁, …].
struct OuterSolarSystem {
  double G = 2.95912208286e-4;
  std::array<double, 6> m{1.00000597682, 0.000954786104043, 0.000285583733151, 0.0000437273164546, 0.0000517759138449, 1 / 1.3e8};

  auto T(const auto& v) const {
    using S = typename std::decay_t<decltype(v)>::Scalar;
    S sum(0.0);
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t k = 3 * i; k < 3 * i + 3; ++k) {
        const auto& vk = v[static_cast<Eigen::Index>(k)];
        sum += 0.5 * m[i] * vk * vk;
      }
    return sum;
  }
  auto V(const auto& q) const {
    using std::sqrt;
    using S = typename std::decay_t<decltype(q)>::Scalar;
    S sum(0.0);
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const auto a = static_cast<Eigen::Index>(3 * i), b = static_cast<Eigen::Index>(3 * j);
        const S x = q[a] - q[b], y = q[a + 1] - q[b + 1], z = q[a + 2] - q[b + 2];
        sum -= G * m[i] * m[j] / sqrt(x * x + y * y + z * z);
      }
    return sum;
  }
};

struct End {
  double days;
  std::array<double, 36> y;
};

constexpr End ends[] = {
    {100000, {0.619722401185814339064,     -0.248363615627137748745,    -0.124506814901228669870,    -0.610628869461067861838,
              -5.00713163362849984541,     -2.13358895878921788117,     0.415465729416684764416,     8.07275879029446921962,
              3.32516606986878726097,      19.2801760075389575309,      6.37185933736760779883,      2.51151105187669757535,
              -29.3244107410754931134,     3.35566363371027688621,      2.09638657864203619117,      14.1213534320245025708,
              -28.7115263314356316422,     -13.0795885592859016475,     1.01748471220306156027e-06,  -1.20024429732624599201e-06,
              -6.06759131500880584436e-07, 0.00725782831625425618542,   -0.00121948946847327144115,  -0.000698166248716652312699,
              -0.00587536133396188330222,  -0.000226551552021069314455, 0.000161534641214180548144,  -0.00142572670652411263064,
              0.00318627608319111536852,   0.00141538106030273474902,   -0.000446540586756124201503, -0.00286474490603772099480,
              -0.00116149298053786217185,  0.00296078224734364581532,   0.000888003613149124430325,  -0.000613556668032031278568}},
    {200000, {1.23584254235460872737,      -0.489943821144274976368,    -0.246105361814321309984,    2.61107957011286336008,
              -5.07952549678798696378,     -2.24472067785305724453,     -7.66913624739130925882,     -4.05205224548782579501,
              -1.33111566971138146955,     -5.82474394984774333204,     15.3371737535725233566,      6.78246340991760848755,
              20.6639802475150217571,      20.5829560424598647451,      7.89479541474820208994,      36.5669506988226043798,
              -13.7676844012596252561,     -15.0434692218232634938,     -9.13437558160805593219e-07, -3.23773810609486842297e-06,
              -1.40208020312682091032e-06, 0.00717887892837593309574,   0.00223357952607029696154,   0.000783748342939310854466,
              0.00184479095624671797942,   -0.00477280688348918954567,  -0.00205657904992824701371,  -0.00365895005716157568335,
              -0.00155480383369646557104,  -0.000629514555304219439399, -0.00239287456607262225600,  0.00189046968181190516602,
              0.000833321369757217755340,  0.00162992924842464538867,   0.00210801156027823037867,   0.000168504842994416934047}},
    {500000, {3.08411847338068351725,      -1.22772635658164376834,    -0.616253763464722939118,   7.76658408679979147324,
              0.253106575457020728437,     -0.0941057140192970857722,  -5.56496716284378310001,    1.67484974082257131429,
              0.976723206953538477948,     19.6389957289520592061,     8.95850455228672766064,     3.61183915705746699379,
              24.9357087030514903378,      17.6951867615373278750,     6.58378516454936174956,     31.7859251137570608446,
              38.6361895816067606102,      3.19279416973316146763,     9.41737970303187596098e-06, -7.85525623824825419597e-06,
              -3.64692631323019922853e-06, -0.00249550320192019475008, 0.00689646719447231287161,  0.00300795024747376429448,
              -0.00225533593535236407863,  -0.00490591385477095873654, -0.00193847364171663891643, -0.00218617023116800316743,
              0.00281717701211062938752,   0.00126288263918116779229,  -0.00214872870589519517221, 0.00212865007763575838379,
              0.000924850141166281755835,  -0.00167517318622942607163, 0.00101183332038862273080,  0.000823180003857649264533}},
};

std::vector<Row> rows() {
  const auto planets = mechanical_system<18>(OuterSolarSystem{});
  const auto moving = motion(planets);
  const Eigen::VectorXd start = numbers({
      0, 0, 0, -3.5023653, -3.8169847, -1.5507963,
      9.0755314, -3.0458353, -1.6483708, 8.310142, -16.2901086, -7.2521278,
      11.4707666, -25.7294829, -10.8169456, -15.5387357, -25.2225594, -3.1902382,
      0, 0, 0, 0.00565429, -0.0041249, -0.00190589,
      0.00168318, 0.00483525, 0.00192462, 0.00354178, 0.00137102, 0.00055029,
      0.0028893, 0.00114527, 0.00039677, 0.00276725, -0.00170702, -0.00136504});
  std::vector<Row> rows;
  for (const End& end : ends) {
    // A phase error of Jupiter, 2π/4332.6 per day, after a relative error of its start: three times the angle that it has run.
    const Problem problem{.name = "outer planets, " + std::to_string(static_cast<int>(end.days)) + " days",
                          .t_end = end.days,
                          .start = start,
                          .exact = Eigen::Map<const Eigen::VectorXd>(end.y.data(), 36),
                          .reference_digits = 20,
                          .gain = 3 * 0.00145 * end.days};
    rows.push_back(solved(problem, moving, By::dop853, {.rtol = 2.5e-15, .atol = 1e-18}));
    rows.push_back(solved(problem, moving, planets, Splitting{.step = 20, .scheme = SplittingScheme::kahan_li_8}, "kahan_li_8, h = 20 d", {}));
    rows.push_back(solved(problem, moving, planets, Taylor{}, "taylor, 2.5e-15", {.rtol = 2.5e-15, .atol = 1e-18}));
  }
  return rows;
}

}  // namespace

Case outer_solar_system() {
  return {"outer_solar_system", "Outer solar system",
          "Six bodies over 100 000 to 500 000 days, 115 turns of Jupiter. The book prints pictures only; the reference has 20 "
          "digits. An integrator with a bias gains or loses energy steadily and Jupiter's place with it.",
          rows};
}

}  // namespace qdot::hard
