#pragma once
// SPDX-License-Identifier: MIT
//
// Files that are there completely or not at all.
//
// A file is first written under a temporary name in the directory where it belongs, and then renamed. Within one directory POSIX
// renames atomically, so a reader sees the old file or the new one, never half of one. Files that belong together (x.csv, x.npz,
// x.html) are all written before the first is renamed: a full disk leaves none of them.

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>
#include <vector>

#include "qdot/error.hpp"

namespace qdot::report {

/// A file cannot be written where it was asked for.
class UnwritableFile : public Error {
 public:
  using Error::Error;
};

/// What to write, and where.
struct File {
  std::string path;   ///< where
  std::string bytes;  ///< what
};

namespace detail {

inline std::string temporary_name(const std::string& path) { return path + ".unfinished"; }

/// Removes the temporary files that were not renamed, whatever happened.
class TemporaryFiles {
 public:
  TemporaryFiles() = default;
  TemporaryFiles(const TemporaryFiles&) = delete;
  TemporaryFiles& operator=(const TemporaryFiles&) = delete;
  ~TemporaryFiles() {
    for (const std::string& path : paths_) std::remove(temporary_name(path).c_str());
  }

  void write(const std::string& path, const std::string& bytes) {
    errno = 0;
    std::ofstream out(temporary_name(path), std::ios::binary | std::ios::trunc);
    if (out) paths_.push_back(path);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) throw UnwritableFile(message(path, errno));
  }

  void rename_all() {
    while (!paths_.empty()) {
      std::error_code error;
      std::filesystem::rename(temporary_name(paths_.back()), paths_.back(), error);
      if (error) throw UnwritableFile(message(paths_.back(), error.value()));
      paths_.pop_back();
    }
  }

 private:
  static std::string message(const std::string& path, int error) {
    return "an output file must be writable; " + path + " is not" +
           (error != 0 ? std::string(" (") + std::strerror(error) + ")" : std::string()) +
           "; choose another path or create its directory";
  }

  std::vector<std::string> paths_;
};

}  // namespace detail

/// Checks, before any work is done, that files can be written to these paths; leaves nothing behind.
///
/// @throws UnwritableFile  naming the path and the system's reason
inline void require_writable(const std::vector<std::string>& paths) {
  detail::TemporaryFiles probe;
  for (const std::string& path : paths) {
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) {
      throw UnwritableFile("an output file must be writable; " + path + " is a directory; choose another path");
    }
    probe.write(path, "");
  }
}

/// Writes all of these files, or none of them.
///
/// @throws UnwritableFile  naming the path and the system's reason
inline void write_files(const std::vector<File>& files) {
  detail::TemporaryFiles pending;
  for (const File& file : files) pending.write(file.path, file.bytes);
  pending.rename_all();
}

}  // namespace qdot::report
