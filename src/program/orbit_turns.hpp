#pragma once
// SPDX-License-Identifier: MIT
//
// How the coordinates move in one period of an orbit: how often each swings or goes round.

#include <string>
#include <vector>

#include <Eigen/Core>

namespace qdot::program {

/// Of one coordinate in a period.
struct Turns {
  int swings = 0;  // forth and back
  int rounds = 0;  // whole turns of an angle that goes round
};

/// The turns of each coordinate, from points at equal distances of time over one period, and the advance of the coordinates in it.
std::vector<Turns> turns_of(const std::vector<Eigen::VectorXd>& points, const Eigen::VectorXd& advance);

/// "swings 21 times", "goes round once", "rests".
std::string turns_text(const Turns& turns);

/// How many points show each swing and each round as a curve: 64 for each, 400 at least and 6400 at most.
int points_for(const std::vector<Turns>& turns);

}  // namespace qdot::program
