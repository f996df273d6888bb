#pragma once
// SPDX-License-Identifier: MIT
//
// qdot: motion from a Lagrangian. This list is the table of contents, in the order of the theory: every header that a user includes. What
// most programs want is included here; what stands behind // #include is asked for by name, since it costs time to compile.
// Folders below a layer (mechanics/equations/, …) are the library's own.

#include "qdot/error.hpp"    // what is thrown
#include "qdot/version.hpp"  // which qdot this is
// #include "qdot/fwd.hpp"   // names of types, for headers that only mention them

#include "qdot/ad/dual.hpp"         // numbers that carry their derivatives
#include "qdot/ad/dual_math.hpp"    // their sine, root, power …
#include "qdot/ad/dual_eigen.hpp"   // vectors of them
#include "qdot/ad/derivatives.hpp"  // gradient, jacobian, hessian
#include "qdot/ad/vector.hpp"       // vectors of n numbers, n known or not
#include "qdot/ad/unroll.hpp"       // loops that the compiler sees through
// #include "qdot/ad/pack.hpp"       // four or eight numbers at once
// #include "qdot/ad/pack_math.hpp"  // their sine, root, power …

#include "qdot/mechanics/velocity.hpp"               // ẋ from x(q), differentiated by the library
#include "qdot/mechanics/rotation.hpp"               // R(q) and its angular velocity
#include "qdot/mechanics/inertia.hpp"                // inertia tensors of standard bodies, parallel axes
#include "qdot/mechanics/rigid_body.hpp"             // T of a rigid body about G and about any point A
#include "qdot/mechanics/system.hpp"                 // T and V, notation and signs
#include "qdot/mechanics/energy.hpp"                 // L, E, p, Jacobi's energy function
#include "qdot/mechanics/by.hpp"                     // which way from T and V to M and r
#include "qdot/mechanics/mass_and_rhs.hpp"           // M and r of M q̈ = r, by the shortest way
#include "qdot/mechanics/mass_matrix.hpp"            // M alone
#include "qdot/mechanics/equations_of_motion.hpp"    // M q̈ = rhs
#include "qdot/mechanics/acceleration_jacobian.hpp"  // ∂q̈/∂(q, q̇)
#include "qdot/mechanics/written_out.hpp"            // deprecated: T and V are derived when a program runs
#include "qdot/mechanics/degrees_of_freedom.hpp"     // how many coordinates, by the rank of the constraints
#include "qdot/mechanics/integrability.hpp"          // is a velocity constraint holonomic?
#include "qdot/mechanics/first_order_form.hpp"       // ẏ = f(t, y) for steppers
// #include "qdot/mechanics/derived.hpp"                 // deprecated: every system derives its equations
// #include "qdot/mechanics/kinematic_system.hpp"        // T from the positions of masses and bodies
// #include "qdot/mechanics/written_out_kinematics.hpp"  // deprecated: the same by another name
// #include "qdot/mechanics/parameter_jacobian.hpp"      // ∂q̈/∂p
// #include "qdot/mechanics/accelerations.hpp"           // q̈ of many states at once
// #include "qdot/mechanics/ensemble.hpp"                // deprecated: accelerations.hpp

#include "qdot/effects/effect.hpp"             // what an effect is, and how to write one
#include "qdot/effects/scene.hpp"              // a system and the effects that it names
#include "qdot/effects/forces.hpp"             // applied forces and torques, frames, controllers
#include "qdot/effects/dissipation.hpp"        // Rayleigh functions, springs and dampers, friction
#include "qdot/effects/constraints.hpp"        // φ(q, t) = 0, drives, rolling
#include "qdot/effects/contact.hpp"            // impacts, contacts, stops, ropes
#include "qdot/effects/dry_friction.hpp"       // friction that sticks
#include "qdot/effects/plane_friction.hpp"     // the same in a plane, with one bound for all directions
#include "qdot/effects/input.hpp"              // forces that are left open, for linearization and control
#include "qdot/effects/interpolated_input.hpp"  // the same, linear from value to value
#include "qdot/effects/choice.hpp"             // effects that are on or off at compile time
#include "qdot/effects/fit.hpp"                // which effects a system can take
#include "qdot/effects/scene_motion.hpp"       // accelerations, multipliers, power
#include "qdot/effects/projection.hpp"         // consistent states
#include "qdot/effects/projection_report.hpp"  // how far a state was moved
#include "qdot/effects/impact.hpp"             // velocities after a blow
#include "qdot/effects/scene_form.hpp"         // a scene for steppers
#include "qdot/effects/scene_at_state.hpp"     // what one asks a scene at a State; inverse dynamics

#include "qdot/integrate/simulate.hpp"     // from t to t, with any method
#include "qdot/integrate/options.hpp"      // tolerances, budgets, what is kept
#include "qdot/integrate/outcome.hpp"      // why a run ended
#include "qdot/integrate/run.hpp"          // what a run returns
#include "qdot/integrate/trajectory.hpp"   // states between steps
#include "qdot/integrate/statistics.hpp"   // what it cost
#include "qdot/integrate/event.hpp"        // zero crossings: recorded, stopped at, or changing the state
#include "qdot/integrate/stepper.hpp"      // what a method is
#include "qdot/integrate/time_point.hpp"   // times with all their digits
#include "qdot/integrate/runge_kutta.hpp"  // explicit Runge–Kutta of order 8 and 5
#include "qdot/integrate/symplectic.hpp"   // splitting methods of orders 2 to 8
// #include "qdot/integrate/taylor.hpp"               // power series, for small smooth systems
// #include "qdot/integrate/gauss.hpp"                // implicit and symplectic, of orders 4 to 8
// #include "qdot/integrate/rattle.hpp"               // symplectic on constraints
// #include "qdot/integrate/projecting_stepper.hpp"   // any method, put back onto constraints
// #include "qdot/integrate/rotation_chart.hpp"       // attitudes without gimbal lock
// #include "qdot/integrate/energy_balance.hpp"       // an account of the energy
// #include "qdot/integrate/simulate_to_accuracy.hpp"  // the whole motion to an accuracy
// #include "qdot/integrate/ensemble.hpp"             // many motions in threads, by their numbers
// #include "qdot/integrate/many_in_lanes.hpp"        // the same side by side in the lanes of a processor
// #include "qdot/integrate/counter_random.hpp"       // random numbers that belong to a number
// #include "qdot/integrate/simulator.hpp"            // a motion that another program advances
// #include "qdot/integrate/simulator_state.hpp"      // where it is, as bytes
// #include "qdot/integrate/any_stepper.hpp"          // a method that is chosen at run time
// #include "qdot/integrate/any_system.hpp"           // a system that is chosen at run time
// #include "qdot/integrate/automatic.hpp"            // the method is chosen for you
// #include "qdot/integrate/moment.hpp"               // deprecated: time_point.hpp
// #include "qdot/integrate/accurate_simulation.hpp"  // deprecated: simulate_to_accuracy.hpp
// #include "qdot/integrate/simulate_many.hpp"        // deprecated: ensemble.hpp
// With SUNDIALS, linked by qdot::cvode:
// #include "qdot/integrate/cvode.hpp"            // Adams and BDF methods
// #include "qdot/integrate/cvode_stepper.hpp"    // one of their steps at a time
// #include "qdot/integrate/cvode_automatic.hpp"  // the method is chosen for you, CVODE among them
// With MPI, linked by qdot::mpi:
// #include "qdot/integrate/ensemble_mpi.hpp"       // many motions by processes, on as many machines as there are
// #include "qdot/integrate/simulate_many_mpi.hpp"  // deprecated: ensemble_mpi.hpp

#include "qdot/analysis/equilibrium.hpp"  // where ∂V/∂q = 0
#include "qdot/analysis/modes.hpp"        // small vibrations about it
// #include "qdot/analysis/steady_state.hpp"    // where a scene rests, or moves steadily
// #include "qdot/analysis/equilibrium_branch.hpp"  // the same along a parameter
// #include "qdot/analysis/linearization.hpp"   // A, B, C, D about such a state
// #include "qdot/analysis/damped_modes.hpp"    // frequencies, damping, stability, frequency response
// #include "qdot/analysis/lqr.hpp"             // feedback by linear-quadratic regulation
// #include "qdot/analysis/sampled.hpp"         // both at the ticks of a digital controller
// #include "qdot/analysis/conserved.hpp"      // which momenta and energies a motion keeps
// #include "qdot/analysis/noether.hpp"        // and what a symmetry keeps
// #include "qdot/analysis/routh.hpp"          // a system without its cyclic coordinates
// #include "qdot/analysis/hamiltonian.hpp"    // H, q̇ from p, Hamilton's equations, Poisson brackets
// #include "qdot/analysis/sensitivity.hpp"     // ∂y/∂(y₀, t₀, p), through events and on constraints
// #include "qdot/analysis/taylor_sensitivity.hpp"  // the same by power series, to rounding
// #include "qdot/analysis/gauss_sensitivity.hpp"   // the same by a symplectic tangent map, over long times
// #include "qdot/analysis/second_sensitivity.hpp"  // and ∂²y/∂x∂x
// #include "qdot/analysis/adjoint.hpp"         // one number's gradient in many parameters, backwards
// #include "qdot/analysis/parameter_fit.hpp"   // parameters from measurements of motions
// #include "qdot/analysis/generalized_alignment_index.hpp"  // whether it is chaotic, found out soon
// #include "qdot/analysis/lyapunov.hpp"        // how fast motions part: exponents, singular values of Φ
// #include "qdot/analysis/periodic_orbit.hpp"  // motions that repeat, by Newton's method
// #include "qdot/analysis/orbit_family.hpp"    // families of them, with folds, period doublings and branch points
// #include "qdot/analysis/orbit.hpp"           // their multipliers and stability
// #include "qdot/analysis/section.hpp"         // where a motion passes a surface (Poincaré)
// #include "qdot/analysis/return_map.hpp"      // from there to where it passes again, with its derivative
// #include "qdot/analysis/action.hpp"          // ∫ L dt along any path
// #include "qdot/analysis/boundary_value_problem.hpp"  // the motion between two places in a given time, and its conjugate points
// #include "qdot/analysis/work_precision.hpp"        // what accuracy costs
// #include "qdot/analysis/work_precision_study.hpp"  // the same for many methods
// #include "qdot/analysis/reference.hpp"       // a motion in higher precision
// #include "qdot/analysis/reference_equations.hpp"  // its equations
// #include "qdot/analysis/accuracy.hpp"        // deprecated: work_precision.hpp
// #include "qdot/analysis/accuracy_study.hpp"  // deprecated: work_precision_study.hpp
// #include "qdot/analysis/alignment.hpp"       // deprecated: generalized_alignment_index.hpp
// #include "qdot/analysis/motion_between.hpp"  // deprecated: boundary_value_problem.hpp
// #include "qdot/analysis/regulator.hpp"       // deprecated: lqr.hpp
// With Ipopt, linked by qdot::optimal:
// #include "qdot/analysis/trajectory_optimization.hpp"  // the cheapest way from one state to another with inputs
// #include "qdot/analysis/optimal_motion.hpp"           // deprecated: trajectory_optimization.hpp

// Text from numbers: plots, pages, files. Nothing of it is included here.
// #include "qdot/report/table.hpp"        // columns of numbers with names and units
// #include "qdot/report/motion_table.hpp" // a run as such a table
// #include "qdot/report/run_report.hpp"   // a page of a run in one line: plots, events, a moving picture
// #include "qdot/report/motion_plots.hpp" // the plots of such a table
// #include "qdot/report/number.hpp"       // numbers as text
// #include "qdot/report/symbol.hpp"       // theta1 as θ₁
// #include "qdot/report/equations.hpp"      // L, p, M, r and q̈ as formulas
// #include "qdot/report/equation_text.hpp"  // for a terminal, for LaTeX, for a page
// #include "qdot/report/c_code.hpp"         // q̈ and its Jacobian as a C file
// #include "qdot/report/csv.hpp"          // comma-separated values
// #include "qdot/report/npy.hpp"          // NumPy's arrays
// #include "qdot/report/file.hpp"         // files that are there completely or not at all
// #include "qdot/report/heat_map.hpp"     // a quantity over a plane, as colours
// #include "qdot/report/theme.hpp"        // colours, light and dark
// #include "qdot/report/plot.hpp"         // a line plot as data
// #include "qdot/report/svg.hpp"          // and as SVG
// #include "qdot/report/loglog.hpp"       // measurements over decades
// #include "qdot/report/animation.hpp"    // a moving picture as data
// #include "qdot/report/still.hpp"        // one moment of it
// #include "qdot/report/html.hpp"         // one page of all that
// #include "qdot/report/html_player.hpp"  // its script
