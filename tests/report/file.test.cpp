// SPDX-License-Identifier: MIT
#include "qdot/report/file.hpp"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "catch2_bridge.hpp"

using namespace qdot::report;
namespace fs = std::filesystem;

namespace {

/// An empty directory of this test's own.
struct Directory {
  fs::path path = fs::temp_directory_path() / ("qdot-file-test-" + std::to_string(getpid()));
  Directory() { fs::create_directory(path); }
  Directory(const Directory&) = delete;
  Directory& operator=(const Directory&) = delete;
  ~Directory() { fs::remove_all(path); }
  std::string file(const std::string& name) const { return (path / name).string(); }
  long entries() const { return std::distance(fs::directory_iterator(path), fs::directory_iterator()); }
};

std::string content(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

TEST_CASE("files are written with their bytes and nothing is left beside them") {
  const Directory directory;
  write_files({{directory.file("a"), std::string("x\0y\r\n", 5)}, {directory.file("b"), ""}});
  CHECK(content(directory.file("a")) == std::string("x\0y\r\n", 5));
  CHECK(directory.entries() == 2);
}

TEST_CASE("either all files are written or none, and what was there stays") {
  const Directory directory;
  write_files({{directory.file("a"), "old"}});
  CHECK_THROWS_AS(write_files({{directory.file("a"), "new"}, {directory.file("missing/b"), "new"}}), UnwritableFile);
  CHECK(content(directory.file("a")) == "old");
  CHECK(directory.entries() == 1);
}

TEST_CASE("asking whether a path is writable leaves no trace") {
  const Directory directory;
  require_writable({directory.file("a.csv"), directory.file("a.npz")});
  CHECK(directory.entries() == 0);
}

TEST_CASE("an unwritable path is named with the system's reason") {
  const Directory directory;
  try {
    require_writable({directory.file("missing/a.csv")});
    FAIL("a path in a directory that does not exist was accepted");
  } catch (const UnwritableFile& error) {
    const std::string message = error.what();
    CHECK(message.find(directory.file("missing/a.csv")) != std::string::npos);
    CHECK(message.find("No such file or directory") != std::string::npos);
  }
  CHECK_THROWS_AS(require_writable({directory.path.string()}), UnwritableFile);
}
