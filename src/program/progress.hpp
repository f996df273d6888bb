#pragma once
// SPDX-License-Identifier: MIT
//
// A progress bar for runs that take longer than a second.
//
// It is drawn on stderr, only if that is a terminal, at most ten times a second. It is wiped when the run ends, so it never gets
// into a file or a pipe. NO_COLOR (no-color.org) switches its colour off.

#include <chrono>

namespace qdot::program {

class ProgressBar {
 public:
  /// @param wanted  false keeps it silent (--quiet)
  ProgressBar(double t_start, double t_end, bool wanted);
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar();

  /// Notes that the run has come to t, and redraws if it is time to.
  void reached(double t);

 private:
  using Clock = std::chrono::steady_clock;

  void draw(double fraction, double elapsed_seconds) const;

  double t_start_;
  double t_end_;
  bool shown_;
  bool colour_;
  bool drawn_ = false;
  int calls_ = 0;
  Clock::time_point began_ = Clock::now();
  Clock::time_point next_;
};

}  // namespace qdot::program
