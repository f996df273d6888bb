#pragma once
// SPDX-License-Identifier: MIT
//
// What a study of accuracy is turned into: text, JSON, CSV, a page and a picture.

#include <string>
#include <vector>

#include "program/runnable_scene.hpp"
#include "qdot/analysis/work_precision_study.hpp"

namespace qdot::program {

/// A study with what it was made of.
struct SceneStudy {
  const RunnableScene& scene;
  State<Dynamic> start;
  double t_end = 0;
  WorkPrecision study;
  std::string machine;  // processor, compiler
  bool brief = false;   // only what is needed is printed, the cheapest way first
};

/// The files that `--out PATH` writes: PATH.csv, PATH.html and PATH.svg.
std::vector<std::string> accuracy_paths(const std::string& path);

/// The table of all measurements and the cheapest way to each accuracy, for people; if brief, the cheapest way first, and only the measurements that it names.
std::string accuracy_text(const SceneStudy& of);

/// The measurements and the cheapest way to each accuracy as one JSON object.
std::string accuracy_json(const SceneStudy& of, const std::vector<std::string>& files);

/// One line for each measurement.
std::string accuracy_csv(const SceneStudy& of);

/// All pictures and tables, one self-contained page.
std::string accuracy_html(const SceneStudy& of);

/// Largest error against CPU time, one picture.
std::string accuracy_svg(const SceneStudy& of);

}  // namespace qdot::program
