// SPDX-License-Identifier: MIT
#include "bench/bench.hpp"

namespace qdot::bench {

std::vector<Benchmark> all_benchmarks() {
  return {
#if __has_include("bench/eom.hpp")
      eom_benchmark(),
#endif
      ensemble_benchmark(),
      steppers_benchmark(),
      compile_benchmark(),
  };
}

}  // namespace qdot::bench
