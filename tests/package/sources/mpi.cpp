// SPDX-License-Identifier: MIT
#include <qdot/integrate/ensemble_mpi.hpp>

int main(int argc, char** argv) {
  int provided = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  const auto all = ensemble(qdot::MpiRanks{.results_on_all = true}, 100, [](std::size_t i) { return 2 * i; });
  const bool right = all.size() == 100 && all[99].value == 198;
  MPI_Finalize();
  return right ? 0 : 1;
}
