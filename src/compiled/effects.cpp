// SPDX-License-Identifier: MIT
//
// The library qdot::compiled: constraints whose rows depend on each other, phases of contacts and friction, impacts, projections by lines.
#include <functional>

#include <qdot/effects/equations/constrained_motion.hpp>
#include <qdot/effects/equations/constraint_geometry.hpp>
#include <qdot/effects/equations/phases_at_state.hpp>
#include <qdot/effects/equations/rows_by_duals.hpp>
#include <qdot/effects/equations/scene_jacobian.hpp>
#include <qdot/effects/equations/switching.hpp>
#include <qdot/effects/impact.hpp>
#include <qdot/effects/projection.hpp>
#include <qdot/effects/rows/bounded_minimum.hpp>
#include <qdot/effects/rows/constrained_solve.hpp>
#include <qdot/effects/rows/dependent_rows.hpp>
#include <qdot/effects/rows/kept_projection.hpp>
#include <qdot/effects/rows/sparse_solve.hpp>
#include <qdot/effects/rows/traced_constraints.hpp>
#include <qdot/mechanics/equations/limit_of_slopes.hpp>

namespace qdot::detail {
template Eigen::MatrixXd part_of<void>(const Eigen::MatrixXd&, const std::vector<Eigen::Index>&);
template bool solve<void>(BoundedMinimum&);
template Eigen::MatrixXd null_space<void>(const Eigen::MatrixXd&);
template bool shorten<void>(Eigen::VectorXd&, const Eigen::MatrixXd&, const Eigen::VectorXd&, const Eigen::VectorXd&);
template Margin margin<void>(const Eigen::VectorXd&, const Eigen::MatrixXd&, const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::VectorXd&,
                             double);
template OrthogonalColumns orthogonal_columns<void>(const Eigen::MatrixXd&, double, bool);
template LeastNorm least_norm<void>(const Eigen::MatrixXd&, const double*, double);
template bool pivoted_elimination<void>(Eigen::MatrixXd&, double*, double*);
template void throw_contradiction<void>(const std::vector<std::string>&, const Eigen::VectorXd&, Eigen::Index, double);
template std::vector<double> pivoted_solution<void>(const Eigen::MatrixXd&, const Eigen::MatrixXd&, const double*, const double*, double,
                                                    const std::vector<std::string>&, const std::vector<std::string>&);
template bool slopes_in_the_limit<void>(const Eigen::VectorXd&, Eigen::Index, Eigen::MatrixXd&,
                                        const std::function<void(const Eigen::VectorXd&, Eigen::MatrixXd&)>&);
template Eigen::VectorXd impulses<void>(const Eigen::MatrixXd&, Eigen::VectorXd&, const std::vector<ImpactLaw>&, const Eigen::VectorXd&);
template void add_names<void>(std::vector<std::string>&, const std::string&, Eigen::Index);
template void throw_force_not_finite<void>(int, std::size_t, const std::string&, const std::string&, double);
template void find_parts<SceneRows>(const SceneRows&, std::vector<SwitchingPart>&);
template class RowsByDuals<1>;
template class RowsByDuals<2>;
template class RowsByDuals<3>;
template class RowsByDuals<4>;
template class RowsByDuals<5>;
template class RowsByDuals<6>;
template class RowsByDuals<7>;
template class RowsByDuals<8>;
template class RowsByDuals<Dynamic>;
template AnySolution general_constrained_acceleration<AnySizes>(const SceneRows&, double, const Column&, const Column&, const Column&, double);
template SolutionOf<Vector<double, 1>, Vector<double, 1>> general_constrained_acceleration<KnownSizes<1, 1>>(
    const SceneRows&, double, const Vector<double, 1>&, const Vector<double, 1>&, const Column&, double);
template SolutionOf<Vector<double, 2>, Vector<double, 1>> general_constrained_acceleration<KnownSizes<2, 1>>(
    const SceneRows&, double, const Vector<double, 2>&, const Vector<double, 2>&, const Column&, double);
template SolutionOf<Vector<double, 2>, Vector<double, 2>> general_constrained_acceleration<KnownSizes<2, 2>>(
    const SceneRows&, double, const Vector<double, 2>&, const Vector<double, 2>&, const Column&, double);
template SolutionOf<Vector<double, 3>, Vector<double, 1>> general_constrained_acceleration<KnownSizes<3, 1>>(
    const SceneRows&, double, const Vector<double, 3>&, const Vector<double, 3>&, const Column&, double);
template SolutionOf<Vector<double, 3>, Vector<double, 2>> general_constrained_acceleration<KnownSizes<3, 2>>(
    const SceneRows&, double, const Vector<double, 3>&, const Vector<double, 3>&, const Column&, double);
template SolutionOf<Vector<double, 4>, Vector<double, 1>> general_constrained_acceleration<KnownSizes<4, 1>>(
    const SceneRows&, double, const Vector<double, 4>&, const Vector<double, 4>&, const Column&, double);
template SolutionOf<Vector<double, 4>, Vector<double, 2>> general_constrained_acceleration<KnownSizes<4, 2>>(
    const SceneRows&, double, const Vector<double, 4>&, const Vector<double, 4>&, const Column&, double);
template Table constrained_slopes<void>(const SceneRows&, double, const Column&, const Column&, const Column&, const Table&, const Table&);
template class DenseGeometry<AnySizes>;
template Conditioning dense_conditioning<AnySizes>(const SceneRows&, double, const double*, const double*, const double*, bool);
template Conditioning dense_conditioning<KnownSizes<1, 1>>(const SceneRows&, double, const double*, const double*, const double*, bool);
template Conditioning dense_conditioning<KnownSizes<2, 1>>(const SceneRows&, double, const double*, const double*, const double*, bool);
template Conditioning dense_conditioning<KnownSizes<2, 2>>(const SceneRows&, double, const double*, const double*, const double*, bool);
template Conditioning dense_conditioning<KnownSizes<3, 1>>(const SceneRows&, double, const double*, const double*, const double*, bool);
template Conditioning dense_conditioning<KnownSizes<3, 2>>(const SceneRows&, double, const double*, const double*, const double*, bool);
template Conditioning dense_conditioning<KnownSizes<4, 1>>(const SceneRows&, double, const double*, const double*, const double*, bool);
template Conditioning dense_conditioning<KnownSizes<4, 2>>(const SceneRows&, double, const double*, const double*, const double*, bool);
template ProjectionReport projected<void>(const SceneRows&, ConstraintGeometry&, Column&, Column&, double, const Column&);
template ProjectionReport projected_by_size<1, 1>(const SceneRows&, Vector<double, 1>&, Vector<double, 1>&, double, double, const Column&);
template ProjectionReport projected_by_size<2, 1>(const SceneRows&, Vector<double, 2>&, Vector<double, 2>&, double, double, const Column&);
template ProjectionReport projected_by_size<2, 2>(const SceneRows&, Vector<double, 2>&, Vector<double, 2>&, double, double, const Column&);
template ProjectionReport projected_by_size<3, 1>(const SceneRows&, Vector<double, 3>&, Vector<double, 3>&, double, double, const Column&);
template ProjectionReport projected_by_size<3, 2>(const SceneRows&, Vector<double, 3>&, Vector<double, 3>&, double, double, const Column&);
template ProjectionReport projected_by_size<4, 1>(const SceneRows&, Vector<double, 4>&, Vector<double, 4>&, double, double, const Column&);
template ProjectionReport projected_by_size<4, 2>(const SceneRows&, Vector<double, 4>&, Vector<double, 4>&, double, double, const Column&);
template void write_scene_jacobian<void>(const SceneSlopes&, double, const Eigen::VectorXd&, Eigen::Ref<Eigen::MatrixXd>);
template std::unique_ptr<SparseFactors> sparse_factors<void>();
template std::unique_ptr<TracedConstraints> traced_constraints<void>(const RecordableForm&, double);
template std::unique_ptr<const AnyProjection> projection_by_lines<void>(const AnyRates&);
template SharedForces shared_forces<void>(const SceneRows&, double, const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::VectorXd&,
                                          const Eigen::VectorXd&);
template void split_forces<void>(const SceneRows&, double, const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::VectorXd&,
                                 Eigen::VectorXd&);
template void choose_phases<void>(const SwitchingScene&, double, const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::VectorXd&,
                                  std::vector<Switch>&, Eigen::VectorXd&);
template void write_guard_bands<void>(const SwitchingScene&, double, const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::VectorXd&,
                                      const Eigen::VectorXd&, Eigen::Ref<Eigen::VectorXd>);
template bool gap_has_moved<void>(const SwitchingScene&, double, const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::VectorXd&,
                                  const Eigen::VectorXd&);
template std::vector<std::string> settle<void>(const SwitchingScene&, double, Eigen::VectorXd&, Eigen::VectorXd&, Eigen::VectorXd&,
                                               std::vector<bool>, const Eigen::VectorXd&, const std::vector<bool>*);
template Eigen::VectorXd resolution_of<void>(const Eigen::VectorXd&, const Eigen::VectorXd&);
template Eigen::VectorXd phases_at_state<void>(const SwitchingScene&, double, const Eigen::VectorXd&, const Eigen::VectorXd&);
template void require_lasting_phases<void>(const SwitchingScene&, double, const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::VectorXd&);
template Eigen::VectorXd phases_of_rest<void>(const SwitchingScene&, double, const Eigen::VectorXd&, const Eigen::VectorXd&);
template bool revise_phases<void>(const SwitchingScene&, double, const Eigen::VectorXd&, const Eigen::VectorXd&, Eigen::VectorXd&);
template bool close_nearest<void>(const SwitchingScene&, double, const Eigen::VectorXd&, Eigen::VectorXd&);
}  // namespace qdot::detail
