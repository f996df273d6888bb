#pragma once
// SPDX-License-Identifier: MIT
//
// Many motions by the processes of MPI, on as many machines as there are.
//
//     MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
//     const auto ends = ensemble(MpiRanks{MPI_COMM_WORLD}, 100'000, motion);     // on rank 0; empty on the others
//     const double sum = ensemble(MpiRanks{MPI_COMM_WORLD}, 100'000, motion, 0.0, add);
//
// All ranks call ensemble() with the same arguments. A motion is a function of its number, so the results are the same bits for
// any number of ranks and threads. Rank 0 gives out chunks by messages and does motions as well. A one-sided counter instead
// (MPI_Fetch_and_op) answers over TCP only when rank 0 calls MPI, as messages do (Open MPI 4.1). And results have to go to rank 0
// in any case, so that its answer to them is the next chunk.
//
// With MPI_THREAD_FUNNELED or more a thread of rank 0 answers beside its motions; with MPI_THREAD_SINGLE it answers between two
// of them. Two ranks took 0.97 to 1.06 times as long as two threads (docs/lab/many.md). When a rank dies, MPI ends all and the
// results are lost (`qdot sweep --resume` survives that). A rank that does not call, or has thrown before, is waited for.

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "qdot/integrate/many_in_lanes.hpp"
#include "qdot/integrate/mpi/communicator.hpp"
#include "qdot/integrate/mpi/rank_queue.hpp"
#include "qdot/integrate/ensemble.hpp"

namespace qdot {

/// The processes that do motions: those of a communicator, of which a copy is used.
struct MpiRanks {
  MPI_Comm communicator = MPI_COMM_WORLD;  ///< all of its ranks call
  bool results_on_all = false;             ///< whether what rank 0 returns is returned by all
};

namespace detail {

struct NoRules {
  void operator()() const {}
};

// What rank 0 has, on all.
template <class R>
void share_kept(Communicator& ranks, std::vector<Kept<R>>& all, std::size_t count) {
  constexpr std::size_t at_once = 65'536;
  all.resize(count);
  for (std::size_t first = 0; first < count; first += at_once) {
    const std::size_t last = std::min(count, first + at_once);
    std::string bytes;
    if (ranks.rank() == 0)
      for (std::size_t i = first; i < last; ++i) write_kept(bytes, all[i]);
    ranks.share(bytes);
    std::string_view rest = bytes;
    if (ranks.rank() != 0)
      for (std::size_t i = first; i < last; ++i) all[i] = read_kept<R>(rest);
  }
}

template <class R, class Work>
std::vector<Kept<R>> all_kept(RankQueue& queue, const MpiRanks& ranks, std::size_t count, const Work& work) {
  require_sendable<R>();
  std::vector<Kept<R>> all(queue.is_first() ? count : 0);
  queue.run<R>(work, into(all), false);
  if (ranks.results_on_all) share_kept(queue.ranks(), all, count);
  return all;
}

template <class R, class Work, class Value, class Reduce>
Value all_reduced(RankQueue& queue, const MpiRanks& ranks, const Work& work, Value value, const Reduce& reduce) {
  require_sendable<R>();
  queue.run<R>(work, reducing(value, reduce), true);
  if constexpr (can_be_sent<Value>()) {
    if (ranks.results_on_all) {
      std::string bytes;
      write_bytes(bytes, value);
      queue.ranks().share(bytes);
      std::string_view view = bytes;
      if (!queue.is_first()) value = read_bytes<Value>(view);
    }
  }
  return value;
}

template <class Value>
auto can_be_shared(const MpiRanks& ranks) {
  return [&ranks] {
    if (!can_be_sent<Value>() && ranks.results_on_all)
      throw_invalid_value(
          {"a reduction's value must be one that can be sent for MpiRanks::results_on_all, but its type has no bytes; "
           "give it to_bytes() and from_bytes(), or leave the value on rank 0"});
  };
}

// work(first, last) of a motion, with a look at messages in front of each.
template <class Motion>
auto work_of(RankQueue& queue, const Motion& motion) {
  return [&](std::size_t first, std::size_t last) {
    return kept_of_some([&](std::size_t i) -> decltype(auto) { return queue.between(), motion(i); }, first, last);
  };
}

// Motions in lanes by ranks, finish(queue, work); errors of the arguments are thrown on all ranks.
template <class Result, class Sys, class StartOf, class Method, class... Events, class Rules, class Finish>
Result ends_by_ranks(const MpiRanks& ranks, const Sys& system, std::size_t count, const StartOf& start_of, double t_end,
                     const Method& method, const Options& options, const EventList<Events...>& happening, const EnsembleOptions& many,
                     const Rules& rules, const Finish& finish) {
  const auto use = [&](const auto& start, const auto& what) { use_ends(systems_of(system), start, t_end, method, options, happening, what); };
  RankQueue queue(ranks.communicator, count, ranks.results_on_all, many, 1024, [&] {
    rules();
    use(start_of, [](const auto&) {});
  });
  std::optional<Result> result;
  use([&](std::size_t i) { return queue.between(), start_of(i); }, [&](const auto& work) { result.emplace(finish(queue, work)); });
  return std::move(*result);
}

}  // namespace detail

/// motion(i) for i = 0 … count − 1, by all ranks.
///
/// @param motion  called from several threads at once where many.threads is more than 1; must not use the communicator
/// @param many    threads of each rank, 0 for one; more than one need MPI_THREAD_FUNNELED, and cores that mpirun leaves them
/// @return        on rank 0 what was kept of each, by its number; on the others nothing, unless ranks.results_on_all
/// @throws InvalidValue  no MPI, no communicator, arguments that differ from rank to rank; on all ranks alike
/// @throws Error         messages that could not be sent
template <class Motion>
auto ensemble(const MpiRanks& ranks, std::size_t count, const Motion& motion, const EnsembleOptions& many = {}) {
  detail::RankQueue queue(ranks.communicator, count, ranks.results_on_all, many, 64, detail::NoRules());
  return detail::all_kept<detail::KeptOf<Motion>>(queue, ranks, count, detail::work_of(queue, motion));
}

/// Many motions by ranks, reduced to one value on rank 0 as they end, in the order of i: reduce(value, i, kept).
///
/// @return  on rank 0 the reduction; on the others the value that was given, unless ranks.results_on_all
/// @throws  on rank 0 what reduce throws, on the others an Error with its message
template <class Motion, class Value, class Reduce>
  requires std::invocable<const Reduce&, Value&, std::size_t, Kept<detail::KeptOf<Motion>>&&>
Value ensemble(const MpiRanks& ranks, std::size_t count, const Motion& motion, Value value, const Reduce& reduce, const EnsembleOptions& many = {}) {
  detail::RankQueue queue(ranks.communicator, count, ranks.results_on_all, many, 64, detail::can_be_shared<Value>(ranks));
  return detail::all_reduced<detail::KeptOf<Motion>>(queue, ranks, detail::work_of(queue, motion), std::move(value), reduce);
}

/// The ends of motions i = 0 … count − 1 of a system or of a family(), by all ranks, and in the lanes of each where that can be (integrate/many_in_lanes.hpp).
///
/// @return  on rank 0 for each motion, by its number, where it ended; on the others nothing, unless ranks.results_on_all
/// @throws InvalidValue, DimensionError, Error  as above, and options or t_end outside their range
template <class Sys, class StartOf, class Method, class Happening>
  requires(detail::GivesStarts<StartOf> && detail::is_event<Happening>)
auto ensemble(const MpiRanks& ranks, const Sys& system, std::size_t count, const StartOf& start_of, double t_end,
              const Method& method, const Options& options,
              const Happening& happening, const EnsembleOptions& many = {}) {
  using R = detail::MotionEndOf<Sys>;
  return detail::ends_by_ranks<std::vector<Kept<R>>>(
      ranks, system, count, start_of, t_end, method, options, events(happening), many, detail::NoRules(),
      [&](detail::RankQueue& queue, const auto& work) { return detail::all_kept<R>(queue, ranks, count, work); });
}

template <class Sys, class StartOf, class Method>
  requires detail::GivesStarts<StartOf>
auto ensemble(const MpiRanks& ranks, const Sys& system, std::size_t count, const StartOf& start_of, double t_end,
              const Method& method, const Options& options = {},
              const EnsembleOptions& many = {}) {
  return ensemble(ranks, system, count, start_of, t_end, method, options, EventList<>{}, many);
}

/// Many motions in lanes by ranks, reduced to one value on rank 0 as they end, in the order of i: reduce(value, i, kept).
template <class Sys, class StartOf, class Method, class... Events, class Value, class Reduce>
  requires std::invocable<const Reduce&, Value&, std::size_t, Kept<detail::MotionEndOf<Sys>>&&>
Value ensemble(const MpiRanks& ranks, const Sys& system, std::size_t count, const StartOf& start_of, double t_end,
               const Method& method, const Options& options, const EventList<Events...>& happening, Value value, const Reduce& reduce,
               const EnsembleOptions& many = {}) {
  using R = detail::MotionEndOf<Sys>;
  return detail::ends_by_ranks<Value>(
      ranks, system, count, start_of, t_end, method, options, happening, many, detail::can_be_shared<Value>(ranks),
      [&](detail::RankQueue& queue, const auto& work) { return detail::all_reduced<R>(queue, ranks, work, std::move(value), reduce); });
}

// Old names, accepted until 0.4.

/// ensemble() by its old name.
template <class Motion>
[[deprecated("qdot: say ensemble()")]]
auto simulate_many(const MpiRanks& ranks, std::size_t count, const Motion& motion, const EnsembleOptions& many = {}) {
  return ensemble(ranks, count, motion, many);
}
template <class Motion, class Value, class Reduce>
  requires std::invocable<const Reduce&, Value&, std::size_t, Kept<detail::KeptOf<Motion>>&&>
[[deprecated("qdot: say ensemble()")]]
Value simulate_many(const MpiRanks& ranks, std::size_t count, const Motion& motion, Value value, const Reduce& reduce, const EnsembleOptions& many = {}) {
  return ensemble(ranks, count, motion, std::move(value), reduce, many);
}
template <class Sys, class StartOf, class Method, class Happening>
  requires(detail::GivesStarts<StartOf> && detail::is_event<Happening>)
[[deprecated("qdot: say ensemble()")]]
auto simulate_many(const MpiRanks& ranks, const Sys& system, std::size_t count, const StartOf& start_of, double t_end, const Method& method,
                   const Options& options, const Happening& happening, const EnsembleOptions& many = {}) {
  return ensemble(ranks, system, count, start_of, t_end, method, options, happening, many);
}
template <class Sys, class StartOf, class Method>
  requires detail::GivesStarts<StartOf>
[[deprecated("qdot: say ensemble()")]]
auto simulate_many(const MpiRanks& ranks, const Sys& system, std::size_t count, const StartOf& start_of, double t_end, const Method& method,
                   const Options& options = {}, const EnsembleOptions& many = {}) {
  return ensemble(ranks, system, count, start_of, t_end, method, options, many);
}
template <class Sys, class StartOf, class Method, class... Events, class Value, class Reduce>
  requires std::invocable<const Reduce&, Value&, std::size_t, Kept<detail::MotionEndOf<Sys>>&&>
[[deprecated("qdot: say ensemble()")]]
Value simulate_many(const MpiRanks& ranks, const Sys& system, std::size_t count, const StartOf& start_of, double t_end, const Method& method,
                    const Options& options, const EventList<Events...>& happening, Value value, const Reduce& reduce, const EnsembleOptions& many = {}) {
  return ensemble(ranks, system, count, start_of, t_end, method, options, happening, std::move(value), reduce, many);
}

}  // namespace qdot
