#pragma once
// SPDX-License-Identifier: MIT
//
// qdot: motion from a Lagrangian. This list is the table of contents, in the order of the theory.
// Steppers that need SUNDIALS are apart: include <qdot/integrate/cvode.hpp> and link qdot::cvode.

#include "qdot/error.hpp"

#include "qdot/ad/dual.hpp"         // numbers that carry their derivatives
#include "qdot/ad/dual_math.hpp"    // their sine, root, power …
#include "qdot/ad/derivatives.hpp"  // gradient, jacobian, hessian

#include "qdot/mechanics/system.hpp"               // T and V, notation and signs
#include "qdot/mechanics/energy.hpp"               // L, E, p, Jacobi's energy function
#include "qdot/mechanics/mass_matrix.hpp"          // M, and what it means when it is singular
#include "qdot/mechanics/equations_of_motion.hpp"  // M q̈ = rhs
#include "qdot/mechanics/first_order_form.hpp"     // ẏ = f(t, y) for steppers
