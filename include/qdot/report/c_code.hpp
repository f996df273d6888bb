#pragma once
// SPDX-License-Identifier: MIT
//
// The equations of a system as one C99 file that needs nothing but <math.h>.
//
// It has two functions, of coordinates, velocities, the time and the parameters:
//
//     int NAME_acceleration(q, qdot, t, p, qddot)
//     int NAME_jacobian(q, qdot, t, p, qddot, d_q, d_qdot)        ∂q̈/∂q and ∂q̈/∂q̇, row by row
//
// Both form M and r by the formulas that report/equations/derivation.hpp writes down and solve M q̈ = r by elimination with pivots; the second differentiates
//
//     M ∂q̈/∂x = ∂(r − M a)/∂x      at fixed a = q̈ .
//
// They return 0, or 1 where M is singular. Parameters that are no letters are numbers in the formulas.

#include <cctype>
#include <cstddef>
#include <string>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/mechanics/derive/by_terms.hpp"
#include "qdot/mechanics/derive/derivatives_of_graph.hpp"
#include "qdot/mechanics/derive/derived_equations.hpp"
#include "qdot/report/equations/derivation.hpp"
#include "qdot/report/equations/parameter_letters.hpp"
#include "qdot/report/equations/source.hpp"
#include "qdot/report/number.hpp"

namespace qdot::report {

namespace detail {

/// Writes the file.
class CCode {
 public:
  CCode(const EquationSource& source, const std::string& name) : source_(source), n_(static_cast<int>(source.coordinates.size())), d_(n_) {
    for (const char c : name) name_ += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
    if (name_.empty() || std::isdigit(static_cast<unsigned char>(name_[0])) != 0) name_ = "system_" + name_;
    const int first = 3 * n_ + 1;
    for (std::size_t j = 0; j < source.parameters.size(); ++j) d_.graph.variable(first + static_cast<int>(j));
    const ParameterLetters letters(source.record, source.values);
    named_ = letters.named();
    const std::vector<int> outputs = letters.written(d_.graph, first);
    if (outputs.size() > 2)
      qdot::detail::throw_invalid_value({"a C file must be of T and V alone, but there are also ", static_cast<long>(outputs.size() - 2),
                                         outputs.size() == 3 ? " constraint" : " constraints", "; take coordinates that meet them by themselves"});
    equations_ = d_.jacobian_by_terms(outputs[0], outputs[1]);
    if (!d_.is_possible) derive_by_graph(outputs[0], outputs[1]);
  }

  std::string text() const {
    std::vector<int> equations = equations_.mass, all;
    equations.insert(equations.end(), equations_.right.begin(), equations_.right.end());
    all = equations;
    all.insert(all.end(), equations_.slopes.begin(), equations_.slopes.end());
    const std::string n = std::to_string(n_), arguments = "(const double *q, const double *qdot, double t, const double *p, double *qddot";
    std::vector<char> written(d_.graph.nodes().size(), 0);
    const std::string solve = matrix() + "  if (" + name_ + "_factor(M, order)) return 1;\n  " + name_ + "_solve(M, order, b, qddot, 1);\n";
    std::string text = opening() + algebra();
    text += "int " + name_ + "_acceleration" + arguments + ") {\n  double M[" + n + "][" + n + "], b[" + n + "];\n  int order[" + n + "];\n";
    text += unused() + lines(equations, written);
    text += solve + "  return 0;\n}\n\n";
    written.assign(written.size(), 0);
    text += "int " + name_ + "_jacobian" + arguments + ", double *d_q, double *d_qdot) {\n  double M[" + n + "][" + n + "], b[" + n +
            "];\n  int order[" + n + "], k;\n";
    text += unused() + lines(equations, written);
    text += solve + "  {\n";
    text += lines(all, written);
    text += "    double slope[" + n + "][" + std::to_string(2 * n_) + "];\n";
    for (int i = 0; i < n_; ++i)
      for (int j = 0; j < 2 * n_; ++j)
        text += "    slope[" + std::to_string(i) + "][" + std::to_string(j) +
                "] = " + value(equations_.slopes[static_cast<std::size_t>(2 * n_ * i + j)]) + ";\n";
    text += "    for (k = 0; k < " + std::to_string(2 * n_) + "; ++k) {\n      int i;\n      for (i = 0; i < " + n +
            "; ++i) b[i] = slope[i][k];\n      " + name_ + "_solve(M, order, b, k < " + n + " ? d_q + k : d_qdot + (k - " + n + "), " + n +
            ");\n    }\n  }\n  return 0;\n}\n";
    return text;
  }

 private:
  // What the derivation by terms can't multiply out.
  void derive_by_graph(int T, int V) {
    auto& g = d_.graph;
    const qdot::detail::GraphEquations e = qdot::detail::equations_by_graph(g, n_, T, V);
    equations_ = {.mass = e.mass, .right = e.right, .slopes = {}};
    differentiate(g, n_, equations_);
  }
  static std::size_t entry(int i, int j) { return static_cast<std::size_t>(i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i); }

  std::string opening() const {
    const auto word = [](const std::string& name) {  // inside of a comment
      std::string text;
      for (const char c : name) text += c == '*' || static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
      return text;
    };
    std::string text = "/* Equations of motion, written by qdot. C99, needs <math.h> only.\n *\n";
    for (int i = 0; i < n_; ++i) text += " * q[" + std::to_string(i) + "] " + word(source_.coordinates[static_cast<std::size_t>(i)]) + "\n";
    for (std::size_t j = 0; j < source_.parameters.size(); ++j)
      text += " * p[" + std::to_string(j) + "] " + word(source_.parameters[j]) + (named_[j] ? "" : ", a number in the formulas: ") +
              (named_[j] ? ", was " : "") + exact_text(source_.values[j]) + "\n";
    return text + " *\n * " + name_ + "_acceleration writes qddot; " + name_ + "_jacobian also its derivatives by q and qdot, row by row.\n" +
           " * Both return 0, or 1 where the mass matrix is singular. */\n#include <math.h>\n\n" +
           "int " + name_ + "_acceleration(const double *q, const double *qdot, double t, const double *p, double *qddot);\n" +
           "int " + name_ + "_jacobian(const double *q, const double *qdot, double t, const double *p, double *qddot, double *d_q, double *d_qdot);\n\n";
  }

  // L U with the rows in another order, and its use.
  std::string algebra() const {
    const std::string n = std::to_string(n_);
    return "static int " + name_ + "_factor(double M[" + n + "][" + n + "], int *order) {\n  int i, j, k;\n  for (i = 0; i < " + n +
           "; ++i) order[i] = i;\n  for (k = 0; k < " + n + "; ++k) {\n    int best = k;\n    for (i = k + 1; i < " + n +
           "; ++i)\n      if (fabs(M[order[i]][k]) > fabs(M[order[best]][k])) best = i;\n" +
           "    i = order[k];\n    order[k] = order[best];\n    order[best] = i;\n    if (!(fabs(M[order[k]][k]) > 0.0)) return 1;\n    for (i = k + 1; i < " +
           n + "; ++i) {\n      double *row = M[order[i]];\n      row[k] /= M[order[k]][k];\n      for (j = k + 1; j < " + n +
           "; ++j) row[j] -= row[k] * M[order[k]][j];\n    }\n  }\n  return 0;\n}\n\n" + "static void " + name_ + "_solve(double M[" + n +
           "][" + n + "], const int *order, const double *b, double *x, int stride) {\n  int i, j;\n  for (i = 0; i < " + n +
           "; ++i) {\n    x[i * stride] = b[order[i]];\n    for (j = 0; j < i; ++j) x[i * stride] -= M[order[i]][j] * x[j * stride];\n  }\n  for (i = " +
           n + " - 1; i >= 0; --i) {\n    for (j = i + 1; j < " + n +
           "; ++j) x[i * stride] -= M[order[i]][j] * x[j * stride];\n    x[i * stride] /= M[order[i]][i];\n  }\n}\n\n";
  }

  std::string matrix() const {
    std::string text;
    for (int i = 0; i < n_; ++i) {
      for (int j = 0; j < n_; ++j) text += "  M[" + std::to_string(i) + "][" + std::to_string(j) + "] = " + value(equations_.mass[entry(i, j)]) + ";\n";
      text += "  b[" + std::to_string(i) + "] = " + value(equations_.right[static_cast<std::size_t>(i)]) + ";\n";
    }
    return text;
  }

  static std::string unused() { return "  (void)q;\n  (void)qdot;\n  (void)t;\n  (void)p;\n"; }

  // One line for each node that the outputs need and that is not written yet.
  std::string lines(const std::vector<int>& outputs, std::vector<char>& written) const {
    const std::vector<char> needed = d_.graph.needed_for(outputs);
    std::string text;
    for (std::size_t w = 0; w < needed.size(); ++w) {
      const auto& node = d_.graph.nodes()[w];
      if (needed[w] == 0 || written[w] != 0 || node.kind == formula::Kind::constant || node.kind == formula::Kind::variable) continue;
      written[w] = 1;
      text += "  const double x" + std::to_string(w) + " = " + operation(static_cast<int>(w)) + ";\n";
    }
    return text;
  }

  static std::string number(double x) {
    std::string text = exact_text(x);
    if (text.find_first_of(".en") == std::string::npos) text += ".0";
    return x < 0.0 ? "(" + text + ")" : text;
  }

  std::string value(int node) const {
    if (node < 0) return "0.0";
    const auto& w = d_.graph[node];
    if (w.kind == formula::Kind::constant) return number(w.c.value);
    if (w.kind != formula::Kind::variable) return "x" + std::to_string(node);
    const auto entry_of = [](const char* list, int i) { return std::string(list) + "[" + std::to_string(i) + "]"; };
    if (w.a < n_) return entry_of("q", w.a);
    if (w.a < 2 * n_) return entry_of("qdot", w.a - n_);
    if (w.a == 2 * n_) return "t";
    return w.a <= 3 * n_ ? entry_of("qddot", w.a - 2 * n_ - 1) : entry_of("p", w.a - 3 * n_ - 1);
  }

  std::string operation(int node) const {
    const auto& w = d_.graph[node];
    switch (w.kind) {
      case formula::Kind::affine: {
        std::string text = scaled(w.ca.value, w.a);
        if (w.b >= 0) text += (w.cb.value < 0.0 ? " - " : " + ") + scaled(w.cb.value < 0.0 ? -w.cb.value : w.cb.value, w.b);
        const double c = w.c.value;
        return c == 0.0 ? text : text + (c < 0.0 ? " - " : " + ") + number(c < 0.0 ? -c : c);
      }
      case formula::Kind::product: return value(w.a) + " * " + value(w.b);
      case formula::Kind::quotient: return value(w.a) + " / " + value(w.b);
      case formula::Kind::power: {
        const double e = w.c.value;
        const std::string x = value(w.a);
        if (e == -1.0) return "1.0 / " + x;
        if (e == -2.0) return "1.0 / (" + x + " * " + x + ")";
        if (e == 0.5) return "sqrt(" + x + ")";
        if (e == -0.5) return "1.0 / sqrt(" + x + ")";
        return "pow(" + x + ", " + number(e) + ")";
      }
      case formula::Kind::function: {
        static constexpr const char* names[] = {"",    "sin",   "cos", "tan",   "asin", "acos", "atan", "atan2", "hypot", "exp",  "expm1",
                                                "log", "log1p", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "cbrt", "erf", "erfc"};
        return std::string(names[static_cast<std::size_t>(w.function)]) + "(" + value(w.a) + (w.b < 0 ? "" : ", " + value(w.b)) + ")";
      }
      default: return value(node);
    }
  }
  std::string scaled(double factor, int node) const {
    return factor == 1.0 ? value(node) : factor == -1.0 ? "-" + value(node) : number(factor) + " * " + value(node);
  }

  const EquationSource& source_;
  int n_;
  qdot::detail::DerivationByTerms d_;
  std::string name_;
  std::vector<bool> named_;
  qdot::detail::DerivedJacobian equations_;
};

}  // namespace detail

/// A C99 file with q̈ and its Jacobian, as functions of q, q̇, t and the parameters in the order in which they were named.
///
/// @param name  what the functions' names begin with
/// @throws InvalidValue                when there are constraints
/// @throws NotOneFormula, NotAnalytic  as equations()
inline std::string c_code(const EquationSource& source, const std::string& name) { return detail::CCode(source, name).text(); }

}  // namespace qdot::report
