// SPDX-License-Identifier: MIT
//
// Many constraints, each of which touches few coordinates: point masses joined by rods of length one.
#include "qdot/effects/rows/sparse_solve.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

using namespace qdot;

namespace {

constexpr double rounded = 1e-12;  // times the condition of M and of J M⁻¹ Jᵀ

// Masses mᵢ in a plane at (xᵢ, yᵢ), in places that `x` and `y` number; in `coupled` ones, neighbours share a fifth of their inertia.
struct Points {
  int count;
  bool apart = false, coupled = false;  // apart: x₁ … xₘ y₁ … yₘ

  Eigen::Index x(int k) const { return apart ? k : 2 * k; }
  Eigen::Index y(int k) const { return apart ? count + k : 2 * k + 1; }
  double mass(int k) const { return 1.0 + 0.5 * std::sin(3.0 * k); }
  auto T(const auto& v) const {
    typename std::remove_cvref_t<decltype(v)>::Scalar sum(0.0);
    for (int k = 0; k < count; ++k) {
      sum += 0.5 * mass(k) * (v[x(k)] * v[x(k)] + v[y(k)] * v[y(k)]);
      if (coupled && k > 0) sum += 0.1 * (v[x(k)] * v[x(k - 1)] + v[y(k)] * v[y(k - 1)]);
    }
    return sum;
  }
  auto V(const auto& q) const {
    typename std::remove_cvref_t<decltype(q)>::Scalar sum(0.0);
    for (int k = 0; k < count; ++k) sum += 9.81 * mass(k) * q[y(k)];
    return sum;
  }
};

// ½(|r_a − r_b|² − 1) = 0 for pairs a, b; point −1 is the origin.
struct Rods {
  Points points;
  std::vector<std::pair<int, int>> pairs;

  auto operator()(const auto& q) const {
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    Vector<S, Dynamic> rows(static_cast<Eigen::Index>(pairs.size()));
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const auto [a, b] = pairs[i];
      const S dx = b < 0 ? q[points.x(a)] : q[points.x(a)] - q[points.x(b)], dy = b < 0 ? q[points.y(a)] : q[points.y(a)] - q[points.y(b)];
      rows[static_cast<Eigen::Index>(i)] = 0.5 * (dx * dx + dy * dy - 1.0);
    }
    return rows;
  }
};

std::vector<std::pair<int, int>> chain_of(int m) {
  std::vector<std::pair<int, int>> pairs;
  for (int k = 0; k < m; ++k) pairs.push_back({k, k - 1});
  return pairs;
}

// Loops of four rods, one upon the other: points 2k and 2k + 1 are the ends of rung k, the first of which hangs by one rod.
std::vector<std::pair<int, int>> ladder_of(int loops) {
  std::vector<std::pair<int, int>> pairs{{0, -1}, {1, 0}};
  for (int k = 1; k <= loops; ++k) {
    pairs.push_back({2 * k, 2 * k - 2});
    pairs.push_back({2 * k + 1, 2 * k - 1});
    pairs.push_back({2 * k + 1, 2 * k});
  }
  return pairs;
}

auto scene_of(const Points& points, const std::vector<std::pair<int, int>>& pairs) {
  return scene(mechanical_system(2 * points.count, points), holonomic("rods", Rods{points, pairs}));
}

// A crooked hanging chain, and velocities that are none of its motion.
State<Dynamic> crooked(const Points& points) {
  State<Dynamic> state{0.0, Eigen::VectorXd(2 * points.count), Eigen::VectorXd(2 * points.count)};
  double x = 0.0, y = 0.0;
  for (int k = 0; k < points.count; ++k) {
    state.q[points.x(k)] = x += std::sin(0.3 + 0.8 * std::sin(0.3 * k));
    state.q[points.y(k)] = y -= std::cos(0.3 + 0.8 * std::sin(0.3 * k));
    state.qdot[points.x(k)] = std::sin(1.0 + k);
    state.qdot[points.y(k)] = std::cos(2.0 * k);
  }
  return state;
}

// Rounding, times the length of the sums along a chain.
constexpr double rounded_along = 1e-11;

template <class Sc>
void check_whole(const Sc& s, const State<Dynamic>& at) {
  const auto solution = constrained_acceleration(s, at.q, at.qdot);
  const auto rows = constraint_rows(s, at.q, at.qdot, 0.0);
  const Eigen::MatrixXd M = detail::kinetic_hessian<Dynamic>(s.system().energies(), at.q, at.qdot, 0.0);
  const Eigen::VectorXd f = detail::lagrange_rhs<Dynamic>(s.system().energies(), at.q, at.qdot, 0.0);
  const Eigen::LLT<Eigen::MatrixXd> inertia(M);
  const Eigen::MatrixXd W = inertia.solve(rows.J.transpose());
  const Eigen::VectorXd lambda = (rows.J * W).ldlt().solve(rows.gamma - rows.J * inertia.solve(f));
  const Eigen::VectorXd qddot = inertia.solve(f) + W * lambda;
  CHECK(solution.rank == rows.J.rows());
  CHECK((solution.lambda - lambda).norm() < rounded_along * lambda.norm());
  CHECK((solution.qddot - qddot).norm() < rounded_along * (1.0 + qddot.norm()));
  detail::SparseSystem sparse;  // and the dense way was not asked
  CHECK(sparse.compute(s, at.q, at.qdot, 0.0, detail::NoPhases{}, default_rank_cutoff));
}

}  // namespace

TEST_CASE("a hanging chain accelerates as its tridiagonal equations of tensions say") {
  // rₖ = uₖ along rod k, |uₖ| = 1:  uₖ·(r̈ₖ − r̈ₖ₋₁) = −|u̇ₖ|²,  mₖ r̈ₖ = λₖ uₖ − λₖ₊₁ uₖ₊₁ − mₖ g.
  for (const int m : {10, 40}) {
    const Points points{m};
    const State<Dynamic> at = crooked(points);
    Eigen::VectorXd ux(m), uy(m), diagonal(m), below(m), lambda(m);
    for (int k = 0; k < m; ++k) {
      const auto difference = [&](const Eigen::VectorXd& x, int i) { return x[i] - (k > 0 ? x[i - 2] : 0.0); };
      ux[k] = difference(at.q, 2 * k);
      uy[k] = difference(at.q, 2 * k + 1);
      const double vx = difference(at.qdot, 2 * k), vy = difference(at.qdot, 2 * k + 1), last = k > 0 ? 1.0 / points.mass(k - 1) : 0.0;
      diagonal[k] = last + 1.0 / points.mass(k);
      lambda[k] = -(vx * vx + vy * vy) + (k > 0 ? 0.0 : 9.81 * uy[0]);
      below[k] = k > 0 ? -last * (ux[k] * ux[k - 1] + uy[k] * uy[k - 1]) : 0.0;
      if (k == 0) continue;
      const double factor = below[k] / diagonal[k - 1];
      diagonal[k] -= factor * below[k];
      lambda[k] -= factor * lambda[k - 1];
    }
    for (int k = m; k-- > 0;) lambda[k] = (lambda[k] - (k + 1 < m ? below[k + 1] * lambda[k + 1] : 0.0)) / diagonal[k];
    const auto found = constrained_acceleration(scene_of(points, chain_of(m)), at.q, at.qdot);
    double worst = 0.0, most = 0.0;
    for (int k = 0; k < m; ++k) {
      const bool more = k + 1 < m;
      worst = std::max({worst, std::abs(found.lambda[k] - lambda[k]),
                        std::abs(points.mass(k) * found.qddot[2 * k] - lambda[k] * ux[k] + (more ? lambda[k + 1] * ux[k + 1] : 0.0)),
                        std::abs(points.mass(k) * (found.qddot[2 * k + 1] + 9.81) - lambda[k] * uy[k] + (more ? lambda[k + 1] * uy[k + 1] : 0.0))});
      most = std::max(most, std::abs(lambda[k]));
    }
    CHECK(worst < rounded_along * most);
  }
}

TEST_CASE("many constraints give what the whole matrices give, however coordinates are numbered and coupled") {
  for (const int m : {10, 26})
    for (const bool apart : {false, true})
      for (const bool coupled : {false, true}) {
        CAPTURE(m, apart, coupled);
        const Points points{m, apart, coupled};
        check_whole(scene_of(points, chain_of(m)), crooked(points));
        check_whole(scene_of(points, ladder_of(m / 2 - 1)), crooked(points));
        auto ring = chain_of(m);
        ring.push_back({m - 1, 0});
        check_whole(scene_of(points, ring), crooked(points));
        auto shuffled = chain_of(m);  // the same rods in another order
        for (int k = 0; k < m; ++k) shuffled[static_cast<std::size_t>(k)] = {7 * k % (m + (m % 7 == 0 ? 1 : 0)), 7 * k % (m + (m % 7 == 0 ? 1 : 0)) - 1};
        check_whole(scene_of(points, shuffled), crooked(points));
        // Points that are numbered at random, and a drive and a blade beside the rods.
        auto mixed = ring;
        for (auto& [a, b] : mixed) {
          a = 7 * a % (m + (m % 7 == 0 ? 1 : 0));
          b = b < 0 ? b : 7 * b % (m + (m % 7 == 0 ? 1 : 0));
        }
        const auto s = scene(mechanical_system(2 * m, points), holonomic("rods", Rods{points, mixed}),
                             nonholonomic("blade", [](const auto& q, const auto& v) {
                               using std::cos, std::sin;
                               return v[0] * sin(q[3]) - v[1] * cos(q[3]);
                             }),
                             prescribed("drive", 4, [](const auto& t) { return 2.0 * t * t; }));
        check_whole(s, crooked(points));
      }
}

TEST_CASE("rows of few and of many coordinates, that branch, ask for nothing or are out of action are those of forward derivatives, at any state") {
  const Points points{20};
  const auto path = [](const auto& q) {  // each place is made long before its row, and from all before it
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    using std::sin, std::sqrt;
    Vector<S, Dynamic> place(q.size()), rows(q.size() / 8);
    for (Eigen::Index i = 0; i < q.size(); ++i) place[i] = (i == 0 ? S(1.0) : S(place[i - 1] * 0.9)) + sin(q[i]) * q[(i + 3) % q.size()];
    for (Eigen::Index k = 0; k < rows.size(); ++k) rows[k] = place[8 * k] * place[8 * k] / sqrt(1.0 + q[8 * k + 1] * q[8 * k + 1]) - place[k] + q[k];
    return rows;
  };
  const auto s = scene(mechanical_system(40, points), holonomic("path", path),
                       holonomic("together", [](const auto& q, const auto& t) {
                         auto sum = q[0] * t;
                         for (Eigen::Index i = 1; i < q.size(); ++i) sum += q[i] * q[i] * t;
                         return sum;
                       }),
                       holonomic("here or there", [](const auto& q) { return q[3] > 0.0 ? q[0] * q[5] : q[39] - q[1]; }),
                       holonomic("nothing", [](const auto& q) {
                         using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
                         return Vector<S, 3>(S(1.0), S(q[2] - q[2]), S(0.0));
                       }),
                       contact("wall", [](const auto& q) { return q[4] * q[7]; }), contact("floor", [](const auto& q) { return q[5] - q[8]; }),
                       nonholonomic("blade", [](const auto& q, const auto& v, const auto& t) { return v[1] * q[2] - t * v[30] * q[1] + q[7]; }));
  for (int trial = 0; trial < 10; ++trial) {
    Eigen::VectorXd q(40), qdot(40);
    for (int i = 0; i < 40; ++i) {
      q[i] = std::sin(1.0 + 7.0 * i + 3.0 * trial);
      qdot[i] = std::cos(2.0 + 5.0 * i + trial);
    }
    auto z = s.initial_states();
    z[0] = static_cast<double>(trial % 2 == 0 ? ContactPhase::closed : ContactPhase::apart);
    z[1] = static_cast<double>(trial % 3 == 0 ? ContactPhase::closed : ContactPhase::apart);
    detail::SparseRows found;
    REQUIRE(detail::write_sparse_rows(s, q, qdot, 0.7, z, found));
    const Eigen::MatrixXd expected = constraint_jacobian(s, q, qdot, 0.7, z);
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(expected.rows(), expected.cols());
    REQUIRE(static_cast<Eigen::Index>(found.size()) == J.rows());
    for (std::size_t i = 0; i < found.size(); ++i)
      for (const auto* e = found.begin(i); e != found.end(i); ++e) {
        CHECK(J(static_cast<Eigen::Index>(i), e->column) == 0.0);  // each entry once
        J(static_cast<Eigen::Index>(i), e->column) = e->value;
      }
    CHECK((J - expected).cwiseAbs().maxCoeff() < rounded * expected.cwiseAbs().maxCoeff());
  }
}

TEST_CASE("among many constraints, those that depend on each other are found and those that contradict each other named") {
  const Points points{40};
  const State<Dynamic> at = crooked(points);
  auto twice = chain_of(40);
  twice.push_back({20, 19});
  const auto once = constrained_acceleration(scene_of(points, chain_of(40)), at.q, at.qdot);
  const auto solution = constrained_acceleration(scene_of(points, twice), at.q, at.qdot);
  CHECK(solution.rank == 40);
  CHECK((solution.qddot - once.qddot).norm() < rounded_along * once.qddot.norm());
  CHECK(std::abs(solution.lambda[20] - 0.5 * once.lambda[20]) < rounded_along * once.lambda.norm());
  CHECK(std::abs(solution.lambda[40] - solution.lambda[20]) < rounded_along * once.lambda.norm());

  const auto torn = scene(mechanical_system(80, points), holonomic("rods", Rods{points, chain_of(40)}),
                          holonomic("here", [](const auto& q) { return q[30] - 1.0; }),
                          holonomic("there", [](const auto& q, const auto& t) { return q[30] - 1.0 - t * t; }));
  try {
    constrained_acceleration(torn, at.q, at.qdot);
    FAIL("a point cannot stand still and accelerate");
  } catch (const ConstraintError& e) {
    CHECK((e.constraint() == "here" || e.constraint() == "there"));
    CHECK(std::string(e.what()).find("only 41 of 42 are independent") != std::string::npos);
  }
}

TEST_CASE("projection of many constraints arrives on all of them, and redundant rows change nothing") {
  const Points points{40};
  State<Dynamic> rough = crooked(points);
  for (Eigen::Index i = 0; i < rough.q.size(); ++i) rough.q[i] += 1e-3 * std::sin(7.0 * static_cast<double>(i));
  auto twice = chain_of(40);
  twice.push_back({20, 19});
  const auto s = scene_of(points, chain_of(40));
  const auto once = consistent_state(s, rough), redundant = consistent_state(scene_of(points, twice), rough);
  CHECK(constraint_residual(s, once.state.q, 0.0).cwiseAbs().maxCoeff() < rounded);
  CHECK(constraint_velocity(s, once.state.q, once.state.qdot, 0.0).cwiseAbs().maxCoeff() < rounded);
  CHECK(once.report.rank == 40);
  CHECK(redundant.report.rank == 40);
  CHECK((once.state.q - redundant.state.q).norm() < rounded_along);
  CHECK((once.state.qdot - redundant.state.qdot).norm() < rounded_along);
  // The way back is shortest: M (q − q*) is a combination of the rows of J, and no more.
  const Eigen::MatrixXd J = constraint_jacobian(s, once.state.q, once.state.qdot, 0.0);
  const Eigen::VectorXd push = mass_matrix(s, once.state.q, once.state.qdot) * (once.state.qdot - rough.qdot);
  CHECK((J.transpose() * (J * J.transpose()).ldlt().solve(J * push) - push).norm() < rounded_along * push.norm());
}

TEST_CASE("the Jacobian of many constraints is that of the whole equations, a direction at a time") {
  using D = Dual<double, 1>;
  for (const bool coupled : {false, true}) {
    const Points points{10, coupled, coupled};
    const State<Dynamic> at = crooked(points);
    const auto s = scene(mechanical_system(20, points), holonomic("rods", Rods{points, ladder_of(4)}),
                         nonholonomic("blade", [](const auto& q, const auto& v) {
                           using std::cos, std::sin;
                           return v[18] * sin(q[3]) - v[19] * cos(q[3]);
                         }),
                         viscous_damping(Eigen::VectorXd(Eigen::VectorXd::LinSpaced(20, 0.1, 0.4))));
    const auto form = first_order_form(s);
    Eigen::MatrixXd found(40, 40);
    form.jacobian(0.0, form.packed(at), found);

    const auto solution = constrained_acceleration(s, at.q, at.qdot);
    const Eigen::Index rows = solution.lambda.size();
    const Eigen::MatrixXd J = constraint_jacobian(s, at.q, at.qdot, 0.0);
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(20 + rows, 20 + rows), right(20 + rows, 40);
    K.topLeftCorner(20, 20) = detail::kinetic_hessian<Dynamic>(s.system().energies(), at.q, at.qdot, 0.0);
    K.topRightCorner(20, rows) = -J.transpose();
    K.bottomLeftCorner(rows, 20) = J;
    const Vector<D, Dynamic> fixed = detail::constants<D>(solution.qddot);
    for (int j = 0; j < 40; ++j) {
      Vector<D, Dynamic> x = detail::constants<D>(at.q), v = detail::constants<D>(at.qdot);
      (j < 20 ? x[j] : v[j - 20]).tangent[0] = 1.0;
      Vector<D, Dynamic> r = -detail::lagrange_residual<Dynamic>(s.system().energies(), x, v, fixed, D(0.0));
      r += effect_forces(s, x, v, Vector<D, 0>(), D(0.0));
      const auto moved = constraint_jacobian(s, x, v, D(0.0));
      const auto c = constraint_acceleration(s, x, v, fixed, D(0.0));
      for (int i = 0; i < 20; ++i) {
        D sum = r[i];
        for (Eigen::Index k = 0; k < rows; ++k) sum += moved(k, i) * solution.lambda[k];
        right(i, j) = sum.tangent[0];
      }
      for (Eigen::Index k = 0; k < rows; ++k) right(20 + k, j) = -c[k].tangent[0];
    }
    const Eigen::MatrixXd expected = K.fullPivLu().solve(right).topRows(20);
    CHECK((found.bottomRows(20) - expected).cwiseAbs().maxCoeff() < rounded_along * expected.cwiseAbs().maxCoeff());
  }
}

TEST_CASE("a chain of forty rods keeps its energy and its rods for a second") {
  const Points points{40};
  State<Dynamic> start = crooked(points);
  start.qdot.setZero();
  const auto s = scene_of(points, chain_of(40));
  start = consistent_state(s, start).state;
  const auto run = simulate(s, start, 1.0, Dop853{}, {.rtol = 1e-10, .atol = 1e-10, .keep_trajectory = false});
  REQUIRE(run.completed());
  const State<Dynamic> end = run.state();
  CHECK(constraint_residual(s, end.q, 0.0).cwiseAbs().maxCoeff() < 1e-12);
  CHECK(constraint_velocity(s, end.q, end.qdot, 0.0).cwiseAbs().maxCoeff() < 1e-11);
  const double fell = 9.81 * 40.0 * 40.0;  // the size of V
  CHECK(std::abs(energy(s, end.q, end.qdot) - energy(s, start.q, start.qdot)) < 1e-9 * fell);
}
