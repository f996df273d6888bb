#pragma once
// SPDX-License-Identifier: MIT
//
// SUNDIALS 6 and 7: every difference between the versions is in this file.
//
//                          6.x                                    7.x
//     context              SUNContext_Create(void*, …), nullptr   SUNContext_Create(SUNComm, …), SUN_COMM_NULL
//     error messages       CVodeSetErrHandlerFn(mem, f, data)     SUNContext_PushErrHandler(ctx, f, data), after
//                                                                 clearing the default one, which prints
//     warnings             to that handler, as CV_WARNING         to the context's logger only
//     a setter returns     int                                    SUNErrCode, an int too
//
// SUNDIALS objects are freed in this order: solver memory, nonlinear solver, linear solver, matrix, vectors, and the context
// last, because all use it. The handles below own them; a class declares the context first and the solver memory last.
//
// Nothing of SUNDIALS is in the library's public interface. qdot::cvode links it without MPI's C++ bindings.

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_config.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>
#include <sunnonlinsol/sunnonlinsol_newton.h>

#include <Eigen/Core>
#include <limits>
#include <string>
#include <utility>

#include "qdot/error.hpp"

#if !defined(SUNDIALS_VERSION_MAJOR) || SUNDIALS_VERSION_MAJOR < 6
#error "qdot needs SUNDIALS 6.0 or newer (Debian 12, Ubuntu 24.04, Fedora, Homebrew, conda-forge and vcpkg have it)"
#endif
#if SUNDIALS_VERSION_MAJOR >= 7
#include <sundials/sundials_logger.h>
#endif

namespace qdot::detail::cvode {

static_assert(sizeof(sunrealtype) == sizeof(double), "qdot: this SUNDIALS was built for another precision than double");

/// Called for every message of SUNDIALS instead of printing it; `is_warning` where the version tells.
using MessageHandler = void (*)(bool is_warning, const char* text, void* data) noexcept;

struct Messages {
  MessageHandler handler;
  void* data;
};

/// Owns one of SUNDIALS' objects: what std::unique_ptr does, which is a tuple and fifty functions for each type of object.
template <class Pointer, auto destroy>
class Handle {
 public:
  Handle() = default;
  explicit Handle(Pointer object) noexcept : object_(object) {}
  Handle(Handle&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(object_, other.object_);
    return *this;
  }
  ~Handle() {
    if (object_ != nullptr) destroy(object_);
  }
  Pointer get() const noexcept { return object_; }

 private:
  Pointer object_ = nullptr;
};

inline void free_context(SUNContext context) noexcept { SUNContext_Free(&context); }
inline void free_memory(void* memory) noexcept { CVodeFree(&memory); }
inline void free_linear_solver(SUNLinearSolver solver) noexcept { SUNLinSolFree(solver); }
inline void free_nonlinear_solver(SUNNonlinearSolver solver) noexcept { SUNNonlinSolFree(solver); }

using ContextHandle = Handle<SUNContext, free_context>;
using VectorHandle = Handle<N_Vector, N_VDestroy>;
using MatrixHandle = Handle<SUNMatrix, SUNMatDestroy>;
using LinearSolverHandle = Handle<SUNLinearSolver, free_linear_solver>;
using NonlinearSolverHandle = Handle<SUNNonlinearSolver, free_nonlinear_solver>;
using MemoryHandle = Handle<void*, free_memory>;

/// The index type of this SUNDIALS may be 32 bits wide.
inline sunindextype index(Eigen::Index n) {
  if (n > static_cast<Eigen::Index>(std::numeric_limits<sunindextype>::max()))
    throw_invalid_value({"this SUNDIALS counts components with ", 8 * sizeof(sunindextype), " bits, but the system has ", n,
                         "; use a build with 64-bit indices"});
  return static_cast<sunindextype>(n);
}

[[noreturn, gnu::cold, gnu::noinline]] inline void throw_not_made(const char* what) {
  throw Error(sentence({"SUNDIALS could not make its ", what, "; is there memory left?"}));
}

/// Passes on a constructed object, or says that there was no memory for it.
template <class Owner, class Pointer>
Owner owned(Pointer object, const char* what) {
  if (object == nullptr) throw_not_made(what);
  return Owner(object);
}

#if SUNDIALS_VERSION_MAJOR >= 7

/// A context of its own for every solver, with all printing switched off before anything else is made.
inline ContextHandle make_context(Messages& messages) {
  SUNContext raw = nullptr;
  if (SUNContext_Create(SUN_COMM_NULL, &raw) != 0) raw = nullptr;
  ContextHandle context = owned<ContextHandle>(raw, "context");
  SUNContext_ClearErrHandlers(raw);
  SUNContext_PushErrHandler(
      raw,
      [](int, const char*, const char*, const char* text, SUNErrCode, void* data, SUNContext) {
        const Messages& to = *static_cast<const Messages*>(data);
        to.handler(false, text, to.data);
      },
      &messages);
  SUNLogger logger = nullptr;
  if (SUNContext_GetLogger(raw, &logger) == 0 && logger != nullptr) {
    SUNLogger_SetErrorFilename(logger, "");
    SUNLogger_SetWarningFilename(logger, "");
  }
  return context;
}

/// Nothing more to redirect: the context's handler serves its solvers.
inline int redirect_messages(void*, Messages&) { return CV_SUCCESS; }

#else

inline ContextHandle make_context(Messages&) {
  SUNContext raw = nullptr;
  if (SUNContext_Create(nullptr, &raw) != 0) raw = nullptr;
  return owned<ContextHandle>(raw, "context");
}

/// Sends the messages of one solver to `messages` instead of stderr.
inline int redirect_messages(void* memory, Messages& messages) {
  return CVodeSetErrHandlerFn(
      memory,
      [](int code, const char*, const char*, char* text, void* data) {
        const Messages& to = *static_cast<const Messages*>(data);
        to.handler(code == CV_WARNING, text, to.data);
      },
      &messages);
}

#endif

}  // namespace qdot::detail::cvode
