// SPDX-License-Identifier: MIT
//
// What casadi_chain.py has written, compiled beside this file.
#include "bench/peers/peer.hpp"

extern "C" {
int chain_1(const double** arg, double** res, long long* iw, double* w, int mem);
int chain_2(const double** arg, double** res, long long* iw, double* w, int mem);
int chain_4(const double** arg, double** res, long long* iw, double* w, int mem);
int chain_8(const double** arg, double** res, long long* iw, double* w, int mem);
int chain_16(const double** arg, double** res, long long* iw, double* w, int mem);
}

namespace {

using Generated = int (*)(const double**, double**, long long*, double*, int);

template <Generated generated>
void chain(const double* q, const double* qdot, double* qddot) {
  const double* arguments[16] = {q, qdot};
  double* results[16] = {qddot};
  double work[1] = {};  // functions of scalars need none
  long long integers[1] = {};
  generated(arguments, results, integers, work, 0);
}

}  // namespace

extern "C" ChainAcceleration acceleration_of_chain(int n) {
  switch (n) {
    case 1: return chain<chain_1>;
    case 2: return chain<chain_2>;
    case 4: return chain<chain_4>;
    case 8: return chain<chain_8>;
    case 16: return chain<chain_16>;
    default: return nullptr;
  }
}
