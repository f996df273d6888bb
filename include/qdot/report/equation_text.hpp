#pragma once
// SPDX-License-Identifier: MIT
//
// Equations as text: for a terminal, for LaTeX, for a page.

#include <string>

#include "qdot/report/equations.hpp"
#include "qdot/report/equations/expression.hpp"
#include "qdot/report/equations/latex_notation.hpp"
#include "qdot/report/equations/mathml_notation.hpp"
#include "qdot/report/equations/plain_notation.hpp"

namespace qdot::report {

/// Each section under its heading, one equation a line.
inline std::string plain_text(const Equations& equations) {
  const PlainNotation notation;
  std::string text;
  for (const EquationSection& section : equations.sections()) {
    text += (text.empty() ? "" : "\n") + section.heading + "\n";
    for (const Equation& e : section.equations) text += "  " + text_of(e.left, notation) + " = " + text_of(e.right, notation) + "\n";
  }
  return text;
}

/// One align* environment for each section, which amsmath has.
inline std::string latex_text(const Equations& equations) {
  const LatexNotation notation;
  std::string text;
  for (const EquationSection& section : equations.sections()) {
    text += "% " + section.heading + "\n\\begin{align*}\n";
    for (const Equation& e : section.equations) {
      const bool is_last = &e == &section.equations.back();
      text += "  " + text_of(e.left, notation) + " &= " + text_of(e.right, notation) + (is_last ? "\n" : " \\\\\n");
    }
    text += "\\end{align*}\n";
  }
  return text;
}

/// Headings and <math> elements.
inline std::string mathml_text(const Equations& equations) {
  const MathmlNotation notation;
  std::string text;
  for (const EquationSection& section : equations.sections()) {
    text += "<h3>" + section.heading + "</h3>\n<div>\n";
    for (const Equation& e : section.equations)
      text += "<p><math displaystyle=\"true\"><mrow>" + text_of(e.left, notation) + "</mrow><mo>=</mo><mrow>" + text_of(e.right, notation) +
              "</mrow></math></p>\n";
    text += "</div>\n";
  }
  return text;
}

}  // namespace qdot::report
