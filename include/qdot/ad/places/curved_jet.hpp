#pragma once
// SPDX-License-Identifier: MIT
//
// A number that knows how it moves and how that changes from place to place: what Jacobians ask of positions where nothing may be kept.
//
// Equations of motion need of a position x(q, t) its J = ∂x/∂q and ẍ (ad/places/position_jet.hpp). Their derivatives at accelerations q̈ that are
// known need one order more,
//
//     H = ∂²x/∂q∂q ,     ∂ẋ/∂q = J̇ ,     ∂ẍ/∂q = J̈ ,     ∂ẍ/∂q̇ = 2 J̇ ,
//
// and no third derivatives but those along the motion. With u₁, u₂ for the two derivatives along it, products and functions follow
//
//     u w      J̈ = u J̈w + 2 u₁ J̇w + u₂ Jw + …                                H = u Hw + Ju Jwᵀ + …
//     f(u)     J̈ = f′ J̈u + 2 f″ u₁ J̇u + (f″ u₂ + f‴ u₁²) Ju                  H = f′ Hu + f″ Ju Juᵀ .
//
// The coordinates may be any variables whose two derivatives along the motion are known. Plain loops, over those coordinates between the first
// and the last that a number depends on: that is quick to compile, for any functor, and a sine of one of eight coordinates is a handful of operations.
// Jacobians of a chain of four masses and of a body in space take 0.65 and 1.8 µs this way, and 80 and 700 if they are recorded and differentiated
// at each call (g++ -O2).

#include <algorithm>
#include <type_traits>

#include "qdot/ad/lagrange/euler_lagrange_math.hpp"

namespace qdot::detail {

// A number of a function of one variable, or of two: what a value knows of itself on its way through <cmath>.
struct AlongOwnVariables {};
using LocalDual = Dual<double, 2, AlongOwnVariables>;
inline LocalDual local_dual(double value, double first, double second) {
  LocalDual x(value);
  x.tangent = {first, second};
  return x;
}

// f(x) from f and f′, and f(x, y) from f, ∂f/∂x, ∂f/∂y.
inline LocalDual lifted(const LocalDual& x, double f, double slope) { return local_dual(f, slope * x.tangent[0], slope * x.tangent[1]); }
inline LocalDual lifted(const LocalDual& x, const LocalDual& y, double f, double f_x, double f_y) {
  return local_dual(f, f_x * x.tangent[0] + f_y * y.tangent[0], f_x * x.tangent[1] + f_y * y.tangent[1]);
}

// The derivatives of F(u, v) by u: once, twice, three times, and those in which v takes part.
struct LocalSlopes {
  double f_u, f_uu, f_uv, f_uuu, f_uuv, f_uvv;
};

template <int n>
struct CurvedJet : ComparedByValue<CurvedJet<n>> {
  using Self = CurvedJet;

  LocalDual value;  // with its derivative by itself, 1, so that the functions of <cmath> tell f, f′, f″ and f‴
  double rate, bend;
  int first, last;                    // what follows is zero outside of first ≤ i < last, and not there
  double J[n], Jdot[n], Jddot[n], triangle[n * (n + 1) / 2];

  // Row i of the lower triangle of H.
  double* H(int i) { return triangle + i * (i + 1) / 2; }
  const double* H(int i) const { return triangle + i * (i + 1) / 2; }

  CurvedJet() = default;
  template <class Number>
    requires std::is_arithmetic_v<Number>
  CurvedJet(Number constant) : value(local_dual(static_cast<double>(constant), 1.0, 0.0)), rate(0.0), bend(0.0), first(n), last(0) {}

  explicit CurvedJet(const LocalDual& constant) : CurvedJet(constant.value) {}

  static Self coordinate(int i, double q, double qdot, double qddot) {
    Self r = moving(q, qdot, qddot);
    r.first = i;
    r.last = i + 1;
    r.J[i] = 1.0;
    r.Jdot[i] = r.Jddot[i] = r.H(i)[i] = 0.0;
    return r;
  }
  static Self time(double t) { return moving(t, 1.0, 0.0); }

  friend const double& innermost_value(const Self& x) { return x.value.value; }
  bool is_constant() const { return first >= last && rate == 0.0 && bend == 0.0; }
  const Self& whole() const { return *this; }

  friend Self operator+(Self a, const Self& b) { return a += b; }
  friend Self operator-(Self a, const Self& b) { return a -= b; }
  friend Self operator-(const Self& a) { return -1.0 * a; }
  friend Self operator+(const Self& a) { return a; }
  friend Self operator*(const Self& a, const Self& b) {
    const double u = a.value.value, w = b.value.value;
    Self r = moving(u * w, u * b.rate + w * a.rate, u * b.bend + 2.0 * a.rate * b.rate + w * a.bend);
    r.widen(a.first, a.last);
    r.widen(b.first, b.last);
    r.add(a, w, b.rate, b.bend);
    r.add(b, u, a.rate, a.bend);
    for (int i = a.first; i < a.last; ++i)
      for (int j = b.first; j < b.last; ++j) {
        const double product = a.J[i] * b.J[j];
        r.H(std::max(i, j))[std::min(i, j)] += i == j ? 2.0 * product : product;
      }
    return r;
  }
  friend Self operator*(double c, const Self& a) {
    Self r = moving(c * a.value.value, c * a.rate, c * a.bend);
    r.first = a.first;
    r.last = a.last;
    for (int i = r.first; i < r.last; ++i) {
      r.J[i] = c * a.J[i];
      r.Jdot[i] = c * a.Jdot[i];
      r.Jddot[i] = c * a.Jddot[i];
      for (int j = r.first; j <= i; ++j) r.H(i)[j] = c * a.H(i)[j];
    }
    return r;
  }
  friend Self operator*(const Self& a, double c) { return c * a; }
  friend Self operator/(const Self& a, const Self& b) {
    const LocalDual i = 1.0 / b.value;
    Self r = a * b.chain(i, -(i * i), 2.0 * i * i * i);
    r.value.value = a.value.value / b.value.value;
    return r;
  }
  Self& operator+=(const Self& o) { return add_whole(o, 1.0); }
  Self& operator-=(const Self& o) { return add_whole(o, -1.0); }
  Self& operator*=(const Self& o) { return *this = *this * o; }
  Self& operator/=(const Self& o) { return *this = *this / o; }

  // f(u) from f, f′ and f″, which brings f‴ along.
  Self chain(const LocalDual& f, const LocalDual& slope, const LocalDual& curvature) const {
    const double f1 = slope.value, f2 = curvature.value, f3 = curvature.tangent[0];
    Self r = moving(f.value, f1 * rate, f1 * bend + f2 * rate * rate);
    r.first = first;
    r.last = last;
    const double turned = f2 * rate, turned_twice = f2 * bend + f3 * rate * rate;
    for (int i = first; i < last; ++i) {
      r.J[i] = f1 * J[i];
      r.Jdot[i] = f1 * Jdot[i] + turned * J[i];
      r.Jddot[i] = f1 * Jddot[i] + 2.0 * turned * Jdot[i] + turned_twice * J[i];
      for (int j = first; j <= i; ++j) r.H(i)[j] = f1 * H(i)[j] + f2 * J[i] * J[j];
    }
    return r;
  }

  // F(u, w) from its derivatives up to the third, as its Taylor polynomial.
  struct Record {
    using Slopes = LocalSlopes;
  };
  bool meets(const Self&) const { return true; }
  static Self function(double F, const Self& u, const typename Record::Slopes& of_u, const Self& w, const typename Record::Slopes& of_w) {
    const auto of_one = [](double f, const Self& x, const typename Record::Slopes& s) {
      return x.chain(local_dual(f, s.f_u, 0.0), local_dual(s.f_u, s.f_uu, 0.0), local_dual(s.f_uu, s.f_uuu, 0.0));
    };
    const Self du = u - Self(u.value.value), dw = w - Self(w.value.value), both = du * dw;
    return of_one(F, u, of_u) + of_one(0.0, w, of_w) + both * (Self(of_u.f_uv) + 0.5 * of_u.f_uuv * du + 0.5 * of_u.f_uvv * dw);
  }

 private:
  static Self moving(double x, double xdot, double xddot) {
    Self r;
    r.value = local_dual(x, 1.0, 0.0);
    r.rate = xdot;
    r.bend = xddot;
    r.first = n;
    r.last = 0;
    return r;
  }
  Self& add_whole(const Self& o, double sign) {
    value.value += sign * o.value.value;
    rate += sign * o.rate;
    bend += sign * o.bend;
    widen(o.first, o.last);
    add(o, sign);
    return *this;
  }
  // Zeros for whatever depends on coordinates that have not been there.
  void widen(int from, int to) {
    if (from >= first && to <= last) return;
    const int low = std::min(first, from), high = std::max(last, to);
    for (int i = low; i < high; ++i) {
      const bool was = i >= first && i < last;
      if (!was) J[i] = Jdot[i] = Jddot[i] = 0.0;
      for (int j = low; j <= i; ++j)
        if (!was || j < first) H(i)[j] = 0.0;
    }
    first = low;
    last = high;
  }
  void add(const Self& u, double c) {
    for (int i = u.first; i < u.last; ++i) {
      J[i] += c * u.J[i];
      Jdot[i] += c * u.Jdot[i];
      Jddot[i] += c * u.Jddot[i];
      for (int j = u.first; j <= i; ++j) H(i)[j] += c * u.H(i)[j];
    }
  }
  // The same with a factor that moves.
  void add(const Self& u, double c, double cdot, double cddot) {
    for (int i = u.first; i < u.last; ++i) {
      J[i] += c * u.J[i];
      Jdot[i] += c * u.Jdot[i] + cdot * u.J[i];
      Jddot[i] += c * u.Jddot[i] + 2.0 * cdot * u.Jdot[i] + cddot * u.J[i];
      for (int j = u.first; j <= i; ++j) H(i)[j] += c * u.H(i)[j];
    }
  }
};

template <int n>
struct is_euler_lagrange<CurvedJet<n>> : std::true_type {};

// Rows ← rows + F H, in the columns of the coordinates.
template <class Rows, int n>
void add_curvature(Rows& rows, double F, const CurvedJet<n>& x) {
  for (int i = x.first; i < x.last; ++i)
    for (int j = x.first; j < x.last; ++j) rows[i][j] += F * x.H(std::max(i, j))[std::min(i, j)];
}

}  // namespace qdot::detail
