#pragma once
// SPDX-License-Identifier: MIT
//
// Many motions: sweeps over parameters, maps of starts, samples of what is uncertain.
//
//     const auto ends = ensemble(100'000, [&](std::size_t i) {
//       CounterRandom random(seed, i);
//       return simulate(pendulum({.l = 1.0 + 0.05 * random.normal()}), start, 10.0, Dop853{}, options).y[0];
//     });
//
// A motion is a function of its number i; it makes its own start and parameters and returns what to keep of the run. So motions
// share nothing, and the results are the same bits for any number of threads. Threads take chunks of consecutive numbers from a
// counter, for motions that end early or late. An exception of a motion is kept with its number, and the rest goes on. A run with
// an outcome other than `completed` is no error here: the motion's function decides what to keep of it.
//
// reduce(sum, i, kept) is called in the order of i, by one thread at a time, so that sums in floating point are the same bits,
// too. Then memory holds a few chunks of results; threads that are too far ahead wait.

#include <algorithm>
#include <atomic>
#include <concepts>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/error.hpp"

namespace qdot {

/// How many motions are done at a time.
struct EnsembleOptions {
  int threads = 0;         ///< 0: as many as the machine has cores
  std::size_t chunk = 0;   ///< consecutive motions that a thread takes at once; 0: chosen, 1 to 64
};

/// What was kept of one motion.
template <class R>
struct Kept {
  std::optional<R> value;    ///< nothing where the motion's function threw
  std::exception_ptr error;  ///< what it threw

  /// Whether there is a value: the motion threw nothing.
  bool completed() const noexcept { return value.has_value(); }

  /// What went wrong, in words; empty where nothing did.
  std::string message() const {
    if (!error) return {};
    try {
      std::rethrow_exception(error);
    } catch (const std::exception& thrown) {
      return thrown.what();
    } catch (...) {
      return "what was thrown is no std::exception";
    }
  }
};

namespace detail {

inline std::size_t threads_of(const EnsembleOptions& many) {
  if (many.threads < 0) throw_invalid_value({"the number of threads must not be negative, but is ", many.threads, "; 0 means one for each core"});
  const unsigned cores = std::thread::hardware_concurrency();
  return many.threads > 0 ? static_cast<std::size_t>(many.threads) : cores > 0 ? cores : 1u;
}

// Chunks that are worked on by several threads and handed on in their order.
class Queue {
 public:
  Queue(std::size_t count, const EnsembleOptions& many)
      : threads_(std::max<std::size_t>(1, std::min(threads_of(many), count))), count_(count),
        chunk_(many.chunk > 0 ? std::min(many.chunk, std::max<std::size_t>(1, count))
                              : std::clamp<std::size_t>(count / (16 * threads_), 1, 64)),
        chunks_((count + chunk_ - 1) / chunk_) {}

  // work(first, last) → anything, in some thread; hand_on(first, result), in the order of chunks, one at a time. The first exception of either ends all.
  template <class Work, class HandOn>
  void run(const Work& work, const HandOn& hand_on) {
    using Result = std::invoke_result_t<const Work&, std::size_t, std::size_t>;
    const std::size_t window = 4 * threads_;  // chunks that may be done before their turn
    std::vector<std::optional<Result>> done(window);
    const auto worker = [&] {
      for (std::size_t c = next_++; c < chunks_; c = next_++) {
        {
          std::unique_lock lock(mutex_);
          turn_.wait(lock, [&] { return c < handed_ + window || stopped_; });
          if (stopped_) return;
        }
        try {
          Result result = work(c * chunk_, std::min(count_, (c + 1) * chunk_));
          std::unique_lock lock(mutex_);
          done[c % window] = std::move(result);
          while (!stopped_ && done[handed_ % window]) {
            Result ready = std::move(*std::exchange(done[handed_ % window], std::nullopt));
            hand_on(handed_ * chunk_, std::move(ready));
            ++handed_;
          }
        } catch (...) {
          std::unique_lock lock(mutex_);
          if (!stopped_) error_ = std::current_exception();
          stopped_ = true;
        }
        turn_.notify_all();
      }
    };
    {
      std::vector<std::jthread> others;
      for (std::size_t i = 1; i < threads_; ++i) others.emplace_back(worker);
      worker();
    }
    if (error_) std::rethrow_exception(error_);
  }

 private:
  std::size_t threads_, count_, chunk_, chunks_;
  std::atomic<std::size_t> next_{0};
  std::size_t handed_ = 0;
  bool stopped_ = false;
  std::exception_ptr error_;
  std::mutex mutex_;
  std::condition_variable turn_;
};

template <class Motion>
using KeptOf = std::remove_cvref_t<std::invoke_result_t<const Motion&, std::size_t>>;

template <class Motion>
auto kept_of_some(const Motion& motion, std::size_t first, std::size_t last) {
  static_assert(!std::is_void_v<KeptOf<Motion>>, "qdot: the function of ensemble() must return what to keep of its motion, and not nothing");
  std::vector<Kept<KeptOf<Motion>>> kept(last - first);
  for (std::size_t i = first; i < last; ++i) try {
      kept[i - first].value.emplace(motion(i));
    } catch (...) {
      kept[i - first].error = std::current_exception();
    }
  return kept;
}

// What is done with chunks of results in their turn.
template <class R>
auto into(std::vector<Kept<R>>& all) {
  return [&all](std::size_t first, std::vector<Kept<R>>&& some) { std::move(some.begin(), some.end(), all.begin() + static_cast<std::ptrdiff_t>(first)); };
}
template <class Value, class Reduce>
auto reducing(Value& value, const Reduce& reduce) {
  return [&](std::size_t first, auto&& some) {
    for (std::size_t k = 0; k < some.size(); ++k) reduce(value, first + k, std::move(some[k]));
  };
}

}  // namespace detail

/// motion(i) for i = 0 … count − 1, in threads.
///
/// @param motion  called from several threads at once: what it reads of outside must not change
/// @return        what was kept of each, by its number
/// @throws InvalidValue  a negative number of threads
template <class Motion>
auto ensemble(std::size_t count, const Motion& motion, const EnsembleOptions& many = {}) {
  std::vector<Kept<detail::KeptOf<Motion>>> all(count);
  detail::Queue(count, many).run([&](std::size_t first, std::size_t last) { return detail::kept_of_some(motion, first, last); },
                                 detail::into(all));
  return all;
}

/// Many motions, reduced to one value as they end, in the order of i: reduce(value, i, kept).
///
/// @throws  what reduce throws; the motions that are under way are finished, and no more are begun
template <class Motion, class Value, class Reduce>
  requires std::invocable<const Reduce&, Value&, std::size_t, Kept<detail::KeptOf<Motion>>&&>
Value ensemble(std::size_t count, const Motion& motion, Value value, const Reduce& reduce, const EnsembleOptions& many = {}) {
  detail::Queue(count, many).run([&](std::size_t first, std::size_t last) { return detail::kept_of_some(motion, first, last); },
                                 detail::reducing(value, reduce));
  return value;
}

// Old names, accepted until 0.4.

using ManyOptions [[deprecated("qdot: say EnsembleOptions")]] = EnsembleOptions;

/// ensemble() by its old name.
template <class Motion>
[[deprecated("qdot: say ensemble()")]]
auto simulate_many(std::size_t count, const Motion& motion, const EnsembleOptions& many = {}) {
  return ensemble(count, motion, many);
}
template <class Motion, class Value, class Reduce>
  requires std::invocable<const Reduce&, Value&, std::size_t, Kept<detail::KeptOf<Motion>>&&>
[[deprecated("qdot: say ensemble()")]]
Value simulate_many(std::size_t count, const Motion& motion, Value value, const Reduce& reduce, const EnsembleOptions& many = {}) {
  return ensemble(count, motion, std::move(value), reduce, many);
}

}  // namespace qdot
