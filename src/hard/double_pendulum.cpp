// SPDX-License-Identifier: MIT
//
// Two point masses on massless rods, four starts: A of the Matplotlib example gallery, B of the SciML tutorials, C horizontal,
// D almost upright. No end state with many digits is published; these are computed with 34 digits, the gains with them.
#include <algorithm>
#include <numbers>

#include "hard/motion.hpp"
#include "qdot/integrate/taylor.hpp"

namespace qdot::hard {
namespace {

struct DoublePendulum {
  double g = 9.81;

  auto T(const auto& q, const auto& v) const {
    using std::cos;
    return v[0] * v[0] + 0.5 * v[1] * v[1] + v[0] * v[1] * cos(q[0] - q[1]);
  }
  auto V(const auto& q) const {
    using std::cos;
    return -g * (2.0 * cos(q[0]) + cos(q[1]));
  }
};

struct End {
  const char* name;
  double t, digits, gain;
  double th1, th2, w1, w2;
};

std::vector<Row> rows() {
  constexpr double pi = std::numbers::pi;
  struct Start {
    double g;
    Eigen::Vector4d y;
    std::vector<End> ends;
  };
  const std::vector<Start> starts = {
      {9.8, {2 * pi / 3, -pi / 18, 0, 0},
       {{"double pendulum A, t = 5", 5, 22, 350, -0.4402197453666647639997, 7.049578950150240234173, -3.521138978320260164927, -3.908828177773745031439},
        {"double pendulum A, t = 10", 10, 20, 5.8e4, -0.792596116598799467317, -2.46949450975927190551, -1.97580988134385348853, -2.38063119314081752009},
        {"double pendulum A, t = 20", 20, 16, 4.8e8, -0.53173856363171093, -5.0143052310773216, 4.5244572603089531, 1.2158028455607090}}},
      {9.81, {0, 0, pi / 3, 3 * pi / 5},
       {{"double pendulum B, t = 10", 10, 22, 5.5, -0.5212429195041411384897, -0.6846043940751413372145, -0.1241850489630702346562, -0.09262062157604153344269},
        {"double pendulum B, t = 50", 50, 22, 5.5, -0.4713741877282114512482, -0.6447259154111232948053, -0.5831683065489362423833,
         -0.4867963993660360366765}}},
      {9.81, {pi / 2, pi / 2, 0, 0},
       {{"double pendulum C, t = 5", 5, 22, 13, -0.6271867050665307301381, -1.301315550209811677908, 2.125408673842910650651, 3.881888727265607439255},
        {"double pendulum C, t = 10", 10, 21, 140, -0.5684746640159501887761, -0.5263937279324046983296, 6.078384885761964854825, -9.681360681708878758077},
        {"double pendulum C, t = 20", 20, 18, 9.4e5, 0.7487609754791818265, -25.83246199889377678, 4.078003969275087781, 2.779889455386669743},
        {"double pendulum C, t = 30", 30, 11, 3.5e11, -0.513503778932, -19.4190547250, 6.62972343586, -9.19064851206}}},
      {9.81, {pi - 1e-3, pi - 1e-3, 0, 0},
       {{"double pendulum D, t = 5", 5, 20, 7.1e3, -8.54973764608096108982, 2.64871929314845623297, 1.08743899256804384817, -3.97499594915760661210},
        {"double pendulum D, t = 10", 10, 20, 8.7e5, 9.61659387294183397269, 11.9685848391335398039, 3.90120296517591293993, 6.44345471001179707519}}}};
  std::vector<Row> rows;
  for (const Start& start : starts) {
    const auto pendulum = mechanical_system<2>(DoublePendulum{start.g}).with_names({"th1", "th2"});
    const auto moving = motion(pendulum);
    for (const End& end : start.ends) {
      const double angle = std::max({std::abs(end.th1), std::abs(end.th2), start.y.head<2>().cwiseAbs().maxCoeff()});
      const double rate = std::max({std::abs(end.w1), std::abs(end.w2), start.y.tail<2>().cwiseAbs().maxCoeff()});
      const Problem problem{.name = end.name,
                            .t_end = end.t,
                            .start = start.y,
                            .exact = numbers({end.th1, end.th2, end.w1, end.w2}),
                            .reference_digits = end.digits,
                            .gain = end.gain,
                            .scale = numbers({angle, angle, rate, rate})};
      rows.push_back(solved(problem, moving, By::dop853, {.rtol = 2.5e-15, .atol = 1e-16}));
      rows.push_back(solved(problem, moving, pendulum, Taylor{}, "taylor, 2.5e-15", {.rtol = 2.5e-15, .atol = 1e-16}));
    }
  }
  return rows;
}

}  // namespace

Case double_pendulum() {
  return {"double_pendulum", "Double pendulum",
          "M depends on q, and the motion is chaotic: at t = 30 of start C an error has grown 3.5·10¹¹ times, so that no double "
          "precision run can have more than four digits there. Start B is regular and shows that the same code keeps all digits.",
          rows};
}

}  // namespace qdot::hard
