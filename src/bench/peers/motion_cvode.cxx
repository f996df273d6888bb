// SPDX-License-Identifier: MIT
//
// motion_cvode [PROBLEM]: SUNDIALS' CVODE, Adams with functional iteration, on equations derived by hand; lines as motion_qdot's.
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include "bench/peers/motion.hpp"

namespace {

using namespace qdot::bench;

template <class Rates>
int by_hand(sunrealtype, N_Vector y, N_Vector rates, void*) {
  Rates{}(N_VGetArrayPointer(y), N_VGetArrayPointer(rates));
  return 0;
}

struct Measure {
  template <std::size_t size, class Rates>
  void operator()(const MotionProblem& problem, const Rates&) const {
    SUNContext context = nullptr;
    SUNContext_Create(nullptr, &context);
    N_Vector y = N_VNew_Serial(static_cast<sunindextype>(size), context);
    const auto start = [&] { std::copy(problem.start.begin(), problem.start.end(), N_VGetArrayPointer(y)); };
    print_cheapest(problem, "cvode adams", [&](double tol, bool timed) {
      start();
      void* memory = CVodeCreate(CV_ADAMS, context);
      CVodeInit(memory, by_hand<Rates>, 0.0, y);
      CVodeSStolerances(memory, tol, tol);
      CVodeSetMaxNumSteps(memory, 1'000'000);
      CVodeSetErrFile(memory, nullptr);
      SUNNonlinearSolver iteration = SUNNonlinSol_FixedPoint(y, 0, context);
      CVodeSetNonlinearSolver(memory, iteration);
      CVodeSetStopTime(memory, problem.t_end);
      int flag = 0;
      const auto go = [&] {
        start();
        CVodeReInit(memory, 0.0, y);
        CVodeSetStopTime(memory, problem.t_end);
        double t = 0.0;
        flag = CVode(memory, problem.t_end, y, &t, CV_NORMAL);
      };
      go();
      const double error = flag < 0 ? INFINITY : problem.error(N_VGetArrayPointer(y));
      const double microseconds = timed ? least_microseconds(go) : 0.0;
      CVodeFree(&memory);
      SUNNonlinSolFree(iteration);
      return std::pair(error, microseconds);
    });
    N_VDestroy(y);
    SUNContext_Free(&context);
  }
};

}  // namespace

int main(int argc, char** argv) { for_each_problem(argc > 1 ? argv[1] : "", Measure{}); }
