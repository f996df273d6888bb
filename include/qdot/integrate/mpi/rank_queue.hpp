#pragma once
// SPDX-License-Identifier: MIT
//
// Chunks of motions that are worked on by several ranks, each with its threads, and handed on by rank 0.
//
// Rank 0 gives out numbers of chunks, and a rank that sends what came of one is sent another. Each has up to four more in hand than it has
// threads, so that it does not wait for the answer. The answer takes as long as a motion on rank 0, or as whatever else keeps its
// processor. Fewer towards the end, and none when others would have nothing.
//
// The calling thread alone calls MPI, rank 0's own included, which is what MPI_THREAD_FUNNELED allows. Where a rank has one thread, that thread
// also does the motions, and looks after messages between two of them, all 50 µs at most.

#include <algorithm>
#include <chrono>
#include <climits>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/integrate/mpi/bytes.hpp"
#include "qdot/integrate/mpi/communicator.hpp"
#include "qdot/integrate/mpi/desk.hpp"
#include "qdot/integrate/ensemble.hpp"

namespace qdot::detail {

// Motions 0 … count − 1 in chunks, on the ranks of a communicator.
class RankQueue {
  using Clock = std::chrono::steady_clock;

 public:
  // own_rules() throws what is wrong with the arguments of this rank. Where something is on any, all throw.
  template <class Rules>
  RankQueue(MPI_Comm communicator, std::size_t count, bool on_all, const EnsembleOptions& many, std::size_t longest_chunk, const Rules& own_rules)
      : ranks_(communicator), count_(count) {
    std::exception_ptr error;
    try {
      own_rules();
    } catch (...) {
      error = std::current_exception();
    }
    const Terms own{count, many.chunk, many.threads, ranks_.thread_level(), on_all, error != nullptr};
    const std::vector<Terms> all = ranks_.gathered(own);
    require_same(all, error);
    std::size_t threads = 0;
    for (const Terms& terms : all) {
      threads_of_.push_back(terms.threads > 0 ? static_cast<std::size_t>(terms.threads) : 1);
      threads += threads_of_.back();
    }
    workers_ = threads;
    chunk_ = many.chunk > 0 ? std::min(many.chunk, std::max<std::size_t>(1, count)) : std::clamp<std::size_t>(count / (64 * threads), 1, longest_chunk);
    chunks_ = (count + chunk_ - 1) / chunk_;
    // Rank 0 answers at once, whatever its motions take, if they may go in a thread of their own.
    is_apart_ = own_threads() > 1 || (ranks_.rank() == 0 && ranks_.size() > 1 && own.level == 2);
  }

  Communicator& ranks() { return ranks_; }
  bool is_first() const { return ranks_.rank() == 0; }

  // To be called in front of each motion.
  void between() {
    if (!look_ || Clock::now() < next_look_) return;
    look_();
    next_look_ = Clock::now() + std::chrono::microseconds(50);
  }

  // work(first, last) → what is kept of each motion, on any rank; hand_on(first, kept), on rank 0 by the calling thread, and in the order of chunks if that is
  // asked for. All ranks end together; the first exception of hand_on, or of work itself, ends all.
  template <class R, class Work, class HandOn>
  void run(const Work& work, const HandOn& hand_on, bool in_order) {
    Share<R, Work, HandOn> share(*this, work, hand_on, in_order);
    share.run();
  }

 private:
  // What a rank was called with.
  struct Terms {
    std::uint64_t count, chunk;
    std::int64_t threads;
    int level;
    bool on_all, is_wrong;
  };

  template <class R, class Work, class HandOn>
  class Share;

  std::size_t own_threads() const { return threads_of_[static_cast<std::size_t>(ranks_.rank())]; }

  void require_same(const std::vector<Terms>& all, const std::exception_ptr& error) {
    const auto disagree = [&](const char* about, const char* remedy, auto what) {
      for (std::size_t r = 1; r < all.size(); ++r)
        if (what(all[r]) != what(all[0]))
          throw_invalid_value({"all ranks must call ensemble() with the same ", about, ", but rank 0 says ", what(all[0]),
                               " and rank ", r, " ", what(all[r]), remedy});
    };
    disagree("number of motions", "; send rank 0's to the others by MPI_Bcast()", [](const Terms& t) { return t.count; });
    disagree("EnsembleOptions::chunk", "; set it to one number on all, or to 0", [](const Terms& t) { return t.chunk; });
    disagree("MpiRanks::results_on_all", "; set it alike", [](const Terms& t) { return t.on_all; });
    for (std::size_t r = 0; r < all.size(); ++r) {
      const Terms& terms = all[r];
      if (terms.threads < 0)
        throw_invalid_value(
            {"the number of threads must not be negative, but is ", terms.threads, " on rank ", r, "; 0 means one in each rank"});
      if (terms.level == 0 || (terms.threads > 1 && terms.level < 2))
        throw_invalid_value(
            {"MPI must be told that there are several threads, but rank ", r,
             terms.level == 0 ? " calls ensemble() in another thread than the one that began MPI" : " asks for ",
             terms.level == 0 ? "" : std::to_string(terms.threads) + " of them under MPI_THREAD_SINGLE",
             terms.level == 0
                 ? "; call it in that one, or say MPI_Init_thread(&argc, &argv, MPI_THREAD_SERIALIZED, &provided)"
                 : "; say MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided) in place of MPI_Init(), or start more ranks"});
    }
    for (std::size_t r = 0; r < all.size(); ++r) {
      if (!all[r].is_wrong) continue;
      std::string message = error ? Kept<int>{{}, error}.message() : "";
      ranks_.share(message, static_cast<int>(r));
      if (error) std::rethrow_exception(error);
      throw Error(sentence({"all ranks must call ensemble() with valid arguments, but on rank ", r, ": ", message}));
    }
  }

  Communicator ranks_;
  std::size_t count_, chunk_ = 1, chunks_ = 0, workers_ = 1;
  std::vector<std::size_t> threads_of_;
  bool is_apart_ = false;
  std::function<void()> look_;
  Clock::time_point next_look_ = {};
};

// What this rank does of a run.
template <class R, class Work, class HandOn>
class RankQueue::Share {
 public:
  Share(RankQueue& queue, const Work& work, const HandOn& hand_on, bool in_order)
      : queue_(queue), ranks_(queue.ranks_), work_(work), hand_on_(hand_on), in_order_(in_order) {
    for (std::size_t round = 0, more = 1; more > 0; ++round) {  // a chunk for each rank, and another, …
      more = 0;
      for (std::size_t r = 0; r < queue.threads_of_.size(); ++r)
        if (round < queue.threads_of_[r] + ahead) {
          waiting_.push_back(r);
          ++more;
        }
    }
    held_.resize(queue.threads_of_.size());
    open_ = queue.is_first() ? waiting_.size() : queue.own_threads() + ahead;
    window_ = 2 * waiting_.size();
  }

  void run() {
    const auto bytes_of = [this](std::size_t chunk) { return bytes_of_chunk(chunk); };
    {
      Desk desk(queue_.is_apart_ ? queue_.own_threads() : 0, bytes_of);
      desk_ = &desk;
      if (!queue_.is_apart_)
        queue_.look_ = [this] {  // in front of a motion, whose function would keep what is thrown
          try {
            if (!lost_) serve();
          } catch (...) {
            lost_ = std::current_exception();
          }
        };
      Patience patience;
      std::chrono::microseconds pause(500);
      for (;;) {
        const bool any = serve();
        if (open_ == 0 && ranks_.is_quiet()) break;
        if (queue_.is_apart_ && open_ > 0) {  // about as often as messages come: a look takes a thread's processor for some microseconds
          pause = has_mail_ ? std::max(pause / 2, std::chrono::microseconds(100)) : std::min(2 * pause, std::chrono::microseconds(2000));
          desk.wait_for(pause);
          continue;
        }
        const auto chunk = desk.next(false);
        if (chunk) desk.put(bytes_of(*chunk));
        if (lost_) std::rethrow_exception(lost_);
        if (any || chunk) patience.renew();
        else patience.wait();
      }
      queue_.look_ = nullptr;
    }
    std::string bytes;
    write_bytes(bytes, std::pair(error_ != nullptr, Kept<R>{{}, error_}.message()));
    ranks_.share(bytes);
    if (error_) std::rethrow_exception(error_);
    std::string_view rest = bytes;
    if (const auto [has_ended, message] = read_bytes<std::pair<bool, std::string>>(rest); has_ended)
      throw Error(sentence({"the study must come to its end on all ranks, but was ended on rank 0: ", message}));
  }

 private:
  // Does a chunk, in any thread: its number, whether there are results, and these or what went wrong.
  std::string bytes_of_chunk(std::size_t chunk) const {
    std::string bytes;
    const auto begin = [&](bool is_complete) {
      bytes.clear();
      write_bytes(bytes, std::pair(static_cast<std::uint64_t>(chunk), is_complete));
    };
    try {
      begin(true);
      for (const Kept<R>& kept : work_(first_of(chunk), first_of(chunk + 1))) write_kept(bytes, kept);
      if (bytes.size() <= INT_MAX) return bytes;
      throw_invalid_value({"what is kept of a chunk of motions must be less than 2 GB, but is ", bytes.size(),
                           " bytes; choose a smaller EnsembleOptions::chunk than ", queue_.chunk_});
    } catch (...) {
      const Kept<R> wrong{{}, std::current_exception()};
      begin(false);
      write_bytes(bytes, sentence({"rank ", ranks_.rank(), " could not go on, ", wrong.message()}));
      return bytes;
    }
  }

  std::size_t first_of(std::size_t chunk) const { return std::min(queue_.count_, chunk * queue_.chunk_); }

  // Whether anything has come or gone.
  bool serve() {
    has_mail_ = ranks_.poll([&](int from, std::string_view bytes) {
      if (queue_.is_first()) has_come(static_cast<std::size_t>(from), bytes);
      else if (const auto chunk = read_bytes<std::int64_t>(bytes); chunk < 0) --open_;
      else desk_->give(static_cast<std::size_t>(chunk));
    });
    bool any = has_mail_;
    for (std::string& bytes : desk_->collected()) {
      any = true;
      if (queue_.is_first()) has_come(0, bytes);
      else ranks_.send(0, std::move(bytes));
    }
    return (queue_.is_first() && gives_out()) || any;
  }

  // --- On rank 0 ---

  void has_come(std::size_t from, std::string_view bytes) {
    --held_[from];
    waiting_.push_back(from);
    const auto [number, is_complete] = read_bytes<std::pair<std::uint64_t, bool>>(bytes);
    const auto chunk = static_cast<std::size_t>(number);
    if (!is_complete) return end(std::make_exception_ptr(Error(read_bytes<std::string>(bytes))));
    std::vector<Kept<R>> kept;
    try {
      for (std::size_t i = first_of(chunk); i < first_of(chunk + 1); ++i) kept.push_back(read_kept<R>(bytes));
    } catch (...) {  // no memory for them
      return end(std::current_exception());
    }
    if (!in_order_) return hands_on(chunk, std::move(kept));
    early_.emplace(chunk, std::move(kept));
    for (auto first = early_.begin(); first != early_.end() && first->first == handed_; first = early_.erase(first))
      hands_on(first->first, std::move(first->second));
  }

  void hands_on(std::size_t chunk, std::vector<Kept<R>>&& kept) {
    ++handed_;
    if (error_) return;
    try {
      hand_on_(first_of(chunk), std::move(kept));
    } catch (...) {
      end(std::current_exception());
    }
  }

  // Chunks that a rank may have while others are left; the thread that gives them out need not have more than it is at.
  std::size_t most_of(std::size_t rank, std::size_t left) const {
    const bool is_alone = (rank == 0 && !queue_.is_apart_) || left < queue_.workers_;
    return queue_.threads_of_[rank] + (is_alone ? 0 : std::clamp<std::size_t>(left / (4 * queue_.workers_), 1, ahead));
  }

  void end(const std::exception_ptr& error) {
    if (!error_) error_ = error;
  }

  bool gives_out() {
    return std::erase_if(waiting_, [&](std::size_t rank) {
      const std::size_t left = queue_.chunks_ - next_;
      const bool ends = left == 0 || error_;
      if (!ends && ((in_order_ && next_ >= handed_ + window_) || held_[rank] >= most_of(rank, left))) return false;
      const std::int64_t chunk = ends ? -1 : static_cast<std::int64_t>(next_++);
      if (ends) --open_;
      else ++held_[rank];
      if (rank > 0) {
        std::string bytes;
        write_bytes(bytes, chunk);
        ranks_.send(static_cast<int>(rank), std::move(bytes));
      } else if (!ends) {
        desk_->give(static_cast<std::size_t>(chunk));
      }
      return true;
    }) > 0;
  }

  static constexpr std::size_t ahead = 4;  // chunks that a rank has beside those that its threads are at

  RankQueue& queue_;
  Communicator& ranks_;
  const Work& work_;
  const HandOn& hand_on_;
  bool in_order_, has_mail_ = false;
  Desk* desk_ = nullptr;
  std::exception_ptr lost_, error_;
  std::size_t open_ = 0;              // answers that this rank waits for; on rank 0, that it owes
  std::vector<std::size_t> waiting_;  // ranks, as often as they wait for an answer
  std::vector<std::size_t> held_;     // chunks that each rank has
  std::size_t next_ = 0, handed_ = 0, window_ = 0;
  std::map<std::size_t, std::vector<Kept<R>>> early_;  // before their turn
};

}  // namespace qdot::detail
