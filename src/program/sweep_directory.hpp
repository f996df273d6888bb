#pragma once
// SPDX-License-Identifier: MIT
//
// Where a sweep is kept while it goes on: a directory that any number of processes work on, on one machine or on several with one file system.
//
//     manifest.json        what the sweep is; written once, and a process that asks for another one is refused
//     HOST.PID.records     what the motions came to, in a file of each process, which only grows
//     claims               a byte for each chunk of consecutive motions: whether it was ever taken. A process that works at a chunk holds a
//                          lock on its byte
//
// Nothing is taken back and nothing is written in place but the claims, from which nothing is believed: what is done is what the records say.
// A lock ends with its process, however that ends, and its chunk is free for the other processes. These take it last: if the chunk is what ended
// its process, the rest is done by then. Where a chunk is done twice, both results are the same bytes. So the result depends on the manifest
// alone, and not on which process did what or on how it ended.

#include <chrono>
#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "program/sweep_record.hpp"
#include "program/sweep_share.hpp"

namespace qdot::program {

class SweepDirectory {
 public:
  /// Finds the directory, or makes it.
  ///
  /// @param manifest  a JSON object
  /// @param count     of motions
  /// @param chunk     consecutive motions that are taken at once
  /// @param width     values of each motion
  /// @throws UsageError  it is of another sweep, is something else, or cannot be written
  SweepDirectory(std::string path, const std::string& manifest, std::size_t count, std::size_t chunk, std::size_t width);
  SweepDirectory(const SweepDirectory&) = delete;
  SweepDirectory& operator=(const SweepDirectory&) = delete;
  ~SweepDirectory();

  const std::string& path() const { return path_; }

  /// Motions that are recorded, as far as it is known here.
  std::size_t known() const;

  /// Motions that are recorded, after a look at what others have written.
  std::size_t known_now();

  /// Motions from `first` to before `last` that are to be done, some of which may be done already.
  struct Chunk {
    std::size_t number = 0, first = 0, last = 0;
  };

  /// The next chunk to do. Where the last ones are in other processes' hands, waits for these to end, in one way or the other.
  std::optional<Chunk> claim(SweepShare share);

  /// Whether motion i is recorded.
  bool has(std::size_t i) const;

  /// The first motion that is not recorded; the number of motions where all are.
  std::size_t first_missing() const;

  /// @param began   when motion i was begun: what took long is not kept back
  /// @throws Error  the disk is full, or gone
  void record(std::size_t i, const Row& row, std::chrono::steady_clock::time_point began);
  void finish(const Chunk& chunk);

  /// From now on nothing more is claimed.
  void stop();

  /// All that is recorded of this process is on the disk.
  void synchronize();

  /// Waits until no other process puts the results together. False where another has done so since this process has found the sweep
  /// incomplete.
  bool begin_merge();
  void end_merge();

  /// What came of all motions, all of which must be recorded; whatever could not be believed is named in remarks, a line for each file.
  std::vector<Row> rows(std::vector<std::string>& remarks) const;

 private:
  void read_others();
  void flush(bool to_disk);
  bool complete(std::size_t chunk) const;
  bool try_lock(std::size_t chunk);
  void unlock(std::size_t place);
  char flag(std::size_t place) const;
  void set_flag(std::size_t place, char value);
  std::optional<Chunk> taken(std::size_t chunk);
  std::vector<std::string> record_files() const;

  std::string path_;
  std::size_t count_, chunk_, chunks_;
  RecordFormat format_;
  mutable std::mutex mutex_;
  std::vector<bool> done_;
  std::size_t known_ = 0;
  std::map<std::string, std::size_t> read_to_;  // bytes, of the others' files
  bool complete_at_start_ = false, stopped_ = false, has_claimed_ = false;
  int claims_ = -1;
  std::set<std::size_t> held_;            // chunks of this process
  std::size_t fresh_ = 0;                 // place in the order of this process's share
  std::optional<std::vector<std::size_t>> left_;  // chunks that are taken and not complete
  std::string own_;                       // its file
  int records_ = -1;
  std::size_t written_ = 0;
  std::string pending_;
  std::chrono::steady_clock::time_point flushed_, synchronized_;
  bool on_disk_ = true;
};

}  // namespace qdot::program
