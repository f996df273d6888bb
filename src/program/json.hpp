#pragma once
// SPDX-License-Identifier: MIT
//
// What the commands print with --json: one object, numbers that read back exactly, NaN as null.

#include <memory>
#include <string>
#include <vector>

#include "program/runnable_scene.hpp"
#include "program/simulation.hpp"
#include "qdot/analysis/orbit.hpp"

namespace qdot::program {

struct SteadyPoint;       // steady_points.hpp
struct PointsOfBranch;    // likewise
struct FamilyFound;       // orbit_search.hpp
struct Turns;             // orbit_turns.hpp
struct SensitivityTable;  // sensitivity.hpp

/// The keys of the command-line contract, and a few more behind them.
///
/// energy_initial, energy_final are T + V; energy_drift_max is the largest |E − E(0)| over all accepted steps.
/// jacobi_energy_… are the same for q̇·p − L, which is what stays constant when T has terms of degree 1 or 0 in q̇.
/// mass_rcond_min is the least rcond(M), scaled to unit diagonal, of the states that were looked at; 1 where M is diagonal.
std::string run_json(const RunnableScene& scene, const Request& request, const Result& result,
                     const std::vector<std::string>& files);

std::string list_json(const std::vector<std::unique_ptr<RunnableScene>>& scenes);

/// How a list of steady states came about.
enum class SteadyList { the_only_one, all_found, some_of_a_family };

/// Steady states with their modes; the only one without an array around it.
std::string steady_states_json(const RunnableScene& scene, const std::vector<SteadyPoint>& points, SteadyList list);

/// Branches of equilibria along what is called `name`.
std::string branches_json(const RunnableScene& scene, const std::string& name, double from, double to, const std::vector<PointsOfBranch>& branches);

/// A periodic orbit, or how far the search for it came. `names` are those of q and q̇, `turns` those of the coordinates, and `moved` is the way
/// from where the search began to the start. These two are empty where no orbit was found.
std::string orbit_json(const RunnableScene& scene, const std::vector<std::string>& names, const Orbit& orbit, const std::vector<Turns>& turns,
                       const Eigen::VectorXd& moved);

std::string family_json(const RunnableScene& scene, const std::vector<std::string>& names, const std::string& along, const FamilyFound& family);

std::string sensitivity_json(const RunnableScene& scene, const SensitivityTable& table);

}  // namespace qdot::program
