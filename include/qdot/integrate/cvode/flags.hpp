#pragma once
// SPDX-License-Identifier: MIT
//
// CVODE's return flags: their names, and what they mean for a run.
//
// The names are our own table, because CVodeGetReturnFlagName allocates and gives the caller the
// string to free. A flag alone rarely tells what happened. "The error test failed repeatedly" can be a pole of the solution or a
// jump of the right-hand side. "The corrector did not converge" is often a right-hand side that gave NaN. So a flag is only the
// last resort; what the callbacks saw (integrate/cvode/callbacks.hpp) and whether h had shrunk to its floor come first.

#include <string>

#include "qdot/integrate/cvode/bridge.hpp"
#include "qdot/integrate/outcome.hpp"

namespace qdot::detail::cvode {

/// The macro's name of a return flag of CVODE 6 or 7, e.g. "CV_ERR_FAILURE".
constexpr const char* flag_name(int flag) noexcept {
  switch (flag) {
    case CV_SUCCESS: return "CV_SUCCESS";
    case CV_TSTOP_RETURN: return "CV_TSTOP_RETURN";
    case CV_ROOT_RETURN: return "CV_ROOT_RETURN";
    case CV_WARNING: return "CV_WARNING";
    case CV_TOO_MUCH_WORK: return "CV_TOO_MUCH_WORK";
    case CV_TOO_MUCH_ACC: return "CV_TOO_MUCH_ACC";
    case CV_ERR_FAILURE: return "CV_ERR_FAILURE";
    case CV_CONV_FAILURE: return "CV_CONV_FAILURE";
    case CV_LINIT_FAIL: return "CV_LINIT_FAIL";
    case CV_LSETUP_FAIL: return "CV_LSETUP_FAIL";
    case CV_LSOLVE_FAIL: return "CV_LSOLVE_FAIL";
    case CV_RHSFUNC_FAIL: return "CV_RHSFUNC_FAIL";
    case CV_FIRST_RHSFUNC_ERR: return "CV_FIRST_RHSFUNC_ERR";
    case CV_REPTD_RHSFUNC_ERR: return "CV_REPTD_RHSFUNC_ERR";
    case CV_UNREC_RHSFUNC_ERR: return "CV_UNREC_RHSFUNC_ERR";
    case CV_RTFUNC_FAIL: return "CV_RTFUNC_FAIL";
    case CV_NLS_INIT_FAIL: return "CV_NLS_INIT_FAIL";
    case CV_NLS_SETUP_FAIL: return "CV_NLS_SETUP_FAIL";
    case CV_CONSTR_FAIL: return "CV_CONSTR_FAIL";
    case CV_NLS_FAIL: return "CV_NLS_FAIL";
    case CV_MEM_FAIL: return "CV_MEM_FAIL";
    case CV_MEM_NULL: return "CV_MEM_NULL";
    case CV_ILL_INPUT: return "CV_ILL_INPUT";
    case CV_NO_MALLOC: return "CV_NO_MALLOC";
    case CV_BAD_K: return "CV_BAD_K";
    case CV_BAD_T: return "CV_BAD_T";
    case CV_BAD_DKY: return "CV_BAD_DKY";
    case CV_TOO_CLOSE: return "CV_TOO_CLOSE";
    case CV_VECTOROP_ERR: return "CV_VECTOROP_ERR";
    case CV_PROJ_MEM_NULL: return "CV_PROJ_MEM_NULL";
    case CV_PROJFUNC_FAIL: return "CV_PROJFUNC_FAIL";
    case CV_REPTD_PROJFUNC_ERR: return "CV_REPTD_PROJFUNC_ERR";
#ifdef CV_CONTEXT_ERR
    case CV_CONTEXT_ERR: return "CV_CONTEXT_ERR";
#endif
    default: return "unknown flag";
  }
}

/// "CV_ERR_FAILURE (-3)".
inline std::string flag_text(int flag) { return sentence({flag_name(flag), " (", flag, ")"}); }

/// True for the flags that say that a step was accepted.
constexpr bool accepted(int flag) noexcept {
  return flag == CV_SUCCESS || flag == CV_TSTOP_RETURN || flag == CV_ROOT_RETURN;
}

/// The outcome of a failed step, as far as the flag alone can tell.
///
/// @param at_floor  h had shrunk to the smallest step that t can still feel
constexpr Outcome outcome_of(int flag, bool at_floor) noexcept {
  switch (flag) {
    case CV_ERR_FAILURE: return at_floor ? Outcome::step_too_small : Outcome::error_test_failure;
    case CV_CONV_FAILURE:
    case CV_NLS_SETUP_FAIL:
    case CV_NLS_FAIL: return at_floor ? Outcome::step_too_small : Outcome::corrector_failure;
    case CV_TOO_MUCH_ACC: return Outcome::accuracy_not_reached;
    case CV_LSETUP_FAIL:
    case CV_LSOLVE_FAIL: return Outcome::linear_solver_failure;
    case CV_RHSFUNC_FAIL:
    case CV_FIRST_RHSFUNC_ERR:
    case CV_REPTD_RHSFUNC_ERR:
    case CV_UNREC_RHSFUNC_ERR: return Outcome::refused_by_model;
    default: return Outcome::solver_error;
  }
}

/// Turns a failed set-up call into an exception; CVODE refuses only what qdot should have checked.
[[gnu::noinline]] inline void require(int flag, const char* call) {
  if (flag < 0) throw Error(sentence({call, " returned ", flag_text(flag), "; please report it"}));
}

}  // namespace qdot::detail::cvode
