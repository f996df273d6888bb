// SPDX-License-Identifier: MIT
#include "program/scene_file.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <sstream>
#include <system_error>
#include <vector>

#include "scene_compiler.hpp"  // made by CMake: the compiler, its options, and the archives of what depends on no scene

extern char** environ;

namespace qdot::program {

namespace {

namespace fs = std::filesystem;

std::string content(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Fowler, Noll and Vo's 64-bit hash, FNV-1a.
class Hash {
 public:
  void add(const std::string& text) {
    for (const char c : text) value_ = (value_ ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
    value_ = (value_ ^ 0xffu) * 0x100000001b3u;  // where one text ends
  }
  std::string text() const {
    char digits[17];
    std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(value_));
    return digits;
  }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

/// Where libraries are kept.
fs::path cache_directory() {
  const auto from = [](const char* variable) {
    const char* value = std::getenv(variable);
    return value != nullptr && value[0] == '/' ? fs::path(value) : fs::path();
  };
  fs::path place = from("XDG_CACHE_HOME");
  if (place.empty() && !from("HOME").empty()) place = from("HOME") / ".cache";
  std::error_code failed;
  for (const fs::path& candidate : {place / "qdot", fs::temp_directory_path(failed) / ("qdot-" + std::to_string(getuid()))}) {
    if (!candidate.is_absolute()) continue;
    fs::create_directories(candidate, failed);
    struct stat about = {};  // what others can write, they can have loaded
    if (!failed && stat(candidate.c_str(), &about) == 0 && about.st_uid == getuid() && access(candidate.c_str(), W_OK) == 0) return candidate;
  }
  throw UsageError("SCENE: must have a place for what is compiled, but neither $XDG_CACHE_HOME/qdot nor ~/.cache/qdot can be written; set XDG_CACHE_HOME");
}

/// The files that a make rule names behind its colon.
std::vector<std::string> dependencies(const std::string& rule) {
  std::vector<std::string> files(1);
  const std::size_t colon = rule.find(": ");
  for (std::size_t i = colon == std::string::npos ? rule.size() : colon + 2; i < rule.size(); ++i) {
    const char c = rule[i], next = i + 1 < rule.size() ? rule[i + 1] : '\0';
    if (c == '\\' && next == '\n') {
      ++i;
    } else if ((c == '\\' && (next == ' ' || next == '#')) || (c == '$' && next == '$')) {
      files.back() += next;
      ++i;
    } else if (c != ' ' && c != '\n') {
      files.back() += c;
    } else if (!files.back().empty()) {
      files.emplace_back();
    }
  }
  if (files.back().empty()) files.pop_back();
  return files;
}

/// One scene's entries in the cache.
struct Entries {
  fs::path rule;  // which files the library depended on when it was compiled last
  fs::path log;   // what the compiler said
  fs::path stem;  // of libraries, one for each content of those files

  Entries(const fs::path& source, const std::vector<std::string>& command) {
    Hash key;
    for (const std::string& word : command) key.add(word);
    std::error_code unknown;
    for (const fs::path& place : {fs::path(command.front()), source}) key.add(fs::weakly_canonical(place, unknown).string());
    key.add(std::to_string(fs::file_size(command.front(), unknown)));  // the compiler, if it was replaced by another
    stem = cache_directory() / (source.stem().string().substr(0, 40) + "-" + key.text());
    rule = stem.string() + ".d";
    log = stem.string() + ".log";
  }

  /// The library for what the files hold now, whether it is there or not; nothing before the first compilation.
  std::optional<fs::path> library(const fs::path& rule_file) const {
    const std::vector<std::string> files = dependencies(content(rule_file));
    if (files.empty()) return std::nullopt;
    Hash contents;
    for (const std::string& file : files) contents.add(content(file));
    return stem.string() + "-" + contents.text() + ".so";
  }

  /// Removes all but the newest libraries of the scene.
  void forget_old() const {
    constexpr std::size_t kept = 4;
    std::vector<std::pair<fs::file_time_type, fs::path>> all;
    std::error_code gone;
    for (const auto& entry : fs::directory_iterator(stem.parent_path(), gone)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with(stem.filename().string() + "-") && name.ends_with(".so")) all.emplace_back(fs::last_write_time(entry.path(), gone), entry.path());
    }
    std::ranges::sort(all, std::ranges::greater{});
    for (std::size_t i = kept; i < all.size(); ++i) fs::remove(all[i].second, gone);
  }
};

/// Runs a command with all that it says in a file. Returns its exit status, or −1 if it ended otherwise.
///
/// @throws UsageError  there is no such command
int status_of(std::vector<std::string> command, const fs::path& log) {
  std::vector<char*> arguments;
  for (std::string& word : command) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  pid_t child = 0;
  const int error = posix_spawnp(&child, arguments.front(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    throw UsageError("SCENE: must be compiled by the compiler that made qdot, but " + command.front() + " cannot be started (" + std::strerror(error) +
                     "); install it, or build qdot with another");
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// What a log says is wrong, in one line: the library's own words where it has some, the first error otherwise; and where in the user's file.
std::string first_error(const std::string& log, const std::string& source) {
  std::istringstream lines(log);
  std::string line, error, place;
  while (std::getline(lines, line)) {
    if (place.empty() && line.starts_with(source + ":")) {
      const std::string rest = line.substr(source.size() + 1);
      const std::string number = rest.substr(0, rest.find_first_not_of("0123456789"));
      if (!number.empty()) place = number;
    }
    const std::size_t at = line.find("error: ");
    if (at == std::string::npos) continue;
    const std::size_t words = line.find("qdot: ", at);
    if (line.find("static assertion failed", at) != std::string::npos && words != std::string::npos) {
      error = line.substr(words);
      break;
    }
    if (error.empty()) error = line.substr(at);
  }
  if (error.empty()) return "the compiler ended without a message";
  return (place.empty() ? "" : "line " + place + ": ") + error;
}

/// The compiler's errors with the lines that they show, those in the user's file before others, as many as one reads; and where all of it is.
std::string details(const std::string& text, const std::string& source, const fs::path& log) {
  constexpr std::size_t most = 5;
  std::vector<std::string> here, elsewhere, seen;
  std::istringstream lines(text);
  std::string line;
  std::string* open = nullptr;
  while (std::getline(lines, line)) {
    if (const std::size_t at = line.find("error: "); at != std::string::npos) {
      const std::string place = line.substr(0, at);
      open = nullptr;
      if (std::ranges::find(seen, place) != seen.end()) continue;  // the same place with another scalar
      seen.push_back(place);
      auto& errors = line.starts_with(source + ":") ? here : elsewhere;
      errors.push_back(line + "\n");
      open = &errors.back();
    } else if (open != nullptr && line.starts_with(" ") && line.find('|') != std::string::npos) {  // the line of code, and what points into it
      *open += line + "\n";
    } else {
      open = nullptr;
    }
  }
  const std::size_t count = here.size() + elsewhere.size();
  here.insert(here.end(), elsewhere.begin(), elsewhere.end());
  std::string shown;
  for (std::size_t i = 0; i < std::min(count, most); ++i) shown += here[i];
  if (count == 0) shown = text.substr(0, 2000);  // of the linker, perhaps
  return shown + (count > most ? "and " + std::to_string(count - most) + " more. " : "") + "All that the compiler said: " + log.string() + "\n";
}

/// Compiles a file, and returns the library in the cache.
fs::path compiled(const std::string& given, const fs::path& source, std::vector<std::string> command, const Entries& entries) {
  const std::string unfinished = entries.stem.string() + "." + std::to_string(getpid());
  const fs::path library = unfinished + ".so", rule = unfinished + ".d", log = unfinished + ".log";
  command.insert(command.end(), {"-fPIC", "-shared", "-MMD", "-MT", "scene", "-MF", rule.string(), "-o", library.string(), source.string()});
  if (std::ranges::all_of(compiled_archives, [](const char* archive) { return fs::exists(archive); })) {
    command.insert(command.end(), {"-DQDOT_COMPILED", "-DQDOT_COMPILED_MODELS"});
    command.insert(command.end(), std::begin(compiled_archives), std::end(compiled_archives));
  }
  const bool watched = isatty(STDERR_FILENO) != 0;
  if (watched) std::fprintf(stderr, "Compiling %s, which takes some ten seconds and is done once …", given.c_str());
  const int status = status_of(command, log);
  if (watched) std::fputs("\r\x1b[K", stderr);
  fs::rename(log, entries.log);
  std::error_code gone;
  if (status != 0) {
    for (const fs::path& file : {library, rule}) fs::remove(file, gone);
    const std::string text = content(entries.log);
    throw SceneFileError("SCENE: must compile, given " + given + "; " + first_error(text, source.string()), details(text, source.string(), entries.log));
  }
  const std::optional<fs::path> place = entries.library(rule);
  if (!place) throw Error("the compiler did not say what " + given + " depends on, see " + entries.log.string());
  fs::rename(library, *place);
  fs::rename(rule, entries.rule);
  entries.forget_old();
  return *place;
}

using Make = std::unique_ptr<RunnableScene>();

/// The function qdot_scene() of a library; its name is the one that compilers for Linux and macOS agreed upon.
Make* made_by(const std::string& given, const fs::path& library) {
  void* handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) throw UsageError("SCENE: must be complete, given " + given + ", which lacks something: " + dlerror());
  void* symbol = dlsym(handle, "_Z10qdot_scenev");
  if (symbol == nullptr) {
    throw UsageError("SCENE: must define OwnScene qdot_scene(), outside of all namespaces and not static, given " + given +
                     ", which does not; `qdot new NAME` writes an example");
  }
  return reinterpret_cast<Make*>(symbol);
}

}  // namespace

bool is_scene_file(const std::string& name) {
  return name.ends_with(".cpp") || name.ends_with(".cc") || name.ends_with(".cxx");
}

std::string scene_name_of(const std::string& path) { return fs::path(path).stem().string(); }

std::function<std::unique_ptr<RunnableScene>()> scene_maker_of_file(const std::string& path) {
  std::error_code unknown;
  const fs::path source = fs::weakly_canonical(path, unknown);
  if (!fs::is_regular_file(source, unknown) || access(source.c_str(), R_OK) != 0) {
    throw UsageError("SCENE: must be a name from qdot list or a file of C++, given \"" + path + "\", which cannot be read");
  }
  const std::vector<std::string> command(std::begin(scene_compiler), std::end(scene_compiler));
  const Entries entries(source, command);
  std::optional<fs::path> library = entries.library(entries.rule);
  if (!library || !fs::exists(*library, unknown)) library = compiled(path, source, command, entries);
  Make* const make = made_by(path, *library);
  return [path, make] {
    try {
      std::unique_ptr<RunnableScene> scene = make();
      if (!scene) throw InvalidValue("qdot_scene() must return a scene, but returns none");
      if (scene->name().empty()) scene->set_name(scene_name_of(path));
      return scene;
    } catch (const std::exception& error) {
      throw UsageError("SCENE: " + path + ": " + error.what());
    }
  };
}

}  // namespace qdot::program
