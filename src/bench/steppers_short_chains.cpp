// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench steppers`: chains of one to four links, summed with a plain loop.
#include "bench/chain_energies.hpp"
#include "bench/steppers.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/taylor.hpp"

namespace qdot::bench {

namespace {

template <int n>
void chain_rows(std::vector<Row>& rows) {
  for (const MotionProblem& problem : motion_problems("chain " + std::to_string(n))) {
    if (problem.n != n) continue;
    const auto chain = mechanical_system<n>(LoopedChain{});
    MotionRows each(rows, problem);
    each.adaptive(chain, Dop853{});
    each.adaptive(chain, Dopri5{});
    each.adaptive(chain, Taylor{});
  }
}

}  // namespace

void short_chain_rows(std::vector<Row>& rows) {
  chain_rows<1>(rows);
  chain_rows<2>(rows);
  chain_rows<3>(rows);
  chain_rows<4>(rows);
}

}  // namespace qdot::bench
