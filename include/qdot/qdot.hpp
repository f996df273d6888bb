#pragma once
// SPDX-License-Identifier: MIT
//
// qdot: motion from a Lagrangian. This list is the table of contents, in the order of the theory.
// Steppers that need SUNDIALS are apart: include <qdot/integrate/cvode.hpp> and link qdot::cvode.

#include "qdot/error.hpp"

#include "qdot/ad/dual.hpp"         // numbers that carry their derivatives
#include "qdot/ad/dual_math.hpp"    // their sine, root, power …
#include "qdot/ad/derivatives.hpp"  // gradient, jacobian, hessian

#include "qdot/mechanics/velocity.hpp"             // ẋ from x(q), so that nobody writes it by hand
#include "qdot/mechanics/rotation.hpp"             // R(q) and its angular velocity
#include "qdot/mechanics/inertia.hpp"              // inertia tensors of standard bodies, parallel axes
#include "qdot/mechanics/rigid_body.hpp"           // T of a rigid body about G and about any point A
#include "qdot/mechanics/system.hpp"               // T and V, notation and signs
#include "qdot/mechanics/energy.hpp"               // L, E, p, Jacobi's energy function
#include "qdot/mechanics/mass_and_rhs.hpp"         // M and r of M q̈ = r, by the shortest way
#include "qdot/mechanics/mass_matrix.hpp"          // M alone
#include "qdot/mechanics/equations_of_motion.hpp"  // M q̈ = rhs
#include "qdot/mechanics/written_out.hpp"          // loops in T and V, run while compiling
#include "qdot/mechanics/degrees_of_freedom.hpp"   // how many coordinates, by the rank of the constraints
#include "qdot/mechanics/integrability.hpp"        // is a velocity constraint holonomic?
#include "qdot/mechanics/first_order_form.hpp"     // ẏ = f(t, y) for steppers

#include "qdot/effects/scene.hpp"         // a system and the effects that it names
#include "qdot/effects/forces.hpp"        // applied forces and torques, frames, controllers
#include "qdot/effects/dissipation.hpp"   // Rayleigh functions, springs and dampers, friction
#include "qdot/effects/constraints.hpp"   // φ(q, t) = 0, drives, rolling
#include "qdot/effects/contact.hpp"       // impacts, contacts, stops, ropes
#include "qdot/effects/dry_friction.hpp"  // friction that sticks
#include "qdot/effects/scene_motion.hpp"  // accelerations, multipliers, power
#include "qdot/effects/projection.hpp"    // consistent states
#include "qdot/effects/scene_form.hpp"    // a scene for steppers

#include "qdot/integrate/simulate.hpp"     // from t to t, with any method
#include "qdot/integrate/event.hpp"        // zero crossings: recorded, stopped at, or changing the state
#include "qdot/integrate/runge_kutta.hpp"  // explicit Runge–Kutta of order 8 and 5
#include "qdot/integrate/symplectic.hpp"   // splitting methods of orders 2 to 8

#include "qdot/analysis/equilibrium.hpp"  // where ∂V/∂q = 0
#include "qdot/analysis/modes.hpp"        // small vibrations about it
