#pragma once
// SPDX-License-Identifier: MIT
//
// The hunt: kinds of cases, in the order in which they take turns.

#include <cstdint>
#include <string>
#include <vector>

#include "../doors.hpp"

namespace fuzz {

/// A kind of case: what it is called, and one case of it.
struct Game {
  std::string name;
  void (*hunt)(Report& report, Dice dice);
};

/// Each in a source of its own, since compiling them is what takes time.
std::vector<Game> interpreted_games();
std::vector<Game> written_games();
std::vector<Game> scene_games();
std::vector<Game> free_games();
std::vector<Game> kind_games();

/// The dice of a case: neither neighbouring seeds nor neighbouring cases have anything in common.
inline Dice dice_of(std::uint64_t seed, std::uint64_t number) {
  Dice dice{seed};
  return Dice{dice.next() ^ (number * 0xd1342543de82ef95u)};
}

/// Case `number` of the hunt with a seed. Findings begin with both.
inline void hunt(Report& report, const std::vector<Game>& games, std::uint64_t seed, std::uint64_t number) {
  const Game& game = games[number % games.size()];
  report.where = "seed " + std::to_string(seed) + ", case " + std::to_string(number) + " (" + game.name + ")";
  report.model.clear();
  game.hunt(report, dice_of(seed, number));
}

}  // namespace fuzz
