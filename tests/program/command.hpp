#pragma once
// SPDX-License-Identifier: MIT
//
// Runs the program as a user does and returns what it printed and how it ended.

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace program_test {

/// An empty directory that goes away with the test.
class Directory {
 public:
  Directory() {
    std::string pattern = (std::filesystem::temp_directory_path() / "qdot-program-test-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) std::abort();
    path_ = pattern;
  }
  Directory(const Directory&) = delete;
  Directory& operator=(const Directory&) = delete;
  ~Directory() { std::filesystem::remove_all(path_); }

  std::string file(const std::string& name) const { return (path_ / name).string(); }
  long entries() const {
    return std::distance(std::filesystem::directory_iterator(path_), std::filesystem::directory_iterator());
  }

 private:
  std::filesystem::path path_;
};

inline std::string content(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

struct Ended {
  int status = -1;
  std::string out;
  std::string err;
};

/// `PROGRAM ARGUMENTS`, through the shell.
inline Ended ended(const std::string& program, const std::string& arguments) {
  const Directory directory;
  const std::string command =
      "'" + program + "' " + arguments + " >'" + directory.file("out") + "' 2>'" + directory.file("err") + "'";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, content(directory.file("out")), content(directory.file("err"))};
}

/// `qdot ARGUMENTS`.
inline Ended qdot(const std::string& arguments) { return ended(QDOT_PROGRAM, arguments); }

}  // namespace program_test
