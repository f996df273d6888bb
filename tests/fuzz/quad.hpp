#pragma once
// SPDX-License-Identifier: MIT
//
// Quadruple precision: libquadmath, declared here since clang does not find g++'s <quadmath.h>.

namespace fuzz {

__extension__ typedef __float128 quad;

extern "C" {
quad sqrtq(quad);
quad cbrtq(quad);
quad powq(quad, quad);
quad expq(quad);
quad expm1q(quad);
quad logq(quad);
quad log1pq(quad);
quad erfq(quad);
quad erfcq(quad);
quad sinq(quad);
quad cosq(quad);
quad tanq(quad);
quad asinq(quad);
quad acosq(quad);
quad atanq(quad);
quad atan2q(quad, quad);
quad sinhq(quad);
quad coshq(quad);
quad tanhq(quad);
quad asinhq(quad);
quad acoshq(quad);
quad atanhq(quad);
quad hypotq(quad, quad);
}

inline quad magnitude(quad x) { return x < 0 ? -x : x; }

}  // namespace fuzz
