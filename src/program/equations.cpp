// SPDX-License-Identifier: MIT
//
// qdot equations SCENE: L, p, M, Lagrange's equations and q̈ as formulas, in the scene's names; or q̈ and its Jacobian as a C file.
#include <cstdio>
#include <memory>
#include <string>

#include "program/arguments.hpp"
#include "program/catalogue.hpp"
#include "program/commands.hpp"
#include "qdot/report/c_code.hpp"
#include "qdot/report/equation_text.hpp"
#include "qdot/report/equations.hpp"
#include "qdot/report/file.hpp"

namespace qdot::program {

int equations(const EquationsOptions& options) {
  if (options.c && (options.latex || options.mathml)) throw UsageError("--c: must stand without --latex and --mathml, given together with one");
  if (options.latex && options.mathml) throw UsageError("--latex: must stand without --mathml, given together with it");
  const std::unique_ptr<RunnableScene> scene = make_scene(options.scene);
  configured(*scene, options.set);
  const report::EquationSource source = scene->equation_source();
  if (source.coordinates.size() > report::most_coordinates_to_read) {
    throw UsageError("SCENE: must have at most " + std::to_string(report::most_coordinates_to_read) + " coordinates for formulas of it, but has " +
                     std::to_string(source.coordinates.size()));
  }
  if (options.c) {
    try {
      report::write_files({{*options.c, report::c_code(source, scene->name())}});
    } catch (const report::UnwritableFile& error) {
      throw UsageError(std::string("--c: ") + error.what());
    } catch (const InvalidValue& error) {  // constraints
      throw UsageError(std::string("--c: ") + error.what());
    }
    return 0;
  }
  const report::Equations equations = report::equations_of(source);
  std::fputs((options.latex ? report::latex_text(equations) : options.mathml ? report::mathml_text(equations) : report::plain_text(equations)).c_str(), stdout);
  return 0;
}

}  // namespace qdot::program
