// SPDX-License-Identifier: MIT
//
// qdot new NAME: a file with a scene that runs, to begin with.
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>

#include "program/arguments.hpp"
#include "program/commands.hpp"
#include "program/scene_file.hpp"
#include "qdot/report/file.hpp"

namespace qdot::program {

namespace {

// Own and own stand for the scene's name.
constexpr const char* own = R"(// A scene for the program qdot:  qdot run own.cpp --out out/own
#include <scenes/own_scene.hpp>
using namespace qdot::scenes;

struct Own {
  double m = 1.0, l = 1.0, g = 9.81;
  constexpr auto T(const auto& qdot) const { return 0.5 * m * l * l * qdot[0] * qdot[0]; }
  constexpr auto V(const auto& q) const { using std::cos; return -m * g * l * cos(q[0]); }
  auto bob(const auto& q) const { return Point{l * std::sin(q[0]), -l * std::cos(q[0])}; }
};

OwnScene qdot_scene() {
  return runnable(
      Scene<Own, 1>{.summary = "A bob on a massless rod; the angle is measured from the downward vertical.",
                    .parameters = {{"m", &Own::m, "kg", Range::positive, "mass of the bob"},
                                   {"l", &Own::l, "m", Range::positive, "length of the rod"},
                                   {"g", &Own::g, "m/s^2", Range::between(0, 100), "gravity"}},
                    .coordinates = {{"theta", "rad"}},
                    .start = {2.0},  // and the velocity after it, if it is not zero
                    .drawing = {trail(1), line({0, 1}), pivot(0), disk(1)},
                    .positions = [](const Own& s, const auto& q) -> std::vector<Point> { return {{0, 0}, s.bob(q)}; }},
      optional_effect<Own>("damping", 0.2, "N m s", Range::non_negative, "torque per angular velocity",
                           [](const Own&, double c) { return qdot::viscous_damping(qdot::Vector<double, 1>(c)); }));
}
)";

/// "own_scene" as a type is called, OwnScene.
std::string type_name(const std::string& name) {
  std::string type;
  bool upper = true;
  for (const char c : name) {
    if (c != '_') type += upper ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    upper = c == '_';
  }
  return type;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) text.replace(at, from.size(), to);
  return text;
}

}  // namespace

int new_scene(const NewOptions& options) {
  const std::string path = is_scene_file(options.name) ? options.name : options.name + ".cpp";
  const std::string name = scene_name_of(path);
  const auto fits = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'; };
  bool good = !name.empty() && std::isalpha(static_cast<unsigned char>(name.front())) != 0;
  for (const char c : name) good = good && fits(c);
  if (!good) throw UsageError("NAME: must begin with a letter and be of letters, digits and _, given \"" + name + "\"");
  std::error_code unknown;
  if (std::filesystem::exists(std::filesystem::symlink_status(path, unknown))) {
    throw UsageError("NAME: must be that of a file that is not there yet, given " + path + ", which is");
  }
  const std::string type = type_name(name);
  std::string text = own;
  for (const auto& [from, to] : {std::pair<std::string, std::string>{"struct Own ", "struct " + type + " "},
                                 {"Scene<Own,", "Scene<" + type + ","},
                                 {"&Own::", "&" + type + "::"},
                                 {"const Own&", "const " + type + "&"},
                                 {"effect<Own>", "effect<" + type + ">"},
                                 {"own.cpp", std::filesystem::path(path).filename().string()},
                                 {"out/own", "out/" + name}})
    text = replaced(text, from, to);
  try {
    report::write_files({{path, text}});
  } catch (const report::UnwritableFile& error) {
    throw UsageError(std::string("NAME: ") + error.what());
  }
  std::printf("wrote %s; now: qdot run %s --out out/%s\n", path.c_str(), path.c_str(), name.c_str());
  return 0;
}

}  // namespace qdot::program
