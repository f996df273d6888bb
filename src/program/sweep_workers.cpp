// SPDX-License-Identifier: MIT
#include "program/sweep_workers.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <mutex>
#include <thread>

#include "program/arguments.hpp"

namespace qdot::program {

namespace {

void work_here(SweepDirectory& directory, const MotionRow& motion, std::size_t threads, const SweepShare& share, const RecordedCount& reached) {
  std::mutex one;
  std::exception_ptr error;
  const auto worker = [&] {
    try {
      while (const auto chunk = directory.claim(share)) {
        for (std::size_t i = chunk->first; i < chunk->last; ++i) {
          const auto began = std::chrono::steady_clock::now();
          if (!directory.has(i)) directory.record(i, motion(i), began);
        }
        directory.finish(*chunk);
        if (!reached) continue;
        const std::lock_guard lock(one);
        reached(directory.known());
      }
    } catch (...) {
      directory.stop();
      const std::lock_guard lock(one);
      if (!error) error = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    for (std::size_t k = 1; k < threads; ++k) others.emplace_back(worker);
    worker();
  }
  try {
    directory.synchronize();
  } catch (...) {
    if (!error) error = std::current_exception();
  }
  if (error) std::rethrow_exception(error);
}

/// What a worker process does, and how it ends.
int status_of_worker(SweepDirectory& directory, const MotionRow& motion, std::size_t threads, const SweepShare& share, pid_t parent) {
  try {
    work_here(directory, motion, threads, share, [&](std::size_t) {
      if (getppid() != parent) directory.stop();  // the process that waited for it has ended
    });
    return 0;
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "qdot sweep: a worker process: %s\n", failure.what());
  } catch (...) {
    std::fprintf(stderr, "qdot sweep: a worker process: what was thrown is no std::exception\n");
  }
  return 1;
}

}  // namespace

std::vector<std::string> work_on(SweepDirectory& directory, const MotionRow& motion, const SweepWorkers& workers, const RecordedCount& reached) {
  (void)std::signal(SIGXFSZ, SIG_IGN);  // a file that must not grow is an error of write(), which has words for it
  if (workers.processes == 0) {
    work_here(directory, motion, workers.threads, workers.share, reached);
    return {};
  }
  std::fflush(nullptr);
  const pid_t parent = getpid();
  std::vector<pid_t> children;
  std::vector<std::string> early;
  const auto processes = static_cast<std::size_t>(workers.processes);
  for (std::size_t k = 0; k < processes; ++k) {
    SweepShare share = workers.share;
    if (!share.only) share = {.first = share.first * processes + k, .of = share.of * processes};
    const pid_t child = fork();
    if (child == 0) _exit(status_of_worker(directory, motion, workers.threads, share, parent));
    if (child > 0) children.push_back(child);
    else early.push_back(std::string("could not be started: ") + std::strerror(errno));
  }
  while (!children.empty()) {
    std::erase_if(children, [&](pid_t child) {
      int status = 0;
      const pid_t ended = waitpid(child, &status, reached ? WNOHANG : 0);
      if (ended == 0 || (ended < 0 && errno == EINTR)) return false;
      if (ended > 0 && WIFSIGNALED(status)) early.push_back("signal " + std::to_string(WTERMSIG(status)) + ", " + strsignal(WTERMSIG(status)));
      else if (ended < 0 || WEXITSTATUS(status) != 0) early.push_back("what it said above");
      return true;
    });
    if (!reached) continue;
    reached(directory.known_now());
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return early;
}

}  // namespace qdot::program
