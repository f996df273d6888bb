// SPDX-License-Identifier: MIT
//
// What accuracy costs: which method, at which tolerance, brings the digits that are needed for the least work.
//
// A tolerance limits the error of one step. The error at the end is another number: the motion amplifies what the steps leave
// behind, and every method does with a tolerance what it likes. So errors are measured, against a reference that is
// computed with more digits (long double) and by a method of its own (extrapolation), and the tolerance is read off backwards.
//
// The system is the double pendulum, swung so that it has not become chaotic yet within four seconds.
#include <qdot/analysis/work_precision.hpp>
#include <qdot/integrate/taylor.hpp>
#include <qdot/qdot.hpp>

#include <cmath>
#include <cstdio>

int main() {
  using namespace qdot;
  // m = l = 1; both angles from the vertical.
  const auto T = [](const auto& q, const auto& qdot) {
    using std::cos;
    return qdot[0] * qdot[0] + 0.5 * qdot[1] * qdot[1] + cos(q[0] - q[1]) * qdot[0] * qdot[1];
  };
  const auto V = [](const auto& q) {
    using std::cos;
    return -9.81 * (2 * cos(q[0]) + cos(q[1]));
  };
  const auto pendulum = mechanical_system<2>(T, V);
  const State<2> start{0.0, {1.2, 0.8}, {0.0, 0.0}};

  // Errors are the largest at 16 times; the times of the runs are measured too, and as short as possible here.
  const WorkPrecisionOptions options{.tolerances = {1e-3, 1e-5, 1e-7, 1e-9, 1e-11}, .outputs = 16, .seconds_per_cell = 0.001, .longest_run = 0.5};
  const WorkPrecision study = work_precision(pendulum, start, 4.0, options, by_tolerance("dopri5", Dopri5{}),
                                             by_tolerance("dop853", Dop853{}), by_tolerance("taylor", Taylor{}));

  std::printf("reference: %s\n", study.reference.made_by.c_str());
  std::printf("it is known to better than 1e-15: %s\n", study.reference.uncertainty < 1e-15 ? "yes" : "no");
  std::printf("errors of the start grow about %.0f-fold\n\n", study.reference.gain);

  std::printf("method   tolerance   largest error   evaluations\n");
  for (const Measurement& m : study.measurements)
    std::printf("%-8s %9.0e %15.0e %13ld\n", m.method.c_str(), m.setting, m.largest_error, m.evaluations);

  // By evaluations, which are the same on every machine. study.cheapest(error) decides by CPU time.
  std::printf("\nfewest evaluations of the Runge-Kutta methods\n");
  for (const double error : {1e-3, 1e-6, 1e-9}) {
    const Measurement* best = nullptr;
    for (const Measurement& m : study.measurements)
      if (m.method != "taylor" && m.largest_error <= error && (best == nullptr || m.evaluations < best->evaluations)) best = &m;
    if (best != nullptr) std::printf("error below %.0e: %s at %.0e, %ld evaluations\n", error, best->method.c_str(), best->setting, best->evaluations);
  }
}
