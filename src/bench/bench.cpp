// SPDX-License-Identifier: MIT
#include "bench/bench.hpp"

namespace qdot::bench {

std::vector<Benchmark> all_benchmarks() {
  return {
      eom_benchmark(),
      scenes_benchmark(),
      ensemble_benchmark(),
      many_benchmark(),
      large_benchmark(),
      steppers_benchmark(),
      energy_benchmark(),
      sensitivities_benchmark(),
      hard_benchmark(),
      compile_benchmark(),
  };
}

}  // namespace qdot::bench
