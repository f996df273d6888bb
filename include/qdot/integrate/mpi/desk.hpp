#pragma once
// SPDX-License-Identifier: MIT
//
// Where a rank's calling thread and the threads that do its motions meet: numbers of chunks go in, bytes come out.
//
// The calling thread is woken where a thread would have nothing to do, and looks by itself otherwise: each time that it runs, a thread
// that does motions does not.

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace qdot::detail {

// The chunks that a rank has been given, and its threads that do them: what came of each, as bytes.
class Desk {
 public:
  template <class Do>
  Desk(std::size_t threads, const Do& bytes_of) {
    for (std::size_t i = 0; i < threads; ++i)
      threads_.emplace_back([this, &bytes_of] {
        while (const auto chunk = next(true)) put(bytes_of(*chunk));
      });
  }
  ~Desk() {
    {
      const std::lock_guard lock(mutex_);
      closed_ = true;
    }
    given_any_.notify_all();
  }

  void give(std::size_t chunk) {
    {
      const std::lock_guard lock(mutex_);
      given_.push_back(chunk);
    }
    given_any_.notify_one();
  }

  std::optional<std::size_t> next(bool waits) {
    std::unique_lock lock(mutex_);
    if (waits) given_any_.wait(lock, [&] { return closed_ || !given_.empty(); });
    if (closed_ || given_.empty()) return {};
    const std::size_t chunk = given_.front();
    given_.pop_front();
    return chunk;
  }

  void put(std::string&& bytes) {
    {
      const std::lock_guard lock(mutex_);
      done_.push_back(std::move(bytes));
      if (!is_urgent()) return;
    }
    urgent_.notify_one();
  }

  std::vector<std::string> collected() {
    const std::lock_guard lock(mutex_);
    return std::exchange(done_, {});
  }

  // Not so long if a thread has nothing to do.
  void wait_for(std::chrono::microseconds pause) {
    std::unique_lock lock(mutex_);
    urgent_.wait_for(lock, pause, [&] { return is_urgent(); });
  }

 private:
  bool is_urgent() const { return given_.empty() && !done_.empty(); }

  std::mutex mutex_;
  std::condition_variable given_any_, urgent_;
  std::deque<std::size_t> given_;
  std::vector<std::string> done_;
  bool closed_ = false;
  std::vector<std::jthread> threads_;
};

}  // namespace qdot::detail
