// SPDX-License-Identifier: MIT
#include "program/sweep_directory.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <mutex>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>
#include <utility>

#include "program/arguments.hpp"

namespace qdot::program {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

constexpr auto flush_interval = std::chrono::milliseconds(20);   // work that a process may lose when it is killed
constexpr auto disk_interval = std::chrono::milliseconds(1000);  // and when the machine loses its power

[[noreturn]] void fail(const std::string& rule, const std::string& path, int error) {
  throw Error(rule + ", but " + path + " cannot (" + std::strerror(error) + "); what was recorded stays, and the same command goes on from there");
}

void write_all(int file, const std::string& bytes, const std::string& path) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n = ::write(file, bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) fail("the records of a sweep must be written", path, n < 0 ? errno : ENOSPC);
    done += static_cast<std::size_t>(n);
  }
}

void synchronize_file(int file, const std::string& path) {
  if (fsync(file) != 0 && errno != EINVAL && errno != ENOTSUP) fail("the records of a sweep must be written", path, errno);
}

void synchronize_directory(const std::string& path) {
  const int directory = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (directory < 0) return;  // names are on the disk a little later then
  (void)fsync(directory);
  close(directory);
}

/// The machine and the process, as a file's name.
std::string own_name() {
  char host[256] = "";
  if (gethostname(host, sizeof host - 1) != 0 || host[0] == '\0') std::strcpy(host, "host");
  std::string name = host;
  std::replace_if(name.begin(), name.end(), [](char c) { return !(std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '.'); }, '-');
  if (name.front() == '.') name.front() = '-';
  return name + "." + std::to_string(getpid());
}

std::string content(const fs::path& path) {
  if (!fs::is_regular_file(path)) return {};
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// How a manifest's key is called on the command line.
std::string option_of(const std::string& key) {
  if (key == "scene") return "the scene";
  if (key == "scene file") return "what stands in the scene's file (its checksum)";
  if (key == "qdot") return "qdot's version";
  if (key == "format") return "the form of the records";
  if (key == "motions" || key == "chunk") return "the number of " + std::string(key == "chunk" ? "motions in a chunk" : "motions");
  std::string name = "--" + key;
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

std::string value_of(const Json& object, const std::string& key) {
  if (!object.contains(key)) return "nothing";
  const Json& value = object[key];
  if (!value.is_array()) return value.is_string() ? value.get<std::string>() : value.dump();
  std::string text;
  for (const Json& part : value) text += (text.empty() ? "" : " ") + (part.is_string() ? part.get<std::string>() : part.dump());
  return text.empty() ? "nothing" : text;
}

void require_same(const std::string& path, const std::string& found, const std::string& wanted) {
  if (found == wanted) return;
  const Json theirs = Json::parse(found, nullptr, false), ours = Json::parse(wanted);
  if (!theirs.is_object())
    throw UsageError("--out: must name a sweep's records or nothing, but " + path + "/manifest.json cannot be read; choose another --out, or move " + path +
                     " away");
  std::vector<std::string> keys;
  for (const Json* object : {&theirs, &ours})
    for (const auto& [key, value] : object->items())
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
  std::string differences;
  const auto compare = [&](const std::string& key) {
    const std::string old = value_of(theirs, key), now = value_of(ours, key);
    if (old != now) differences += (differences.empty() ? "" : "; ") + option_of(key) + " was " + old + " and is " + now;
  };
  for (const std::string& key : keys)
    if (key != "motions" && key != "chunk") compare(key);
  if (differences.empty())
    for (const char* key : {"motions", "chunk"}) compare(key);
  throw UsageError("--out: must go on with the sweep that is in " + path + ", but " + (differences.empty() ? "its manifest was changed" : differences) +
                   "; repeat its options, or choose another --out");
}

/// Hands out the records of a file from a place in it, see(index, record), and moves the place behind them; a block of the file at a time.
template <class See>
std::size_t damages_of_read(const std::string& path, std::size_t& used, const RecordFormat& format, const See& see) {
  constexpr std::size_t block = std::size_t{1} << 24;  // of many records, the longest of which has a megabyte
  std::ifstream in(path, std::ios::binary);
  std::string bytes;
  for (std::size_t damages = 0;;) {
    bytes.resize(block);
    in.clear();
    in.seekg(static_cast<std::streamoff>(used));
    in.read(bytes.data(), static_cast<std::streamsize>(block));
    bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, in.gcount())));
    if (used == 0 && format.is_foreign(bytes)) {
      const fs::path file(path);
      throw UsageError("--out: must go on with the sweep that is in " + file.parent_path().string() + ", but " + file.filename().string() +
                       " there is of another; move it away");
    }
    const RecordFormat::Read read = format.read(bytes, used == 0, see);
    used += read.used;
    damages += read.damages;
    if (read.used == 0 || bytes.size() < block) return damages;
  }
}

/// The manifest, of which all processes see the first that was there.
void settle_manifest(const std::string& path, const std::string& manifest) {
  const std::string final_name = path + "/manifest.json", draft = path + "/" + own_name() + ".unfinished";
  if (!fs::exists(final_name)) {
    for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
      const std::string name = entry.path().filename().string();
      if (name.ends_with(".unfinished") || name.ends_with(".records") || name == "manifest.json" || name == "claims") continue;
      throw UsageError("--out: must leave " + path + " to qdot, but it holds " + name + "; choose another --out, or move " + path + " away");
    }
    const int file = open(draft.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (file < 0 && (errno == EACCES || errno == EROFS))
      throw UsageError("--out: must be a path where this process may write, but " + draft + " cannot (" + std::strerror(errno) +
                       "); choose another --out, or change the permissions of " + path);
    if (file < 0) fail("a sweep's manifest must be written", draft, errno);
    try {
      write_all(file, manifest, draft);
      synchronize_file(file, draft);
    } catch (...) {
      close(file);
      unlink(draft.c_str());
      throw;
    }
    close(file);
    // A link leaves a manifest alone that another process was quicker with; not all file systems have it.
    const int linked = link(draft.c_str(), final_name.c_str());
    if (linked != 0 && errno != EEXIST && rename(draft.c_str(), final_name.c_str()) != 0) {
      const int error = errno;
      unlink(draft.c_str());
      fail("a sweep's manifest must be written", final_name, error);
    }
    unlink(draft.c_str());
    synchronize_directory(path);
  }
  require_same(path, content(final_name), manifest);
}

struct flock one_byte(short kind, std::size_t place) {
  struct flock range = {};
  range.l_type = kind;
  range.l_whence = SEEK_SET;
  range.l_start = static_cast<off_t>(place);
  range.l_len = 1;
  return range;
}

}  // namespace

SweepDirectory::SweepDirectory(std::string path, const std::string& manifest, std::size_t count, std::size_t chunk, std::size_t width)
    : path_(std::move(path)),
      count_(count),
      chunk_(chunk),
      chunks_((count + chunk - 1) / chunk),
      format_(qdot::detail::checksum(qdot::detail::empty_checksum, manifest.data(), manifest.size()), width, count),
      done_(count),
      flushed_(Clock::now()),
      synchronized_(flushed_) {
  make_directory_of(path_);
  if (mkdir(path_.c_str(), 0777) != 0 && (errno != EEXIST || !fs::is_directory(path_)))
    throw UsageError("--out: must be a path at which a directory can be made, but " + path_ + " cannot (" + std::strerror(errno) +
                     "); choose another path or create its directory");
  settle_manifest(path_, manifest);
  const std::string claims = path_ + "/claims";
  claims_ = open(claims.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (claims_ < 0) throw UsageError("--out: must be a path that can be written, but " + claims + " cannot (" + std::strerror(errno) + ")");
  const std::lock_guard lock(mutex_);
  read_others();
  complete_at_start_ = known_ == count_;
}

SweepDirectory::~SweepDirectory() {
  for (const int file : {claims_, records_})
    if (file >= 0) close(file);
}

std::size_t SweepDirectory::known() const {
  const std::lock_guard lock(mutex_);
  return known_;
}

std::size_t SweepDirectory::known_now() {
  const std::lock_guard lock(mutex_);
  read_others();
  return known_;
}

bool SweepDirectory::has(std::size_t i) const {
  const std::lock_guard lock(mutex_);
  return done_[i];
}

std::size_t SweepDirectory::first_missing() const {
  const std::lock_guard lock(mutex_);
  return static_cast<std::size_t>(std::find(done_.begin(), done_.end(), false) - done_.begin());
}

void SweepDirectory::stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
}

std::vector<std::string> SweepDirectory::record_files() const {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(path_))
    if (entry.path().extension() == ".records") names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

void SweepDirectory::read_others() {
  for (const std::string& name : record_files()) {
    if (name == own_) continue;
    std::size_t& used = read_to_[name];
    std::error_code unknown;
    const std::string path = path_ + "/" + name;
    if (const auto size = fs::file_size(path, unknown); unknown || size <= used) continue;
    damages_of_read(path, used, format_, [&](std::size_t i, std::string_view) {
      known_ += !done_[i];
      done_[i] = true;
    });
  }
}

bool SweepDirectory::complete(std::size_t chunk) const {
  const auto at = [&](std::size_t i) { return done_.begin() + static_cast<std::ptrdiff_t>(i); };
  return std::all_of(at(chunk * chunk_), at(std::min(count_, (chunk + 1) * chunk_)), [](bool done) { return done; });
}

bool SweepDirectory::try_lock(std::size_t chunk) {
  struct flock range = one_byte(F_WRLCK, chunk);
  while (fcntl(claims_, F_SETLK, &range) != 0) {
    if (errno == EACCES || errno == EAGAIN) return false;
    if (errno != EINTR) fail("the file system must lock files for the processes of a sweep (fcntl)", path_ + "/claims", errno);
  }
  return true;
}

void SweepDirectory::unlock(std::size_t place) {
  struct flock range = one_byte(F_UNLCK, place);
  (void)fcntl(claims_, F_SETLK, &range);
}

char SweepDirectory::flag(std::size_t place) const {
  char value = 0;
  return pread(claims_, &value, 1, static_cast<off_t>(place)) == 1 ? value : '\0';
}

void SweepDirectory::set_flag(std::size_t place, char value) {
  if (pwrite(claims_, &value, 1, static_cast<off_t>(place)) != 1) fail("the claims of a sweep must be written", path_ + "/claims", errno);
}

std::optional<SweepDirectory::Chunk> SweepDirectory::taken(std::size_t chunk) {
  held_.insert(chunk);
  return Chunk{chunk, chunk * chunk_, std::min(count_, (chunk + 1) * chunk_)};
}

std::optional<SweepDirectory::Chunk> SweepDirectory::claim(SweepShare share) {
  if (!share.only && share.of > chunks_) share = {.first = share.first % chunks_, .of = chunks_};
  // The share's own chunks and then, one behind the other, those of the shares after it.
  const std::size_t rounds = (chunks_ + share.of - 1) / share.of, places = share.only ? rounds : rounds * share.of;
  const auto chunk_at = [&](std::size_t place) { return place % rounds * share.of + (share.first + place / rounds) % share.of; };
  for (auto pause = std::chrono::milliseconds(5);; pause = std::min(2 * pause, std::chrono::milliseconds(500))) {
    {
      const std::lock_guard lock(mutex_);
      if (stopped_ || known_ == count_) return {};
      while (fresh_ < places) {
        const std::size_t chunk = chunk_at(fresh_++);
        if (chunk >= chunks_ || complete(chunk) || flag(chunk) != 0 || !try_lock(chunk)) continue;
        if (flag(chunk) != 0) {
          unlock(chunk);
          continue;
        }
        if (!std::exchange(has_claimed_, true)) set_flag(chunks_, 0);  // what was put together before is not all of it
        set_flag(chunk, 1);
        return taken(chunk);
      }
      read_others();
      if (!left_) {
        left_.emplace();
        for (std::size_t place = 0; place < places; ++place)
          if (const std::size_t chunk = chunk_at(place); chunk < chunks_) left_->push_back(chunk);
      }
      std::erase_if(*left_, [&](std::size_t chunk) { return complete(chunk); });
      bool others = false;
      for (const std::size_t chunk : *left_) {
        if (held_.count(chunk) > 0) continue;
        if (!try_lock(chunk)) {
          others = true;
          continue;
        }
        read_others();  // the process that held it may have done it since
        if (complete(chunk)) {
          unlock(chunk);
          continue;
        }
        if (!std::exchange(has_claimed_, true)) set_flag(chunks_, 0);
        return taken(chunk);
      }
      if (!others) return {};
    }
    std::this_thread::sleep_for(pause);
  }
}

void SweepDirectory::record(std::size_t i, const Row& row, Clock::time_point began) {
  const std::lock_guard lock(mutex_);
  format_.append(pending_, i, row);
  known_ += !done_[i];
  done_[i] = true;
  const Clock::time_point now = Clock::now();
  if (now - std::min(flushed_, began) > flush_interval) flush(now - std::min(synchronized_, began) > disk_interval);
}

void SweepDirectory::finish(const Chunk& chunk) {
  const std::lock_guard lock(mutex_);
  flush(Clock::now() - synchronized_ > disk_interval);
  held_.erase(chunk.number);
  unlock(chunk.number);
}

void SweepDirectory::synchronize() {
  const std::lock_guard lock(mutex_);
  flush(true);
}

void SweepDirectory::flush(bool to_disk) {
  flushed_ = Clock::now();
  if (!pending_.empty()) {
    if (records_ < 0) {
      for (int k = 0; records_ < 0; ++k) {  // a file of its own, also where an earlier process had this number
        own_ = own_name() + (k == 0 ? "" : "." + std::to_string(k)) + ".records";
        records_ = open((path_ + "/" + own_).c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0666);
        if (records_ < 0 && errno != EEXIST) fail("the records of a sweep must be written", path_ + "/" + own_, errno);
      }
      pending_.insert(0, format_.head());
      synchronize_directory(path_);
    }
    try {
      write_all(records_, pending_, path_ + "/" + own_);
    } catch (...) {
      if (ftruncate(records_, static_cast<off_t>(written_)) != 0) stopped_ = true;  // a reader leaves half a record out
      stopped_ = true;
      throw;
    }
    written_ += pending_.size();
    pending_.clear();
    on_disk_ = false;
  }
  if (to_disk && !on_disk_) {
    synchronize_file(records_, path_ + "/" + own_);
    synchronized_ = Clock::now();
    on_disk_ = true;
  }
}

bool SweepDirectory::begin_merge() {
  struct flock range = one_byte(F_WRLCK, chunks_);
  while (fcntl(claims_, F_SETLKW, &range) != 0)
    if (errno != EINTR) fail("the file system must lock files for the processes of a sweep (fcntl)", path_ + "/claims", errno);
  if (complete_at_start_ || flag(chunks_) == 0) return true;
  unlock(chunks_);
  return false;
}

void SweepDirectory::end_merge() {
  set_flag(chunks_, 1);
  unlock(chunks_);
}

std::vector<Row> SweepDirectory::rows(std::vector<std::string>& remarks) const {
  std::vector<Row> rows(count_);
  std::vector<bool> there(count_);
  for (const std::string& name : record_files()) {
    const std::string path = path_ + "/" + name;
    std::size_t used = 0;
    std::size_t damages = damages_of_read(path, used, format_, [&](std::size_t i, std::string_view record) {
      if (!there[i]) rows[i] = format_.row(record);
      there[i] = true;
    });
    std::error_code unknown;
    if (const auto size = fs::file_size(path, unknown); !unknown && size > used) ++damages;
    if (damages > 0)
      remarks.push_back(path + " was cut short or changed in " + std::to_string(damages) + (damages == 1 ? " place" : " places") +
                        "; what stood there was left out and done again");
  }
  if (const auto missing = std::count(there.begin(), there.end(), false); missing > 0)
    throw Error("the records of a sweep must stay where they are, but " + std::to_string(missing) + " have gone from " + path_ +
                "; the same command makes them again");
  return rows;
}

}  // namespace qdot::program
