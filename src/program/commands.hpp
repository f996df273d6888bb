#pragma once
// SPDX-License-Identifier: MIT
//
// The subcommands, one file each. A command takes its options as text, as they were typed, and returns the exit status:
//
//     0  completed        1  the run failed; what it reached is printed and written        2  bad arguments (UsageError)

#include <optional>
#include <string>
#include <vector>

#include "program/chosen_scene.hpp"

namespace qdot::program {

struct ListOptions {
  std::optional<std::string> scene;  // all of them without one
  bool json = false;
};

struct RunOptions : SceneOptions {
  std::optional<std::string> t_end, method, step, rtol, atol, accuracy, samples, out;
  std::vector<std::string> compare;  // settings of further runs
  bool forces = false;               // arrows in the animation
  bool json = false;
  bool quiet = false;
};

struct AccuracyOptions : SceneOptions {
  std::vector<std::string> methods;
  std::optional<std::string> t_end, samples, out;
  bool quick = false;
  bool json = false;
  bool quiet = false;
};

struct EffectsOptions {
  std::string scene;
  std::vector<std::string> set;
  bool json = false;
};

struct EquationsOptions {
  std::string scene;
  std::vector<std::string> set;
  std::optional<std::string> c;  // a file
  bool latex = false, mathml = false;
};

struct ModesOptions : SceneOptions {
  std::optional<std::string> out;
  bool steady = false;  // coordinates turn at the velocities of the start
  bool json = false;
};

struct EquilibriaOptions : ModesOptions {
  std::optional<std::string> along, show;
};

struct ConservedOptions : SceneOptions {
  bool json = false;
};

struct LyapunovCommandOptions : SceneOptions {
  std::optional<std::string> t_end, interval, settle, rtol, out;
  bool json = false;
  bool quiet = false;
};

struct SectionCommandOptions : SceneOptions {
  std::optional<std::string> plane, every, direction, count, keep_energy, show, t_end, rtol, out;
  std::vector<std::string> angles, over;
  bool json = false;
  bool quiet = false;
};

struct OrbitCommandOptions : SceneOptions {
  std::optional<std::string> period, period_guess, hold, settle, along, show, out;
  bool json = false;
};

struct SensitivityCommandOptions : SceneOptions {
  std::optional<std::string> of, to, t_end, method, step, rtol, samples, out;
  bool json = false;
};

struct NewOptions {
  std::string name;
};

struct SweepOptions : SceneOptions {
  std::vector<std::string> over, record;
  std::optional<std::string> random, seed, threads, processes, shard, t_end, method, rtol, atol, out;
  bool resume = false;
  bool json = false;
  bool quiet = false;
};

struct BenchOptions {
  std::optional<std::string> name, page;
  bool json = false;
};

int list(const ListOptions& options);
int run(const RunOptions& options);
int accuracy(const AccuracyOptions& options);
int effects(const EffectsOptions& options);
int equations(const EquationsOptions& options);
int modes(const ModesOptions& options);
int equilibria(const EquilibriaOptions& options);
int equilibria_along(const EquilibriaOptions& options);
int conserved(const ConservedOptions& options);
int lyapunov(const LyapunovCommandOptions& options);
int orbit(const OrbitCommandOptions& options);
int section(const SectionCommandOptions& options);
int sensitivity(const SensitivityCommandOptions& options);
int new_scene(const NewOptions& options);
int sweep(const SweepOptions& options);
int bench(const BenchOptions& options);

}  // namespace qdot::program
