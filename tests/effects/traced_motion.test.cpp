// SPDX-License-Identifier: MIT
//
// Equations of many coordinates that a run traces when it begins, beside closed forms, whole matrices and the general way.
#include <cmath>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/symplectic.hpp"
#include "qdot/mechanics/acceleration_jacobian.hpp"

using namespace qdot;

namespace {

constexpr double rounded = 1e-13;        // a few operations
constexpr double rounded_along = 1e-11;  // times the condition of M and of J M⁻¹ Jᵀ along a chain

// Masses on a line between two walls, with springs of force d + alpha d² between neighbours (E. Fermi, J. Pasta, S. Ulam).
struct Lattice {
  double alpha = 0.25;

  auto T(const auto& v) const {
    typename std::remove_cvref_t<decltype(v)>::Scalar sum(0.0);
    for (Eigen::Index i = 0; i < v.size(); ++i) sum += 0.5 * v[i] * v[i];
    return sum;
  }
  auto V(const auto& q) const {
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    S sum(0.0);
    for (Eigen::Index i = 0; i <= q.size(); ++i) {
      const S d = (i < q.size() ? q[i] : S(0.0)) - (i > 0 ? q[i - 1] : S(0.0));
      sum += 0.5 * d * d + alpha / 3.0 * d * d * d;
    }
    return sum;
  }
};

Eigen::VectorXd waves(Eigen::Index n, double phase) {
  Eigen::VectorXd x(n);
  for (Eigen::Index i = 0; i < n; ++i) x[i] = std::sin(phase + 2.3 * static_cast<double>(i));
  return x;
}

template <class Form>
Eigen::VectorXd rates(const Form& form, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, double t = 0.0) {
  Eigen::VectorXd y(2 * q.size()), ydot(2 * q.size());
  y << q, qdot;
  form.derivative(t, y, ydot);
  CHECK(ydot.head(q.size()) == qdot);
  return ydot.tail(q.size());
}

// Angles and lengths whose inertias depend on each other's, neighbours with neighbours, in a field that grows with time.
struct Neighbours {
  auto T(const auto& q, const auto& v) const {
    using std::cos;
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    S sum(0.0);
    for (Eigen::Index i = 0; i < v.size(); ++i) {
      sum += 0.5 * (2.0 + q[i] * q[i]) * v[i] * v[i];
      if (i > 0) sum += 0.3 * cos(q[i] - q[i - 1]) * v[i] * v[i - 1];
    }
    return sum;
  }
  auto V(const auto& q, const auto& t) const {
    using std::sin;
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    S sum(0.0);
    for (Eigen::Index i = 0; i < q.size(); ++i) sum += t * sin(q[i]) * (i > 0 ? S(q[i - 1]) : S(1.0));
    return sum;
  }
};

// Every operation that lines have, side by side for all coordinates, and coordinates that meet in no even step.
struct ManyOperations {
  auto T(const auto& q, const auto& v, const auto& t) const {
    using std::cos, std::pow;
    using S = typename std::remove_cvref_t<decltype(v)>::Scalar;
    S sum(0.0);
    for (Eigen::Index i = 0; i < v.size(); ++i) {
      const Eigen::Index other = (i * i + 1) % v.size();
      sum += 0.5 * v[i] * v[i] * (1.0 + pow(1.0 + q[i] * q[i], 1.5) + (2.0 + cos(q[i])) / (3.0 + q[other]) + t * t);
    }
    return sum;
  }
  auto V(const auto& q) const {
    using std::atan, std::cos, std::pow, std::sin, std::sqrt;
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    S sum(0.0);
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const Eigen::Index other = (3 * i * i + 2) % q.size();
      const double c = 0.1 * static_cast<double>(i % 5);
      const S u = 1.0 + q[i] * q[i], d = q[i] - c * q[other] + c;
      sum += sqrt(u) + pow(u, 2.5) + pow(u, 3.5) + 1.0 / (2.0 + q[i]) + sin(q[i]) * cos(q[other]) + atan(d) * d + q[i] / (3.0 + q[other]);
    }
    return sum;
  }
};

// A spring that is not there on one side: no formula.
struct OneSided {
  auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  auto V(const auto& q) const {
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    S sum(0.0);
    for (Eigen::Index i = 0; i < q.size(); ++i)
      if (q[i] > 0.0) sum += 0.5 * q[i] * q[i];
    return sum;
  }
};

struct Stiff {
  const double* k;
  auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  auto V(const auto& q) const { return 0.5 * *k * q.squaredNorm(); }
};

// Masses in a plane, neighbours of which share a part of their inertia where `coupled`, and rods of length one between pairs of them.
struct Points {
  double coupled = 0.0;
  auto T(const auto& v) const {
    typename std::remove_cvref_t<decltype(v)>::Scalar sum(0.0);
    for (Eigen::Index i = 0; i < v.size(); ++i) {
      sum += 0.5 * (1.0 + 0.1 * static_cast<double>(i % 7)) * v[i] * v[i];
      if (coupled != 0.0 && i > 1) sum += coupled * v[i] * v[i - 2];
    }
    return sum;
  }
  auto V(const auto& q) const {
    typename std::remove_cvref_t<decltype(q)>::Scalar sum(0.0);
    for (Eigen::Index i = 1; i < q.size(); i += 2) sum += 9.81 * q[i];
    return sum;
  }
};
struct Rods {
  std::vector<std::pair<int, int>> pairs;  // −1 is the origin
  auto operator()(const auto& q) const {
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    Vector<S, Dynamic> rows(static_cast<Eigen::Index>(pairs.size()));
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const auto [a, b] = pairs[i];
      const S dx = b < 0 ? q[2 * a] : q[2 * a] - q[2 * b], dy = b < 0 ? q[2 * a + 1] : q[2 * a + 1] - q[2 * b + 1];
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

auto scene_of(int m, double coupled, std::vector<std::pair<int, int>> pairs) {
  return scene(mechanical_system(2 * m, Points{coupled}), holonomic("rods", Rods{std::move(pairs)}),
               nonholonomic("blade",
                            [](const auto& q, const auto& v) {
                              using std::cos, std::sin;
                              return v[0] * sin(q[3]) - v[1] * cos(q[3]);
                            }),
               prescribed("drive", 4, [](const auto& t) { return 2.0 * t * t; }),
               viscous_damping(Eigen::VectorXd(Eigen::VectorXd::LinSpaced(2 * m, 0.1, 0.4))));
}

// The lower triangle of a square net's matrix, row by row: −1 for neighbours.
struct Net {
  std::vector<int> rows, columns;
  std::vector<double> values;
};
Net net_of(int side, const auto& diagonal_of_neighbours) {
  Net net;
  const auto add = [&](int row, int column, double value) {
    net.rows.push_back(row);
    net.columns.push_back(column);
    net.values.push_back(value);
  };
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const int k = i * side + j;
      if (i > 0) add(k, k - side, -1.0);
      if (j > 0) add(k, k - 1, -1.0);
      add(k, k, diagonal_of_neighbours((i > 0) + (j > 0) + (i + 1 < side) + (j + 1 < side)));
    }
  return net;
}

}  // namespace

TEST_CASE("masses on a line accelerate as the springs beside them pull, be they few or thousands") {
  for (const Eigen::Index n : {1, 2, 3, 50, 9000}) {
    const Eigen::VectorXd q = waves(n, 0.3), a = rates(first_order_form(mechanical_system(n, Lattice{})), q, waves(n, 1.0));
    double worst = 0.0;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double left = q[i] - (i > 0 ? q[i - 1] : 0.0), right = (i + 1 < n ? q[i + 1] : 0.0) - q[i];
      worst = std::max(worst, std::abs(a[i] - (right + 0.25 * right * right - left - 0.25 * left * left)));
    }
    CHECK(worst < rounded);
  }
}

TEST_CASE("traced equations with inertias that vary and time are those of nested duals") {
  const auto check = [](const auto& energies) {
    for (const Eigen::Index n : {1, 2, 3, 5, 60}) {
      const auto system = mechanical_system(n, energies);
      const Eigen::VectorXd q = waves(n, 0.7), v = waves(n, 2.0);
      const Eigen::MatrixXd M = detail::kinetic_hessian<Dynamic>(system.energies(), q, v, 1.3);
      const Eigen::VectorXd expected = M.llt().solve(detail::lagrange_rhs<Dynamic>(system.energies(), q, v, 1.3));
      CHECK((rates(first_order_form(system), q, v, 1.3) - expected).norm() < rounded_along * expected.norm());
    }
  };
  check(Neighbours{});
  check(ManyOperations{});
}

TEST_CASE("a form's Jacobian where inertias vary and meet is that of its accelerations") {
  const auto check = [](const auto& energies) {
    for (const Eigen::Index n : {2, 5}) {
      const auto system = mechanical_system(n, energies);
      const Eigen::VectorXd q = waves(n, 0.7), v = waves(n, 2.0);
      AccelerationJacobian<Dynamic> expected{q, Eigen::MatrixXd(n, n), Eigen::MatrixXd(n, n)};
      detail::jacobian_by_duals(system, q, v, 1.3, expected);  // acceleration_jacobian() would trace, too
      Eigen::VectorXd y(2 * n);
      y << q, v;
      Eigen::MatrixXd found(2 * n, 2 * n);
      first_order_form(system).jacobian(1.3, y, found);
      CHECK((found.bottomLeftCorner(n, n) - expected.d_q).norm() < rounded_along * expected.d_q.norm());
      CHECK((found.bottomRightCorner(n, n) - expected.d_qdot).norm() < rounded_along * expected.d_qdot.norm());
    }
  };
  check(Neighbours{});
  check(ManyOperations{});
}

TEST_CASE("energies that ask whether a coordinate has a certain value are asked there") {
  // Pulls three times as strongly at zero as anywhere else.
  const auto V = [](const auto& q) {
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    S sum(0.0);
    for (Eigen::Index i = 0; i < q.size(); ++i) sum += q[i] == 0.0 ? S(3.0 * q[i]) : S(q[i]);
    return sum;
  };
  const auto form = first_order_form(mechanical_system(3, [](const auto& v) { return 0.5 * v.squaredNorm(); }, V));
  const Eigen::VectorXd v = waves(3, 0.1);
  CHECK((rates(form, Eigen::Vector3d(0.4, -0.2, 0.7), v) - Eigen::Vector3d(-1.0, -1.0, -1.0)).norm() < rounded);
  CHECK((rates(form, Eigen::Vector3d(0.4, 0.0, 0.7), v) - Eigen::Vector3d(-1.0, -3.0, -1.0)).norm() < rounded);
}

TEST_CASE("what is no formula is evaluated as it is") {
  const Eigen::VectorXd q = waves(40, 0.5);
  const Eigen::VectorXd a = rates(first_order_form(mechanical_system(40, OneSided{})), q, waves(40, 1.0));
  CHECK((a + q.cwiseMax(0.0)).norm() < rounded);
}

TEST_CASE("a form keeps what it has traced until a method begins anew, and copies work by themselves") {
  double k = 2.0;
  auto form = first_order_form(mechanical_system(3, Stiff{&k}));
  const Eigen::VectorXd q = waves(3, 0.4), v = waves(3, 0.1);
  CHECK((rates(form, q, v) + 2.0 * q).norm() < rounded);
  auto copy = form;
  k = 5.0;
  copy.renew();
  CHECK((rates(copy, q, v) + 5.0 * q).norm() < rounded);
  CHECK((rates(form, q, v) + 2.0 * q).norm() < rounded);
  form.renew();
  CHECK((rates(form, q, v) + 5.0 * q).norm() < rounded);
}

TEST_CASE("traced accelerations on many constraints are those of the whole matrices") {
  constexpr int m = 12;
  auto ring = chain_of(m), shuffled = chain_of(m);
  ring.push_back({m - 1, 0});
  for (auto& [a, b] : shuffled) {
    a = 7 * a % m;
    b = b < 0 ? b : 7 * b % m;
  }
  for (const auto& pairs : {chain_of(m), ring, shuffled})
    for (const double coupled : {0.0, 0.1}) {
      CAPTURE(pairs.size(), coupled);
      const auto s = scene_of(m, coupled, pairs);
      const Eigen::VectorXd q = waves(2 * m, 0.2), v = waves(2 * m, 1.1);
      const auto rows = constraint_rows(s, q, v, 0.6);
      const Eigen::MatrixXd M = detail::kinetic_hessian<Dynamic>(s.system().energies(), q, v, 0.6);
      const Eigen::VectorXd f = detail::lagrange_rhs<Dynamic>(s.system().energies(), q, v, 0.6) + effect_forces(s, q, v, Vector<double, 0>(), 0.6);
      const Eigen::LLT<Eigen::MatrixXd> inertia(M);
      const Eigen::MatrixXd W = inertia.solve(rows.J.transpose());
      const Eigen::VectorXd lambda = (rows.J * W).ldlt().solve(rows.gamma - rows.J * inertia.solve(f)), expected = inertia.solve(f) + W * lambda;
      CHECK((rates(first_order_form(s), q, v, 0.6) - expected).norm() < rounded_along * expected.norm());
    }
}

TEST_CASE("rows that say what others say change no motion, and of the multipliers the shortest are taken") {
  // Rods twice, and three times, beside the orthogonal decomposition of the general way.
  constexpr int m = 12;
  auto pairs = chain_of(m);
  for (const int k : {3, 7, 7}) pairs.push_back({k, k - 1});
  const auto once = scene(mechanical_system(2 * m, Points{}), holonomic("rods", Rods{chain_of(m)}));
  const auto s = scene(mechanical_system(2 * m, Points{}), holonomic("rods", Rods{pairs}));
  const Eigen::VectorXd q = waves(2 * m, 0.2), v = waves(2 * m, 1.1);
  const auto form = first_order_form(s);
  CHECK((rates(form, q, v) - rates(first_order_form(once), q, v)).norm() < rounded_along * rates(form, q, v).norm());
  Eigen::VectorXd y(4 * m), lambda;
  y << q, v;
  const Eigen::VectorXd force = form.constraint_forces(0.0, y, lambda);
  const auto general = constrained_acceleration(s, q, v);
  CHECK(general.rank == m);
  CHECK((lambda - general.lambda).norm() < rounded_along * general.lambda.norm());
  CHECK((force - reactions(s, q, v)).norm() < rounded_along * force.norm());
  CHECK_THAT(lambda[7], WithinRel(lambda[m + 1], rounded_along));
  CHECK_THAT(lambda[7], WithinRel(lambda[m + 2], rounded_along));
  const auto at_odds = scene(mechanical_system(2 * m, Points{}), holonomic("rods", Rods{chain_of(m)}),
                             holonomic("again", [](const auto& x, const auto& t) { return Rods{{{3, 2}}}(x)[0] + t * t; }));
  Eigen::VectorXd ydot(4 * m);
  CHECK_THROWS_AS(first_order_form(at_odds).derivative(0.0, y, ydot), ConstraintError);
}

TEST_CASE("a thousand rods and one of them twice move as a thousand rods do") {
  constexpr int m = 1000;
  State<Dynamic> start{0.0, Eigen::VectorXd::Zero(2 * m), Eigen::VectorXd::Zero(2 * m)};
  for (int k = 0; k < m; ++k) start.q[2 * k] = k + 1;
  const auto end_of = [&](std::vector<std::pair<int, int>> pairs) {
    const auto run = simulate(scene(mechanical_system(2 * m, Points{}), holonomic("rods", Rods{std::move(pairs)})), start, 0.02, Dop853{},
                              {.rtol = 1e-8, .atol = 1e-8, .keep_trajectory = false});
    REQUIRE(run.completed());
    return run.y;
  };
  auto twice = chain_of(m);
  twice.push_back({m / 2, m / 2 - 1});
  CHECK((end_of(twice) - end_of(chain_of(m))).norm() < 1e-9);
}

TEST_CASE("a net that nothing holds has one zero, along its elimination tree and within a skyline") {
  // Springs between neighbours only: constants are null vectors, and b must have no mean.
  for (const int side : {6, 40}) {
    const auto [rows, columns, values] = net_of(side, [](int neighbours) { return static_cast<double>(neighbours); });
    const auto n = static_cast<std::size_t>(side * side);
    detail::PatternFactors<double> factors(n, rows, columns);
    const auto value = [&all = values](std::size_t k) { return all[k]; };
    CHECK_FALSE(factors.compute(value, 1e-10));
    REQUIRE(factors.compute(value, 1e-10, 1e-12));
    REQUIRE(factors.zeros() == 1);
    Eigen::VectorXd null(n), x = waves(static_cast<Eigen::Index>(n), 0.4), b = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(n));
    factors.null_vector(0, null.data());
    CHECK((null.array() / null[0] - 1.0).abs().maxCoeff() < rounded_along);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      b[rows[k]] += values[k] * x[columns[k]];
      if (rows[k] != columns[k]) b[columns[k]] += values[k] * x[rows[k]];
    }
    Eigen::VectorXd found = b;
    CHECK(factors.solve(found.data()) < rounded_along);
    CHECK(((found - x).array() - (found - x)[0]).abs().maxCoeff() < rounded_along);
    found = b.array() + 1.0;
    CHECK(factors.solve(found.data()) > 1.0);
  }
}

TEST_CASE("a matrix of a net is solved along its elimination tree, and a pivot that is not positive refused") {
  constexpr int side = 40;
  auto [rows, columns, values] = net_of(side, [](int) { return 5.0; });  // springs on a floor
  const Eigen::VectorXd x = waves(side * side, 0.9);
  Eigen::VectorXd b = 5.0 * x;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (rows[k] == columns[k]) continue;
    b[rows[k]] -= x[columns[k]];
    b[columns[k]] -= x[rows[k]];
  }
  detail::PatternFactors<double> factors(side * side, rows, columns);
  const auto value = [&all = values](std::size_t k) { return all[k]; };
  for (int time = 0; time < 2; ++time) {
    Eigen::VectorXd found = b;
    REQUIRE(factors.compute(value, 1e-10));
    factors.solve(found.data());
    CHECK((found - x).cwiseAbs().maxCoeff() < rounded);
  }
  values[values.size() / 2] = values[values.size() / 2 + 1] = -5.0;
  CHECK_FALSE(factors.compute(value, 1e-10));
}

TEST_CASE("the longest wave of ten thousand masses swings as the dispersion relation says") {
  // qₖ = sin(kπ/(n+1)) cos ωt with ω = 2 sin(π/(2(n+1))), where springs are linear.
  constexpr Eigen::Index n = 10'000;
  const double angle = 3.14159265358979323846 / static_cast<double>(n + 1), omega = 2.0 * std::sin(0.5 * angle);
  State<Dynamic> start{0.0, Eigen::VectorXd(n), Eigen::VectorXd::Zero(n)};
  for (Eigen::Index k = 0; k < n; ++k) start.q[k] = std::sin(angle * static_cast<double>(k + 1));
  const auto run = simulate(mechanical_system(n, Lattice{0.0}), start, 3.0, Splitting{.step = 0.25}, {.keep_trajectory = false});
  REQUIRE(run.completed());
  CHECK((run.state().q - std::cos(omega * 3.0) * start.q).cwiseAbs().maxCoeff() < 1e-12);  // rounding of 130 kicks
}

TEST_CASE("a chain of two hundred rods keeps its rods and its energy") {
  constexpr int m = 200;
  State<Dynamic> start{0.0, Eigen::VectorXd(2 * m), Eigen::VectorXd::Zero(2 * m)};
  double x = 0.0, y = 0.0;
  for (int k = 0; k < m; ++k) {
    start.q[2 * k] = x += std::sin(0.3 + 0.8 * std::sin(0.3 * k));
    start.q[2 * k + 1] = y -= std::cos(0.3 + 0.8 * std::sin(0.3 * k));
  }
  const auto s = scene(mechanical_system(2 * m, Points{}), holonomic("rods", Rods{chain_of(m)}));
  const auto run = simulate(s, start, 0.2, Dop853{}, {.rtol = 1e-10, .atol = 1e-10, .keep_trajectory = false});
  REQUIRE(run.completed());
  const State<Dynamic> end = run.state();
  CHECK(constraint_residual(s, end.q, 0.0).cwiseAbs().maxCoeff() < 1e-12);
  CHECK(std::abs(energy(s, end.q, end.qdot) - energy(s, start.q, start.qdot)) < 1e-9 * 9.81 * m * m);
}

TEST_CASE("where T or V has no value traced equations have none either, though their slopes are numbers there") {
  const auto refuses = [](const auto& V, double inside, double outside) {
    const auto T = [](const auto& v) { return 0.5 * v.squaredNorm(); };
    const auto form = first_order_form(mechanical_system(2, T, V));
    const Eigen::VectorXd v = waves(2, 0.1);
    CHECK(std::isfinite(rates(form, Eigen::VectorXd::Constant(2, inside), v)[0]));
    CHECK_THROWS_AS(rates(form, Eigen::VectorXd::Constant(2, outside), v), NonFinite);
  };
  refuses([](const auto& q) { using std::log; return log(q[0]) + q[1]; }, 0.5, -0.5);
  refuses([](const auto& q) { using std::sqrt; const auto r = sqrt(q[0]); return r * r * q[1]; }, 0.5, -0.5);
  refuses([](const auto& q) { using std::log1p; return log1p(q[0]) + q[1]; }, -0.5, -1.5);
  refuses([](const auto& q) { using std::atanh; return atanh(q[0]) + q[1]; }, -0.5, -1.5);
}
