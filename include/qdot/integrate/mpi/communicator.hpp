#pragma once
// SPDX-License-Identifier: MIT
//
// What the ranks of a communicator say to each other: this header alone names MPI's functions.
//
// All goes over a copy of the user's communicator, so that messages are not mixed up, and no error of ours ends the program. MPI hands errors back,
// and here they become exceptions with a rule, values and a remedy.
//
// A rank that waits looks for messages, and sleeps in between. MPI's own waiting functions look all the time, on a core that threads of the same
// rank, or other ranks, may need.

#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <list>
#include <string>
#include <string_view>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/error.hpp"

namespace qdot::detail {

// How long a rank without work waits before it looks again: not at all, then longer and longer.
class Patience {
 public:
  void renew() { looks_ = 0; }
  std::chrono::microseconds next() {
    constexpr int at_once = 40, longest = 1000;
    if (++looks_ <= at_once) return std::chrono::microseconds(0);
    return std::chrono::microseconds(std::min(longest, 20 << std::min(6, (looks_ - at_once) / 8)));
  }
  void wait() {
    const auto pause = next();
    if (pause.count() > 0) std::this_thread::sleep_for(pause);
    else std::this_thread::yield();
  }

 private:
  int looks_ = 0;
};

class Communicator {
 public:
  explicit Communicator(MPI_Comm users) {
    int begun = 0, ended = 0, between = 0;
    MPI_Initialized(&begun);
    MPI_Finalized(&ended);
    if (!begun || ended)
      throw_invalid_value({"ensemble() by MPI must be called between MPI_Init_thread() and MPI_Finalize(), but MPI ",
                           begun ? "is finalized" : "is not initialized",
                           begun ? "; do it earlier" : "; say MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided) first"});
    if (users == MPI_COMM_NULL)
      throw_invalid_value(
          {"the communicator must have this rank in it, but is MPI_COMM_NULL; "
           "call ensemble() in those ranks alone that MPI_Comm_split() or MPI_Comm_create() gave one"});
    check(MPI_Comm_test_inter(users, &between), "MPI_Comm_test_inter");
    if (between) throw_invalid_value({"the communicator must be of one group of ranks, but is an intercommunicator; make it one by MPI_Intercomm_merge()"});
    check(MPI_Comm_dup(users, &own_), "MPI_Comm_dup");
    check(MPI_Comm_set_errhandler(own_, MPI_ERRORS_RETURN), "MPI_Comm_set_errhandler");
    check(MPI_Comm_rank(own_, &rank_), "MPI_Comm_rank");
    check(MPI_Comm_size(own_, &size_), "MPI_Comm_size");
  }
  ~Communicator() {
    if (!is_broken_) MPI_Comm_free(&own_);
    else new Letters(std::move(letters_));  // MPI may still read and write them, so they stay
  }
  Communicator(const Communicator&) = delete;
  Communicator& operator=(const Communicator&) = delete;

  int rank() const noexcept { return rank_; }
  int size() const noexcept { return size_; }

  // What the thread that asks may do: 0 not call MPI, 1 call it if there is no other thread, 2 call it beside others.
  int thread_level() {
    int provided = 0, is_main = 0;
    check(MPI_Query_thread(&provided), "MPI_Query_thread");
    check(MPI_Is_thread_main(&is_main), "MPI_Is_thread_main");
    return provided >= MPI_THREAD_SERIALIZED ? 2 : !is_main ? 0 : provided >= MPI_THREAD_FUNNELED ? 2 : 1;
  }

  // Everybody's, by rank, to everybody.
  template <class T>
    requires std::is_trivially_copyable_v<T>
  std::vector<T> gathered(const T& own) {
    std::vector<T> all(static_cast<std::size_t>(size_));
    MPI_Request request;
    check(MPI_Iallgather(&own, static_cast<int>(sizeof own), MPI_BYTE, all.data(), static_cast<int>(sizeof own), MPI_BYTE, own_, &request), "MPI_Iallgather");
    wait(request);
    return all;
  }

  // The bytes of one rank to everybody.
  void share(std::string& bytes, int from = 0) {
    std::uint64_t size = bytes.size();
    broadcast(&size, sizeof size, from);
    bytes.resize(static_cast<std::size_t>(size));
    constexpr std::size_t most = std::size_t{1} << 30;
    for (std::size_t begin = 0; begin < bytes.size(); begin += most) broadcast(bytes.data() + begin, std::min(most, bytes.size() - begin), from);
  }

  void send(int to, std::string bytes) {
    Letter& letter = letters_.emplace_back();
    letter.bytes = std::move(bytes);
    check(MPI_Isend(letter.bytes.data(), static_cast<int>(letter.bytes.size()), MPI_BYTE, to, tag, own_, &letter.request), "MPI_Isend");
  }

  // see(from, bytes) for each message that has come; whether there was any.
  template <class See>
  bool poll(const See& see) {
    bool any = false;
    for (int there = 1; there;) {
      MPI_Message message;
      MPI_Status status;
      check(MPI_Improbe(MPI_ANY_SOURCE, tag, own_, &there, &message, &status), "MPI_Improbe");
      if (!there) break;
      int size = 0;
      check(MPI_Get_count(&status, MPI_BYTE, &size), "MPI_Get_count");
      Letter& letter = letters_.emplace_back();
      letter.from = status.MPI_SOURCE;
      letter.bytes.resize(static_cast<std::size_t>(size));
      check(MPI_Imrecv(letter.bytes.data(), size, MPI_BYTE, &message, &letter.request), "MPI_Imrecv");
    }
    for (auto letter = letters_.begin(); letter != letters_.end();) {
      int done = 0;
      check(MPI_Test(&letter->request, &done, MPI_STATUS_IGNORE), "MPI_Test");
      if (!done) {
        ++letter;
        continue;
      }
      if (letter->from >= 0) {
        any = true;
        see(letter->from, std::string_view(letter->bytes));
      }
      letter = letters_.erase(letter);
    }
    return any;
  }

  // Whether nothing is under way, to here or from here.
  bool is_quiet() const { return letters_.empty(); }

 private:
  struct Letter {
    int from = -1;  // of one that is sent
    std::string bytes;
    MPI_Request request = MPI_REQUEST_NULL;
  };
  using Letters = std::list<Letter>;
  static constexpr int tag = 1;

  void check(int code, const char* function) {
    if (code == MPI_SUCCESS) return;
    is_broken_ = true;
    char text[MPI_MAX_ERROR_STRING] = "";
    int length = 0;
    MPI_Error_string(code, text, &length);
    throw Error(sentence({"the ranks of ensemble() must be able to reach each other, but ", function, " of rank ", rank_, " of ",
                          size_, " says: ", std::string_view(text, static_cast<std::size_t>(length)),
                          "; end the job, look whether a rank is gone or its network, and start it again"}));
  }

  void broadcast(void* data, std::size_t size, int from) {
    MPI_Request request;
    check(MPI_Ibcast(data, static_cast<int>(size), MPI_BYTE, from, own_, &request), "MPI_Ibcast");
    wait(request);
  }

  void wait(MPI_Request& request) {
    Patience patience;
    for (int done = 0;; patience.wait()) {
      check(MPI_Test(&request, &done, MPI_STATUS_IGNORE), "MPI_Test");
      if (done) return;
    }
  }

  MPI_Comm own_ = MPI_COMM_NULL;
  int rank_ = 0, size_ = 1;
  bool is_broken_ = false;
  Letters letters_;
};

}  // namespace qdot::detail
