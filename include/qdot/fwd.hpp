#pragma once
// SPDX-License-Identifier: MIT
//
// Names of qdot's types, for headers that only mention them:
//
//     #include <qdot/fwd.hpp>
//
//     struct Plant {                                  // plant.hpp; plant.cpp includes qdot/qdot.hpp
//       std::unique_ptr<qdot::Simulator> simulator;
//       void show(const qdot::Trajectory<2>& motion) const;
//     };
//
// A file that includes such a header compiles neither Eigen nor qdot, which saves seconds for each file. Types that are returned by
// value or asked for members need their own header. A number of coordinates that is known at run time only is −1 here, which Dynamic is
// elsewhere. Types that cannot be written down, like that of scene(system, effects…), are held as AnySystem.

namespace qdot {

class Error;

template <class S, int N, class Tag>
struct Dual;

enum class Inertia;
template <class Energies, int n, Inertia inertia>
class System;
template <int n>
struct State;

template <class Sys, class... Effects>
class Scene;

class AnySystem;
class AnyStepper;
struct Options;
struct Statistics;
struct Failure;
struct RecordedEvent;
enum class Outcome;
template <int n>
struct Run;
template <class Number>
class BasicDenseOutput;
using DenseOutput = BasicDenseOutput<double>;  ///< of integrate/trajectory.hpp
template <int n>
class Trajectory;
class Simulator;
struct SimulatorState;

struct Linearization;
struct DampedModes;
struct Orbit;
struct ConservedQuantities;
template <int n>
struct Sensitivities;

namespace report {

struct Table;
struct Page;
struct Plot;

}  // namespace report
}  // namespace qdot
