#pragma once
// SPDX-License-Identifier: MIT
//
// What every peer offers to driver.cxx: a shared library with this function, and nothing of the others in it. The system is the planar
// chain of n unit masses on unit rods, angles from the downward vertical, g = 9.81.

/// Reads n angles and n angular velocities, writes n angular accelerations.
using ChainAcceleration = void (*)(const double* q, const double* qdot, double* qddot);

/// The peer's function for n links, or null where it has none.
extern "C" ChainAcceleration acceleration_of_chain(int n);

/// What make gives for n links, where n is one of these numbers; null where it is none of them.
template <int... links, class Make>
ChainAcceleration of_links(int n, const Make& make) {
  ChainAcceleration found = nullptr;
  ((n == links ? void(found = make.template operator()<links>()) : void()), ...);
  return found;
}

/// Accelerations of many states by one call: the first angles of all of them, then the second ones, and so on.
using ChainAccelerations = void (*)(const double* q, const double* qdot, double* qddot, int states);

/// Instead of acceleration_of_chain from peers that evaluate many states at once.
extern "C" ChainAccelerations accelerations_of_chains(int n);
