#pragma once
// SPDX-License-Identifier: MIT
//
// Random trees of bodies, three times: as places of bodies (the kinematic door), as T and V (the general door), and by Newton's and
// Euler's equations from link to link in long double (Luh, Walker and Paul 1980; Featherstone, Rigid Body Dynamics Algorithms,
// ch. 5), which know nothing of energies or dual numbers.
//
// Body i hangs on body p by a joint at a fixed place j of p and turns about, or slides along, the axis a, fixed in p:
//
//     turning   o = o_p + R_p j,              R = R_p turn(a, q)
//     sliding   o = o_p + R_p (j + a q),      R = R_p
//
// and its centre of mass is at o + R c. A spring k (q − q₀) acts in each joint, gravity on each body.

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/ad/dual_math.hpp"
#include "qdot/ad/vector.hpp"
#include "qdot/mechanics/velocity.hpp"

namespace fuzz {

using Real = long double;
using Reals = std::vector<Real>;

struct Body {
  int parent = -1;
  bool slides = false;
  Eigen::Vector3d axis, joint, centre;
  double mass = 1.0;
  Eigen::Matrix3d inertia;  // about the centre, along the body's axes
  double spring = 0.0, rest = 0.0;
};

struct Tree {
  std::vector<Body> bodies;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
};

using Random = std::mt19937_64;
inline double uniform(Random& random, double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }

/// A random tree: in space, or in the plane with its axes along z.
inline Tree random_tree(Random& random, int n, bool planar, bool springs) {
  const auto vector = [&](double size) {
    Eigen::Vector3d r(uniform(random, -size, size), uniform(random, -size, size), uniform(random, -size, size));
    if (planar) r[2] = 0.0;
    return r;
  };
  Tree tree;
  tree.gravity = vector(10.0);
  for (int i = 0; i < n; ++i) {
    Body b;
    b.parent = std::uniform_int_distribution<int>(-1, i - 1)(random);
    b.slides = random() % 4 == 0;
    do b.axis = planar && !b.slides ? Eigen::Vector3d(0, 0, random() % 2 == 0 ? 1 : -1) : vector(1.0);
    while (b.axis.norm() < 0.2);
    b.axis /= b.axis.norm();
    b.joint = vector(1.0);
    b.centre = vector(1.0);
    b.mass = std::exp(uniform(random, -2.0, 2.0));
    b.inertia.setZero();
    for (int k = 0; k < 4; ++k) {  // of four points, so that it is one of a body
      const Eigen::Vector3d r(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
      b.inertia += 0.25 * b.mass * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
    }
    if (springs) b.spring = uniform(random, 0.0, 20.0), b.rest = uniform(random, -1.0, 1.0);
    tree.bodies.push_back(b);
  }
  return tree;
}

// ── vectors of any scalar, written out ─────────────────────────────────────────────────────────

template <class S>
using V3 = std::array<S, 3>;
template <class S>
using M3 = std::array<V3<S>, 3>;

template <class S, class A, class B>
V3<S> sum(const A& a, const B& b) {
  return {S(a[0] + b[0]), S(a[1] + b[1]), S(a[2] + b[2])};
}
template <class S, class A, class B>
V3<S> cross(const A& a, const B& b) {
  return {S(a[1] * b[2] - a[2] * b[1]), S(a[2] * b[0] - a[0] * b[2]), S(a[0] * b[1] - a[1] * b[0])};
}
template <class S, class A>
V3<S> scaled(const A& a, const S& by) {
  return {S(a[0] * by), S(a[1] * by), S(a[2] * by)};
}
template <class S, class A>
V3<S> turned(const M3<S>& R, const A& a) {
  return {S(R[0][0] * a[0] + R[0][1] * a[1] + R[0][2] * a[2]), S(R[1][0] * a[0] + R[1][1] * a[1] + R[1][2] * a[2]),
          S(R[2][0] * a[0] + R[2][1] * a[1] + R[2][2] * a[2])};
}
template <class S, class A>
V3<S> turned_back(const M3<S>& R, const A& a) {
  return {S(R[0][0] * a[0] + R[1][0] * a[1] + R[2][0] * a[2]), S(R[0][1] * a[0] + R[1][1] * a[1] + R[2][1] * a[2]),
          S(R[0][2] * a[0] + R[1][2] * a[1] + R[2][2] * a[2])};
}

/// R turned further about a body axis: R (cos E + sin [a×] + (1 − cos) a aᵀ).
template <class S>
M3<S> turned_about(const M3<S>& R, const Eigen::Vector3d& a, const S& angle) {
  using std::cos, std::sin;
  const S c = cos(angle), s = sin(angle), rest = S(1.0) - c;
  M3<S> turn;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t k = 3 - i - j;
      const double outer = a[static_cast<Eigen::Index>(i)] * a[static_cast<Eigen::Index>(j)];
      turn[i][j] = i == j ? S(c + rest * outer)
                          : S(rest * outer + s * ((j == (i + 1) % 3 ? -1.0 : 1.0) * a[static_cast<Eigen::Index>(k)]));
    }
  M3<S> result;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) result[i][j] = R[i][0] * turn[0][j] + R[i][1] * turn[1][j] + R[i][2] * turn[2][j];
  return result;
}

template <class S>
struct Frame {
  M3<S> R;
  V3<S> origin;
};
template <class S>
Frame<S> ground() {
  const S zero(0.0), one(1.0);
  return {{V3<S>{one, zero, zero}, V3<S>{zero, one, zero}, V3<S>{zero, zero, one}}, {zero, zero, zero}};
}

template <class S>
Frame<S> hung(const Body& b, const Frame<S>& parent, const S& q) {
  if (!b.slides) return {turned_about(parent.R, b.axis, q), sum<S>(parent.origin, turned(parent.R, b.joint))};
  return {parent.R, sum<S>(parent.origin, turned(parent.R, sum<S>(scaled<S>(b.axis, q), b.joint)))};
}

// ── the two doors of the library ───────────────────────────────────────────────────────────────

template <class S, class Q>
S potential_of(const Tree& tree, const Q& q) {
  using Index = std::conditional_t<std::is_same_v<Q, Reals>, std::size_t, Eigen::Index>;
  std::vector<Frame<S>> frames;
  S V(0.0);
  for (std::size_t i = 0; i < tree.bodies.size(); ++i) {
    const Body& b = tree.bodies[i];
    const S x = q[static_cast<Index>(i)];
    frames.push_back(hung<S>(b, b.parent < 0 ? ground<S>() : frames[static_cast<std::size_t>(b.parent)], x));
    const V3<S> r = sum<S>(frames[i].origin, turned(frames[i].R, b.centre));
    V = V - b.mass * (tree.gravity[0] * r[0] + tree.gravity[1] * r[1] + tree.gravity[2] * r[2]);
    V = V + 0.5 * b.spring * ((x - b.rest) * (x - b.rest));
  }
  return V;
}

/// place(q, bodies) for kinematic_system().
struct Places {
  Tree tree;
  bool planar = false;

  void operator()(const auto& q, auto& bodies) const {
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    std::vector<Frame<S>> frames;
    std::vector<S> angles;
    for (std::size_t i = 0; i < tree.bodies.size(); ++i) {
      const Body& b = tree.bodies[i];
      const S x = q[static_cast<Eigen::Index>(i)];
      frames.push_back(hung<S>(b, b.parent < 0 ? ground<S>() : frames[static_cast<std::size_t>(b.parent)], x));
      const V3<S> r = sum<S>(frames[i].origin, turned(frames[i].R, b.centre));
      if (planar) {
        const S before = b.parent < 0 ? S(0.0) : angles[static_cast<std::size_t>(b.parent)];
        angles.push_back(b.slides ? before : S(before + b.axis[2] * x));
        bodies.planar_body(b.mass, b.inertia(2, 2), qdot::vector(r[0], r[1]), angles.back());
      } else {
        qdot::Matrix<S, 3> R;
        for (Eigen::Index k = 0; k < 3; ++k)
          for (Eigen::Index l = 0; l < 3; ++l) R(k, l) = frames[i].R[static_cast<std::size_t>(k)][static_cast<std::size_t>(l)];
        bodies.rigid_body(b.mass, b.inertia, qdot::vector(r[0], r[1], r[2]), R);
      }
    }
  }
};

/// V(q) beside the places.
struct Potential {
  Tree tree;
  auto operator()(const auto& q) const { return potential_of<typename std::remove_cvref_t<decltype(q)>::Scalar>(tree, q); }
};

/// T(q, q̇) by velocities from body to body, and V.
struct Energies {
  Tree tree;

  template <class S, int n>
  S T(const qdot::Vector<S, n>& q, const qdot::Vector<S, n>& v) const {
    struct Moving {
      Frame<S> frame;
      V3<S> velocity, omega;
    };
    const S zero(0.0);
    std::vector<Moving> all;
    S twice(0.0);
    for (std::size_t i = 0; i < tree.bodies.size(); ++i) {
      const Body& b = tree.bodies[i];
      const auto k = static_cast<Eigen::Index>(i);
      const Moving parent = b.parent < 0 ? Moving{ground<S>(), {zero, zero, zero}, {zero, zero, zero}} : all[static_cast<std::size_t>(b.parent)];
      Moving m{hung<S>(b, parent.frame, q[k]), parent.velocity, parent.omega};
      const V3<S> own = scaled<S>(turned(parent.frame.R, b.axis), v[k]);
      const V3<S> arm = sum<S>(m.frame.origin, scaled<S>(parent.frame.origin, S(-1.0)));
      m.velocity = sum<S>(parent.velocity, cross<S>(parent.omega, arm));
      (b.slides ? m.velocity : m.omega) = sum<S>(b.slides ? m.velocity : m.omega, own);
      const V3<S> c = sum<S>(m.velocity, cross<S>(m.omega, turned(m.frame.R, b.centre)));
      const V3<S> W = turned_back(m.frame.R, m.omega);
      twice = twice + b.mass * (c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
      for (Eigen::Index r = 0; r < 3; ++r)
        for (Eigen::Index s = 0; s < 3; ++s) twice = twice + b.inertia(r, s) * (W[static_cast<std::size_t>(r)] * W[static_cast<std::size_t>(s)]);
      all.push_back(m);
    }
    return 0.5 * twice;
  }
  template <class S, int n>
  S V(const qdot::Vector<S, n>& q) const {
    return potential_of<S>(tree, q);
  }
};

// ── Newton and Euler ───────────────────────────────────────────────────────────────────────────

/// The joint forces that accelerations a need: M a − rhs. Without weight and springs where `bare`.
inline Reals joint_forces(const Tree& tree, const Reals& q, const Reals& v, const Reals& a, bool bare = false) {
  using X = V3<Real>;
  struct Link {
    Frame<Real> frame;
    X omega{}, alpha{}, acceleration{}, axis{}, force{}, moment{};
  };
  const auto times = [](const X& x, Real by) { return scaled<Real>(x, by); };
  const auto plus = [](const X& x, const X& y) { return sum<Real>(x, y); };
  const auto swept = [](const X& x, const X& y) { return cross<Real>(x, y); };
  std::vector<Link> links;
  for (std::size_t i = 0; i < tree.bodies.size(); ++i) {
    const Body& b = tree.bodies[i];
    Link parent;
    parent.frame = ground<Real>();
    if (b.parent >= 0) parent = links[static_cast<std::size_t>(b.parent)];
    Link l = parent;
    l.force = l.moment = {};
    l.frame = hung<Real>(b, parent.frame, q[i]);
    l.axis = turned(parent.frame.R, b.axis);
    const X arm = plus(l.frame.origin, times(parent.frame.origin, -1));
    l.acceleration = plus(parent.acceleration, plus(swept(parent.alpha, arm), swept(parent.omega, swept(parent.omega, arm))));
    if (b.slides) {
      l.acceleration = plus(l.acceleration, plus(times(l.axis, a[i]), times(swept(parent.omega, l.axis), 2 * v[i])));
    } else {
      l.alpha = plus(parent.alpha, plus(times(l.axis, a[i]), times(swept(parent.omega, l.axis), v[i])));
      l.omega = plus(parent.omega, times(l.axis, v[i]));
    }
    const X c = turned(l.frame.R, b.centre);
    X centre = plus(l.acceleration, plus(swept(l.alpha, c), swept(l.omega, swept(l.omega, c))));
    if (!bare)
      for (std::size_t k = 0; k < 3; ++k) centre[k] -= tree.gravity[static_cast<Eigen::Index>(k)];
    const auto inertia_times = [&](const X& w) {
      const X W = turned_back(l.frame.R, w);
      X L{};
      for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t s = 0; s < 3; ++s) L[r] += b.inertia(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(s)) * W[s];
      return turned(l.frame.R, L);
    };
    l.force = times(centre, b.mass);
    l.moment = plus(plus(inertia_times(l.alpha), swept(l.omega, inertia_times(l.omega))), swept(c, l.force));  // about the origin
    links.push_back(l);
  }
  Reals tau(q.size());
  for (std::size_t i = links.size(); i-- > 0;) {
    const Body& b = tree.bodies[i];
    const X& f = b.slides ? links[i].force : links[i].moment;
    tau[i] = links[i].axis[0] * f[0] + links[i].axis[1] * f[1] + links[i].axis[2] * f[2];
    if (!bare) tau[i] += static_cast<Real>(b.spring) * (q[i] - static_cast<Real>(b.rest));
    if (b.parent < 0) continue;
    Link& p = links[static_cast<std::size_t>(b.parent)];
    const X arm = plus(links[i].frame.origin, times(p.frame.origin, -1));
    p.force = plus(p.force, links[i].force);
    p.moment = plus(p.moment, plus(links[i].moment, swept(arm, links[i].force)));
  }
  return tau;
}

/// x with A x = b, by Gauss' elimination with row pivots.
inline Reals solved(std::vector<Reals> A, Reals b) {
  const std::size_t n = b.size();
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < n; ++i)
      if (std::abs(A[i][k]) > std::abs(A[pivot][k])) pivot = i;
    std::swap(A[k], A[pivot]);
    std::swap(b[k], b[pivot]);
    for (std::size_t i = k + 1; i < n; ++i) {
      const Real f = A[i][k] / A[k][k];
      for (std::size_t j = k; j < n; ++j) A[i][j] -= f * A[k][j];
      b[i] -= f * b[k];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) b[k] -= A[k][j] * b[j];
    b[k] /= A[k][k];
  }
  return b;
}

/// M and rhs of M q̈ = rhs: a column for each unit acceleration from rest.
struct TreeEquations {
  std::vector<Reals> M;
  Reals rhs;
};
inline TreeEquations equations_of(const Tree& tree, const Reals& q, const Reals& v) {
  const std::size_t n = q.size();
  const Reals zero(n, 0);
  TreeEquations e{std::vector<Reals>(n, zero), joint_forces(tree, q, v, zero)};
  for (Real& f : e.rhs) f = -f;
  for (std::size_t j = 0; j < n; ++j) {
    Reals unit = zero;
    unit[j] = 1;
    const Reals column = joint_forces(tree, q, zero, unit, true);
    for (std::size_t i = 0; i < n; ++i) e.M[i][j] = column[i];
  }
  return e;
}
inline Reals accelerations_of(const Tree& tree, const Reals& q, const Reals& v) {
  const TreeEquations e = equations_of(tree, q, v);
  return solved(e.M, e.rhs);
}

}  // namespace fuzz
