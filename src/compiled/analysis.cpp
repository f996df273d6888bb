// SPDX-License-Identifier: MIT
//
// The library qdot::compiled_analysis: what of the questions to motions, and of what asks for decompositions of matrices, does not depend on a user's types.
// Declared with `extern template` where QDOT_COMPILED_ANALYSIS is defined. It takes one or two minutes to compile, so it is a library of its own.
#include <functional>

#include <qdot/analysis/conserved.hpp>
#include <qdot/analysis/damped_modes.hpp>
#include <qdot/analysis/equilibrium.hpp>
#include <qdot/analysis/equilibrium_branch.hpp>
#include <qdot/analysis/fit/best_parameters.hpp>
#include <qdot/analysis/fit/least_squares.hpp>
#include <qdot/analysis/linear/exponents.hpp>
#include <qdot/analysis/linear/rest_search.hpp>
#include <qdot/analysis/linear/shortest_step.hpp>
#include <qdot/analysis/linearization.hpp>
#include <qdot/analysis/lyapunov.hpp>
#include <qdot/analysis/modes.hpp>
#include <qdot/analysis/orbit_family.hpp>
#include <qdot/analysis/paths/search.hpp>
#include <qdot/analysis/periodic_orbit.hpp>
#include <qdot/analysis/lqr.hpp>
#include <qdot/analysis/return_map.hpp>
#include <qdot/analysis/symmetry/common_shifts.hpp>
#include <qdot/analysis/variations/branch_guards.hpp>
#include <qdot/analysis/variations/branches.hpp>
#include <qdot/analysis/variations/equations.hpp>
#include <qdot/mechanics/degrees_of_freedom.hpp>
#include <qdot/mechanics/integrability.hpp>

namespace qdot::detail {
template class BoundedLeastSquares<void>;
template class BranchGuards<void>;
template class FunctorBranches<void>;
template ConservedQuantities quantities_of<void>(RecordedScene);
template Eigen::VectorXd newton_step<Eigen::MatrixXd, Eigen::VectorXd>(const Eigen::MatrixXd&, const Eigen::VectorXd&, double);
template std::vector<EquilibriumBranch> branches_from<void>(const FlowAt&, const Eigen::VectorXd&, double, double, const BranchOptions&);
template ParameterFit best_parameters<void>(const FitTask&);
template Exponents exponents_of<Eigen::MatrixXd>(const Eigen::MatrixXd&);
template bool any_drifts<Exponents>(const Exponents&);
template Eigen::VectorXd steady_state_near<Flow>(const Flow&, const SteadySearch&, double, Eigen::VectorXd);
template ShortestStep shortest_step<void>(Eigen::MatrixXd, const Eigen::VectorXd&, double);
template Linearization linearized<Flow>(const Flow&, double, const Eigen::VectorXd&);
template LyapunovSpectrum lyapunov_spectrum_of<Eigen::MatrixXd>(const FlowInPieces&, double, const Eigen::VectorXd&, double, const LyapunovOptions&);
template Eigen::VectorXcd solved_exponents<Eigen::MatrixXd>(const Eigen::MatrixXd&, const Eigen::MatrixXd&, const Eigen::MatrixXd&);
template NormalModes<Dynamic> solved_modes<Eigen::MatrixXd>(const Eigen::MatrixXd&, const Eigen::MatrixXd&);
template OrbitsOfFamily family_from<void>(const Shooting&, Eigen::VectorXd, const FamilyIn&, Held, const FamilyOptions&);
template BoundaryValueEnd boundary_value_end<void>(BoundaryValueSearch);
template Orbit orbit_near<void>(const Shooting&, Eigen::VectorXd, const Held&, const OrbitOptions&);
template Eigen::VectorXd slope_of<void>(const std::function<double(const Eigen::VectorXd&)>&, const Eigen::VectorXd&, const Eigen::VectorXd&);
template Eigen::MatrixXd common_shifts<Eigen::MatrixXd>(const formula::Graph&, const std::vector<std::vector<int>>&, std::size_t);
template Crossing BasicVariationalEquations<void>::crossing(const std::string&, double, const Eigen::Ref<const Eigen::VectorXd>&, const Surface&) const;
template void BasicVariationalEquations<void>::pass(const std::string&, double, Eigen::VectorXd&, const Surface&);
template Integrability frobenius_condition<Eigen::MatrixXd, Eigen::VectorXd>(const Eigen::VectorXd&, const Eigen::MatrixXd&, const Eigen::VectorXd&, double);
}  // namespace qdot::detail

namespace qdot {
template DampedModes damped_modes<Linearization>(const Linearization&);
template Eigen::MatrixXcd frequency_response<Linearization>(const Linearization&, double);
template FiniteTimeLyapunov finite_time_lyapunov<Eigen::MatrixXd>(const Eigen::MatrixXd&);
template Lqr lqr<Eigen::MatrixXd>(const Eigen::MatrixXd&, const Eigen::MatrixXd&, const Eigen::MatrixXd&, const Eigen::MatrixXd&);
template Lqr lqr<Linearization, Eigen::MatrixXd>(const Linearization&, const Eigen::MatrixXd&, const Eigen::MatrixXd&);
template ConstraintRank rank_of_rows<Eigen::MatrixXd, Eigen::VectorXd>(const Eigen::MatrixXd&, double);
}  // namespace qdot
