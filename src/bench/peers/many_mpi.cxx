// SPDX-License-Identifier: MIT
//
// mpirun -n N --bind-to none many_mpi funneled|single [REPETITIONS]: many motions by N ranks, each on a core of its own, beside N threads of rank 0, by turns: least times by
// the clock. For a machine that has nothing else to do. mpicxx -std=c++20 -O3 -march=native -DOMPI_SKIP_MPICXX -Iinclude -Isrc -I/usr/include/eigen3
#include <sched.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "qdot/integrate/counter_random.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/ensemble_mpi.hpp"
#include "qdot/mechanics/system.hpp"
#include "scenes/double_pendulum.hpp"

using namespace qdot;

namespace {

int rank = 0, size = 1, repetitions = 5;

void run_on(int first, int last) {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  for (int core = first; core <= last; ++core) CPU_SET(core, &cores);
  sched_setaffinity(0, sizeof cores, &cores);
}

void meet() {  // without MPI_Barrier(), which looks for the others as fast as it can
  MPI_Request request;
  MPI_Ibarrier(MPI_COMM_WORLD, &request);
  detail::Patience patience;
  for (int done = 0; !done; patience.wait()) MPI_Test(&request, &done, MPI_STATUS_IGNORE);
}

double seconds(const auto& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void compare(const char* name, const auto& by_threads, const auto& by_ranks) {
  double threads = HUGE_VAL, ranks = HUGE_VAL;
  for (int k = 0; k < repetitions; ++k) {
    meet();
    run_on(0, size - 1);
    if (rank == 0) threads = std::min(threads, seconds(by_threads));
    meet();
    run_on(rank, rank);
    ranks = std::min(ranks, seconds(by_ranks));
  }
  if (rank == 0) std::printf("%-32s threads %.4f s, ranks %.4f s: %.3f\n", name, threads, ranks, ranks / threads);
}

}  // namespace

int main(int argc, char** argv) {
  int provided = 0;
  MPI_Init_thread(&argc, &argv, argc > 1 && std::string_view(argv[1]) == "single" ? MPI_THREAD_SINGLE : MPI_THREAD_FUNNELED, &provided);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  if (argc > 2) repetitions = std::atoi(argv[2]);

  const auto pendulum = mechanical_system<2>(scenes::DoublePendulum{});
  const Options options{.rtol = 1e-9, .keep_trajectory = false};
  const auto start_of = [](std::size_t i) {
    CounterRandom random(1, i);
    return State<2>{0.0, {random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0)}, {0.0, 0.0}};
  };
  const auto compare_motions = [&](const char* name, std::size_t count, double t_end) {
    const auto end_of = [&](std::size_t i) { return simulate(pendulum, start_of(i), t_end, Dop853{}, options).y[0]; };
    const auto add = [](double& sum, std::size_t, Kept<double>&& kept) { sum += *kept.value; };
    compare(name, [&] { ensemble(count, end_of, {.threads = size}); }, [&] { ensemble(MpiRanks{}, count, end_of); });
    compare("  reduced", [&] { ensemble(count, end_of, 0.0, add, {.threads = size}); }, [&] { ensemble(MpiRanks{}, count, end_of, 0.0, add); });
  };
  compare_motions("4000 motions of 5 s", 4000, 5.0);
  compare_motions("100 motions of 100 s", 100, 100.0);
  compare_motions("20000 motions of 0.2 s", 20'000, 0.2);
  compare("20000 motions of 5 s in lanes", [&] { ensemble(pendulum, 20'000, start_of, 5.0, Dop853{}, options, {.threads = size}); },
          [&] { ensemble(MpiRanks{}, pendulum, 20'000, start_of, 5.0, Dop853{}, options); });
  MPI_Finalize();
}
