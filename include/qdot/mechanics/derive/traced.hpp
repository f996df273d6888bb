#pragma once
// SPDX-License-Identifier: MIT
//
// What was traced from a form's functors: the interface for code that keeps it (mechanics/derive/kept_motion.hpp) and evaluates
// rates.

#include <memory>

#include "qdot/mechanics/derive/recordable_form.hpp"

namespace qdot::detail {

/// What was traced from functors.
struct Traced {
  Traced() = default;
  Traced(const Traced&) = default;
  Traced& operator=(const Traced&) = default;
  virtual ~Traced() = default;
  /// Whether there are equations to go through.
  virtual bool is_known() const = 0;
  virtual std::unique_ptr<Traced> copy() const = 0;
  /// Whether the functors are what was traced.
  virtual bool still_holds(const RecordableForm& form) = 0;
};

/// q̈ and ż of n coordinates that are known at run time (mechanics/derive/traced_motion.hpp).
struct TracedRates : Traced {
  /// q̈, and ż where there are states; false where the general way must see to it.
  virtual bool write(const double* q, const double* qdot, double t, const double* z, double* a, double* zdot) = 0;
  virtual bool mass_is_constant() const = 0;
  virtual bool are_native() const = 0;  // by machine code
  virtual bool are_long() const = 0;    // too long for it
};

}  // namespace qdot::detail
