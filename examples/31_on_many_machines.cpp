// SPDX-License-Identifier: MIT
//
// When does a double pendulum turn over that starts from angles which are not known exactly? A sample by the processes of MPI:
//
//     mpirun -n 4 31_on_many_machines

#include <cmath>
#include <cstdio>
#include <numbers>

#include <qdot/integrate/counter_random.hpp>
#include <qdot/integrate/event.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/simulate.hpp>
#include <qdot/integrate/ensemble_mpi.hpp>

using namespace qdot;

struct DoublePendulum {
  double g = 9.81;

  auto T(const auto& q, const auto& v) const {
    using std::cos;
    return v[0] * v[0] + 0.5 * v[1] * v[1] + v[0] * v[1] * cos(q[0] - q[1]);
  }
  auto V(const auto& q) const {
    using std::cos;
    return -g * (2.0 * cos(q[0]) + cos(q[1]));
  }
};

const auto pendulum = mechanical_system<2>(DoublePendulum{});
const auto over = events(event("inner", [](const auto& q) { using std::abs; return std::numbers::pi - abs(q[0]); }).stop(),
                         event("outer", [](const auto& q) { using std::abs; return std::numbers::pi - abs(q[1]); }).stop());

// What is kept of a motion goes from process to process: numbers, without pointers.
struct Turn {
  double t = 0.0;
  bool is_over = false;
};

Turn turn_of(std::size_t i) {
  CounterRandom random(2026, i);
  const double first = 2.6 + 0.01 * random.normal(), second = 0.5 + 0.01 * random.normal();
  const auto run = simulate(pendulum, State<2>{0.0, {first, second}, {0.0, 0.0}}, 4.0, Dop853{}, {.rtol = 1e-7, .keep_trajectory = false}, over);
  return {run.t, run.outcome == Outcome::stopped_by_event};
}

struct Sums {
  int over = 0;
  double t = 0.0, t2 = 0.0;
};

void add(Sums& sums, std::size_t, Kept<Turn>&& kept) {
  if (!kept.completed() || !kept.value->is_over) return;
  ++sums.over;
  sums.t += kept.value->t;
  sums.t2 += kept.value->t * kept.value->t;
}

int main(int argc, char** argv) {
  int provided = 0, rank = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  const Sums sums = ensemble(MpiRanks{MPI_COMM_WORLD}, 200, turn_of, Sums{}, add);  // add() on rank 0, in the order of i
  if (rank == 0) {
    const double mean = sums.t / sums.over;
    std::printf("from (2.6, 0.5) ± 0.01 rad: %d of 200 turn over within 4 s, at t = %.3f ± %.3f s\n", sums.over, mean,
                std::sqrt(sums.t2 / sums.over - mean * mean));
  }
  MPI_Finalize();
}
