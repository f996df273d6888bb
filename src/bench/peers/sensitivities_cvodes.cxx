// SPDX-License-Identifier: MIT
//
// sensitivities_cvodes: the same by SUNDIALS' CVODES, Adams with functional iteration on equations and variational equations derived by hand, all columns
// in one call, errors of Phi controlled.
#include <cvodes/cvodes.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include "bench/peers/sensitivities.hpp"

namespace {

constexpr double g = 9.81;

struct At {
  double s, c, D, a0, a1;
  explicit At(const double* y) {
    s = std::sin(y[0] - y[1]);
    c = std::cos(y[0] - y[1]);
    D = 1.0 / (2.0 - c * c);
    const double r0 = -s * y[3] * y[3] - 2.0 * g * std::sin(y[0]), r1 = s * y[2] * y[2] - g * std::sin(y[1]);
    a0 = D * (r0 - c * r1);
    a1 = D * (2.0 * r1 - c * r0);
  }
};

int rates(sunrealtype, N_Vector state, N_Vector out, void*) {
  const double* y = N_VGetArrayPointer(state);
  double* f = N_VGetArrayPointer(out);
  const At at(y);
  f[0] = y[2];
  f[1] = y[3];
  f[2] = at.a0;
  f[3] = at.a1;
  return 0;
}

int variations(int count, sunrealtype, N_Vector state, N_Vector, N_Vector* columns, N_Vector* out, void*, N_Vector, N_Vector) {
  const double* y = N_VGetArrayPointer(state);
  const At at(y);
  const double gc0 = 2.0 * g * std::cos(y[0]), gc1 = g * std::cos(y[1]);
  for (int j = 0; j < count; ++j) {
    const double* d = N_VGetArrayPointer(columns[j]);
    double* f = N_VGetArrayPointer(out[j]);
    const double dc = -at.s * (d[0] - d[1]), ds = at.c * (d[0] - d[1]);
    const double x0 = -ds * y[3] * y[3] - 2.0 * at.s * y[3] * d[3] - gc0 * d[0] - dc * at.a1;
    const double x1 = ds * y[2] * y[2] + 2.0 * at.s * y[2] * d[2] - gc1 * d[1] - dc * at.a0;
    f[0] = d[2];
    f[1] = d[3];
    f[2] = at.D * (x0 - at.c * x1);
    f[3] = at.D * (2.0 * x1 - at.c * x0);
  }
  return 0;
}

}  // namespace

int main() {
  SUNContext context = nullptr;
  SUNContext_Create(nullptr, &context);
  N_Vector y = N_VNew_Serial(4, context);
  N_Vector* columns = N_VCloneVectorArray(4, y);
  const auto begin = [&] {
    double* at = N_VGetArrayPointer(y);
    at[0] = at[1] = qdot::bench::released_from;
    at[2] = at[3] = 0.0;
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i) N_VGetArrayPointer(columns[j])[i] = i == j ? 1.0 : 0.0;
  };
  const auto run = [&](double tolerance, bool derived, double* Phi) {
    begin();
    void* memory = CVodeCreate(CV_ADAMS, context);
    CVodeInit(memory, rates, 0.0, y);
    CVodeSStolerances(memory, tolerance, tolerance);
    CVodeSetMaxNumSteps(memory, 1'000'000);
    SUNNonlinearSolver plain = SUNNonlinSol_FixedPoint(y, 0, context), both = nullptr;
    CVodeSetNonlinearSolver(memory, plain);
    if (derived) {
      CVodeSensInit(memory, 4, CV_SIMULTANEOUS, variations, columns);
      double absolute[4] = {tolerance, tolerance, tolerance, tolerance};
      CVodeSensSStolerances(memory, tolerance, absolute);
      CVodeSetSensErrCon(memory, 1);
      both = SUNNonlinSol_FixedPointSens(5, y, 0, context);
      CVodeSetNonlinearSolverSensSim(memory, both);
    }
    CVodeSetStopTime(memory, qdot::bench::asked_at);
    double t = 0.0;
    if (CVode(memory, qdot::bench::asked_at, y, &t, CV_NORMAL) < 0) std::printf("cvodes failed\n");
    if (derived) {
      CVodeGetSens(memory, &t, columns);
      for (int i = 0; i < 16; ++i) Phi[i] = N_VGetArrayPointer(columns[i % 4])[i / 4];
    }
    CVodeFree(&memory);
    SUNNonlinSolFree(plain);
    if (both != nullptr) SUNNonlinSolFree(both);
  };
  qdot::bench::print_lines("cvodes", [&](double tolerance, double* Phi) { run(tolerance, true, Phi); }, [&](double tolerance) { run(tolerance, false, nullptr); });
  N_VDestroyVectorArray(columns, 4);
  N_VDestroy(y);
  SUNContext_Free(&context);
}
