// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench eom`: q̈ with its derivatives in q and q̇, beside q̈ alone by the same door.
#include <algorithm>

#include "bench/chain_energies.hpp"
#include "bench/eom.hpp"
#include "qdot/mechanics/acceleration_jacobian.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot::bench {

namespace {

template <int n, class E>
[[gnu::noinline]] void jacobian_by_general_door(const double* q, const double* qdot, double* out) {
  using V = Vector<double, n>;
  const AccelerationJacobian<n> j = acceleration_jacobian(benched_system<n, E>, V(Eigen::Map<const V>(q)), V(Eigen::Map<const V>(qdot)));
  Eigen::Map<V>{out} = j.qddot;
  Eigen::Map<Matrix<double, n>>{out + n} = j.d_q;
  Eigen::Map<Matrix<double, n>>{out + n * (1 + n)} = j.d_qdot;
}

template <int n, class E>
EquationsRow row_of(const char* door) {
  return {.system = "chain",
          .n = n,
          .door = door,
          .baseline = by_general_door<n, E>,
          .measured = jacobian_by_general_door<n, E>,
          .lowest = -2.0,
          .highest = 2.0,
          .baseline_name = "its q̈",
          .numbers_out = n + 2 * n * n};
}

// What an implicit method asks of its form, ∂ẏ/∂y of y = [q; q̇].
template <int n>
inline const auto benched_form = as_in_a_run(first_order_form(mechanical_system<n>(LoopedChain{})));

template <int n>
[[gnu::noinline]] void rates_by_form(const double* q, const double* qdot, double* out) {
  by_form<n>(benched_form<n>, q, qdot, out);
}

template <int n>
[[gnu::noinline]] void jacobian_by_form(const double* q, const double* qdot, double* out) {
  Vector<double, 2 * n> y;
  std::copy_n(qdot, n, std::copy_n(q, n, y.data()));
  static Eigen::MatrixXd J(2 * n, 2 * n);
  benched_form<n>.jacobian(0.0, y, J);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < 2 * n; ++j) *out++ = J(n + i, j);
}

template <int n>
EquationsRow row_of_form() {
  return {.system = "chain", .n = n, .door = "jacobian, for, in a run", .baseline = rates_by_form<n>, .measured = jacobian_by_form<n>,
          .lowest = -2.0, .highest = 2.0, .baseline_name = "its q̈", .numbers_out = 2 * n * n};
}

}  // namespace

std::vector<EquationsRow> jacobian_rows() {
  return {row_of<1, UnrolledChain<1>>("jacobian, unroll"), row_of<2, UnrolledChain<2>>("jacobian, unroll"),
          row_of<3, UnrolledChain<3>>("jacobian, unroll"), row_of<4, UnrolledChain<4>>("jacobian, unroll"),
          row_of_form<2>(), row_of_form<4>(), row_of_form<8>(), row_of_form<16>(), row_of_form<32>(),
          row_of<2, LoopedChain>("jacobian, for, outside of runs"), row_of<4, LoopedChain>("jacobian, for, outside of runs"),
          row_of<8, LoopedChain>("jacobian, for, outside of runs"), row_of<16, LoopedChain>("jacobian, for, outside of runs")};
}

}  // namespace qdot::bench
