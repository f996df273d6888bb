#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of <cmath>, and Eigen's traits, for numbers whose operations are written to a tape (ad/records/tape.hpp).
//
// They follow the dual numbers (ad/forward/following.hpp): an operation on the tape has one derivative along each of its arguments. Sine, cosine, root and
// exponential are written out.

#include <cmath>
#include <type_traits>

#include "qdot/ad/forward/following.hpp"
#include "qdot/ad/records/tape.hpp"

namespace qdot::detail {

template <class N>
inline constexpr bool follows_duals<Reverse<N>> = true;

template <class N, class F>
Reverse<N> through(const Reverse<N>& x, const F& f) {
  using D = Dual<N, 1>;
  const D y = f(D::variable(x.value, 0));
  return x.through(y.value, y.tangent[0]);
}
template <class N, class F>
Reverse<N> through(const Reverse<N>& x, const Reverse<N>& y, const F& f) {
  using D = Dual<N, 2>;
  const D z = f(D::variable(x.value, 0), D::variable(y.value, 1));
  return Reverse<N>::both(z.value, x, z.tangent[0], y, z.tangent[1]);
}

template <class N>
Reverse<N> sin(const Reverse<N>& x) {
  using std::cos, std::sin;
  return x.through(sin(x.value), cos(x.value));
}
template <class N>
Reverse<N> cos(const Reverse<N>& x) {
  using std::cos, std::sin;
  return x.through(cos(x.value), -sin(x.value));
}
template <class N>
Reverse<N> sqrt(const Reverse<N>& x) {
  using std::sqrt;
  const N root = sqrt(x.value);
  return x.through(root, 0.5 / root);
}
template <class N>
Reverse<N> exp(const Reverse<N>& x) {
  using std::exp;
  const N power = exp(x.value);
  return x.through(power, power);
}

}  // namespace qdot::detail

template <class N>
struct Eigen::NumTraits<qdot::detail::Reverse<N>>
    : qdot::detail::RealTraits<qdot::detail::Reverse<N>, 3, 20, 20, !std::is_trivially_default_constructible_v<qdot::detail::Reverse<N>>> {};
