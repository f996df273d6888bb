// SPDX-License-Identifier: MIT
#include "program/progress.hpp"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace qdot::program {

namespace {

constexpr int bar_width = 32;
constexpr int calls_between_clocks = 16;  // reading the clock costs 2 % of a step; every 16th step is often enough

bool is_colour_wanted() {
  const char* no_colour = std::getenv("NO_COLOR");
  return no_colour == nullptr || *no_colour == '\0';
}

}  // namespace

ProgressBar::ProgressBar(double t_start, double t_end, bool wanted)
    : t_start_(t_start),
      t_end_(t_end),
      shown_(wanted && isatty(STDERR_FILENO) != 0),
      colour_(is_colour_wanted()),
      next_(began_ + std::chrono::seconds(1)) {}

ProgressBar::~ProgressBar() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

void ProgressBar::reached(double t) {
  if (!shown_ || ++calls_ % calls_between_clocks != 0) return;
  const auto now = Clock::now();
  if (now < next_) return;
  next_ = now + std::chrono::milliseconds(100);
  drawn_ = true;
  draw((t - t_start_) / (t_end_ - t_start_), std::chrono::duration<double>(now - began_).count());
}

void ProgressBar::draw(double fraction, double elapsed_seconds) const {
  const int filled = static_cast<int>(fraction * bar_width);
  std::string bar;
  for (int i = 0; i < bar_width; ++i) bar += i < filled ? "━" : "─";
  const double left = fraction > 0 ? elapsed_seconds * (1 - fraction) / fraction : 0;
  std::fprintf(stderr, "\r%s%s%s %3d %%  %.0f s left\033[K", colour_ ? "\033[36m" : "", bar.c_str(),
               colour_ ? "\033[0m" : "", static_cast<int>(100 * fraction), left);
  std::fflush(stderr);
}

}  // namespace qdot::program
