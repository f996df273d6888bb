// SPDX-License-Identifier: MIT
#include "program/methods.hpp"

#include "program/arguments.hpp"

namespace qdot::program {

const std::vector<MethodInfo>& methods() {
  using enum MethodKind;
  static const std::vector<MethodInfo> all = {
      {"auto", automatic, 0, "chooses among taylor, dop853 and bdf, and says why (the default)"},
      {"taylor", series, 0, "power series of the motion: T, V, effects and constraints that are formulas, many digits"},
      {"dop853", explicit_, 0, "explicit Runge-Kutta of order 8: smooth motion, constraints too"},
      {"dopri5", explicit_, 0, "explicit Runge-Kutta of order 5: few digits"},
      {"adams", multistep, 0, "CVODE's Adams methods: smooth motion without constraints"},
      {"bdf", stiff, 0, "CVODE's BDF: stiff motion, constraints too"},
      {"gauss2", gauss, 2, "symplectic for any T and V, fixed step; takes effects too: the midpoint rule"},
      {"gauss4", gauss, 4, "the same of order 4"},
      {"gauss6", gauss, 6, "the same of order 6"},
      {"gauss8", gauss, 8, "the same of order 8"},
      {"verlet", splitting, 2, "symplectic, fixed step, explicit, for T(qdot): leapfrog"},
      {"yoshida_4", splitting, 4, "the same of order 4"},
      {"mclachlan_atela_4", splitting, 4, "the same of order 4"},
      {"blanes_moan_4", splitting, 4, "the same of order 4, the most accurate"},
      {"kahan_li_6", splitting, 6, "the same of order 6"},
      {"blanes_moan_6", splitting, 6, "the same of order 6, the most accurate"},
      {"kahan_li_8", splitting, 8, "the same of order 8"},
      {"rattle2", rattle, 2, "symplectic on constraints, fixed step, for T(qdot) without forces"},
      {"rattle4", rattle, 4, "the same of order 4"},
      {"rattle6", rattle, 6, "the same of order 6"},
  };
  return all;
}

const MethodInfo& method_named(const std::string& name) {
  std::vector<std::string> names;
  for (const MethodInfo& method : methods()) {
    if (method.name == name) return method;
    names.push_back(method.name);
  }
  throw unknown_name("--method", "a method", name, names);
}

}  // namespace qdot::program
