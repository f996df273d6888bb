// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench steppers`: chains of six to sixteen links, up to eight with qdot::unroll, beyond with a plain loop.
#include "bench/chain_energies.hpp"
#include "bench/steppers.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/taylor.hpp"

namespace qdot::bench {

namespace {

template <class Chain>
void chain_rows(std::vector<Row>& rows, const Chain& chain, int n) {
  for (const MotionProblem& problem : motion_problems("chain " + std::to_string(n))) {
    MotionRows each(rows, problem);
    each.adaptive(chain, Dop853{});
    each.adaptive(chain, Taylor{});
    each.adaptive(mechanical_system(n, LoopedChain{}), CvodeAdams{});
  }
}

}  // namespace

void long_chain_rows(std::vector<Row>& rows) {
  chain_rows(rows, mechanical_system<6>(UnrolledChain<6>{}), 6);
  chain_rows(rows, mechanical_system<8>(UnrolledChain<8>{}), 8);
  chain_rows(rows, mechanical_system<12>(LoopedChain{}), 12);
  chain_rows(rows, mechanical_system<16>(LoopedChain{}), 16);
}

}  // namespace qdot::bench
