// SPDX-License-Identifier: MIT
#include "program/sweep_share.hpp"

#include <cstdlib>
#include <optional>

#include "program/arguments.hpp"

namespace qdot::program {

namespace {

constexpr long most = 1'000'000;

std::optional<std::string> variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr || *value == '\0' ? std::nullopt : std::optional<std::string>(value);
}

long number(const char* name, const std::string& value, long least) {
  return whole_number(std::string("--shard: auto: ") + name, value, least, 2'000'000'000);
}

/// The one of several that two variables name, where both are set.
std::optional<SweepShare> numbered(const char* rank, const char* size) {
  const auto first = variable(rank), of = variable(size);
  if (!first || !of) return {};
  const SweepShare share{.first = static_cast<std::size_t>(number(rank, *first, 0)), .of = static_cast<std::size_t>(number(size, *of, 1))};
  if (share.first >= share.of)
    throw UsageError(std::string("--shard: auto: ") + rank + " must be below " + size + ", but they are " + *first + " and " + *of);
  return share;
}

/// A task of a Slurm array, whose numbers need not begin at 0 nor follow each other.
std::optional<SweepShare> task_of_array() {
  const auto task = variable("SLURM_ARRAY_TASK_ID"), count = variable("SLURM_ARRAY_TASK_COUNT");
  if (!task || !count) return {};
  const auto number_or = [](const char* name, const char* none, long least) { return number(name, variable(name).value_or(none), least); };
  const long least = number_or("SLURM_ARRAY_TASK_MIN", "0", 0), step = number_or("SLURM_ARRAY_TASK_STEP", "1", 1);
  const long of = number("SLURM_ARRAY_TASK_COUNT", *count, 1), id = number("SLURM_ARRAY_TASK_ID", *task, least);
  return SweepShare{.first = static_cast<std::size_t>((id - least) / step % of), .of = static_cast<std::size_t>(of)};
}

}  // namespace

SweepShare sweep_share(const std::string& text) {
  if (text != "auto") {
    const std::size_t slash = text.find('/');
    if (slash == std::string::npos) throw UsageError("--shard: must be K/N, the K-th of N shares, or auto, given \"" + text + "\"");
    const long of = whole_number("--shard", text.substr(slash + 1), 1, most), first = whole_number("--shard", text.substr(0, slash), 1, of);
    return {.first = static_cast<std::size_t>(first - 1), .of = static_cast<std::size_t>(of), .only = true};
  }
  // MPI's own numbers before Slurm's: under both, Slurm numbers what starts the processes of MPI on other machines.
  auto process = numbered("OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE");
  if (!process) process = numbered("PMI_RANK", "PMI_SIZE");
  if (!process) process = numbered("SLURM_PROCID", "SLURM_NTASKS");
  const auto task = task_of_array();
  if (!process && !task)
    throw UsageError(
        "--shard: auto must be started by MPI or Slurm, but of OMPI_COMM_WORLD_RANK and _SIZE, PMI_RANK and _SIZE, SLURM_PROCID and SLURM_NTASKS, "
        "SLURM_ARRAY_TASK_ID and _COUNT no pair is set; give K/N, or --resume in each process");
  const SweepShare one = process.value_or(SweepShare{}), array = task.value_or(SweepShare{});
  return {.first = array.first * one.of + one.first, .of = array.of * one.of};
}

std::string said_of_others() {
  // Of Slurm the numbers of a step, which srun has started: those of the job are set where its script runs, alone.
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"})
    if (const auto value = variable(name); value && std::atol(value->c_str()) > 1) return std::string(name) + " is " + *value;
  return {};
}

}  // namespace qdot::program
