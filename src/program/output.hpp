#pragma once
// SPDX-License-Identifier: MIT
//
// From a result to what is written: the table, the arrays, the page.

#include <string>
#include <vector>

#include "program/runnable_scene.hpp"
#include "program/simulation.hpp"
#include "qdot/report/html.hpp"
#include "qdot/report/npy.hpp"
#include "qdot/report/table.hpp"

namespace qdot::program {

/// The files that `--out PATH` writes: PATH.csv, PATH.npz, PATH.html, and a still picture PATH.svg.
std::vector<std::string> output_paths(const std::string& path);

/// How many frames an animation of this scene should have: a hundred a second of watching, fewer for many points.
int frame_count(const RunnableScene& scene, const State<Dynamic>& start, double t_end);

/// Whether Jacobi's energy function tells something that T + V does not: T is no quadratic form of the velocities.
bool jacobi_differs(const Result& result);

/// t, q, qdot and the energies at the samples, with units.
report::Table table(const RunnableScene& scene, const Result& result);

/// The samples for NumPy: t (N), q (N×n), qdot (N×n), the energies (N).
std::vector<report::Array> arrays(const Result& result, Eigen::Index dof);

/// Animation, parameters, summary and plots; those of several runs fit over each other where they are not apart by size.
report::Page page(const RunnableScene& scene, const Request& request, const Result& result, bool by_size = true);

/// The files that further runs beside the first have, PATH_2.csv, PATH_2.npz, PATH_3.csv, …
std::vector<std::string> further_paths(const std::string& path, std::size_t runs);

struct ComparedRun;

/// Writes all files of the runs, of which the first has a page and a picture that show all, or none.
///
/// @throws UnwritableFile
void write_outputs(const std::string& path, const std::vector<ComparedRun>& runs);

}  // namespace qdot::program
