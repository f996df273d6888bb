// SPDX-License-Identifier: MIT
//
// The library qdot::compiled: what of qdot does not depend on a user's types, compiled once.
//
// Headers declare these with `extern template` where QDOT_COMPILED is defined, which the CMake target does. Without it every program compiles them for itself.
#include <qdot/ad/formula/lines.hpp>
#include <qdot/ad/native/line_evaluator.hpp>
#include <qdot/ad/formula/recording.hpp>
#include <qdot/ad/series/sweep.hpp>
#include <qdot/integrate/automatic.hpp>
#include <qdot/integrate/driver/drive.hpp>
#include <qdot/integrate/driver/driver.hpp>
#include <qdot/integrate/driver/ending.hpp>
#include <qdot/integrate/driver/event_clocks.hpp>
#include <qdot/integrate/driver/event_finder.hpp>
#include <qdot/integrate/options.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/steps/recorded_motion.hpp>
#include <qdot/integrate/steps/spectral_radius.hpp>
#include <qdot/integrate/steps/watch_budget.hpp>
#include <qdot/integrate/taylor.hpp>
#include <qdot/integrate/watch/any_watch.hpp>
#include <qdot/integrate/watch/diagnosis.hpp>
#include <qdot/mechanics/derive/derivation.hpp>
#include <qdot/mechanics/derive/kept_equations.hpp>
#include <qdot/mechanics/derive/kept_lines.hpp>
#include <qdot/mechanics/derive/kept_motion.hpp>
#include <qdot/mechanics/derive/traced_equations.hpp>
#include <qdot/mechanics/derive/traced_jacobian.hpp>
#include <qdot/mechanics/derive/traced_motion.hpp>
#include <qdot/mechanics/equations/sparse_factors.hpp>
#include <qdot/mechanics/equations_of_motion.hpp>

namespace qdot::taylor {
template Sweep sweep_of<double>(formula::BasicGraph<double>&, const SweepOutputs&, int);
template void start<double>(Sweep&);
template void advance<double>(Sweep&, int);
template void complete<double>(Sweep&, int);
}  // namespace qdot::taylor

namespace qdot::formula {
template class BasicGraph<double>;
template int variable_in<double>(Recording&, int);
template int operation_in<double>(Recording&, BinaryOperation, int, int);
template int function_in<double>(Recording&, Function, int);
template int power_in<double>(Recording&, int, double);
template int constant_in<double>(Recording&, double);
template void carry_out<double>(const LineTable&, const RunOfLines&, double*);
template void carry_out<double>(const LineTable&, double*);
template void carry_out<LaneNumber>(const LineTable&, const RunOfLines&, LaneNumber*);
template void carry_out<LaneNumber>(const LineTable&, LaneNumber*);
template bool native_lines_are_possible<void>();
template bool native_lanes_are_possible<void>();
template void LineEvaluator::translate<false>() const;
template void LineEvaluator::translate<true>() const;
template void LineEvaluator::mark_read_by<double>(const LineEvaluator&);
}  // namespace qdot::formula

namespace qdot::detail {
template Run<1> run_of<1>(Run<>&&);
template Run<2> run_of<2>(Run<>&&);
template Run<3> run_of<3>(Run<>&&);
template Run<4> run_of<4>(Run<>&&);
template Run<5> run_of<5>(Run<>&&);
template Run<6> run_of<6>(Run<>&&);
template Run<7> run_of<7>(Run<>&&);
template Run<8> run_of<8>(Run<>&&);
template double seconds_of_steady_clock<void>();
template void require_valid<double>(const Options&, Eigen::Index);
template std::string explanation<double>(const Probe&, Outcome, const Standstill&);
template Failure trouble_of_state<double>(const DrivenForm&, const Eigen::Ref<const Eigen::VectorXd>&, double, double);
template void drive<false, false>(Run<>&, const DrivenForm&, AnyStepper, const Options&, const Budget&, Onlooker, std::vector<ListedEvent>,
                                  double, const Eigen::VectorXd&, double);
template void drive<false, true>(Run<>&, const DrivenForm&, AnyStepper, const Options&, const Budget&, Onlooker, std::vector<ListedEvent>,
                                 double, const Eigen::VectorXd&, double);
template void drive<true, false>(Run<>&, const DrivenForm&, AnyStepper, const Options&, const Budget&, Onlooker, std::vector<ListedEvent>,
                                 double, const Eigen::VectorXd&, double);
template void drive<true, true>(Run<>&, const DrivenForm&, AnyStepper, const Options&, const Budget&, Onlooker, std::vector<ListedEvent>,
                                double, const Eigen::VectorXd&, double);
template AnyStepper taylor_stepper<2>(const AnyForm&, int, const Options&);
template AnyStepper taylor_stepper<4>(const AnyForm&, int, const Options&);
template AnyStepper taylor_stepper<6>(const AnyForm&, int, const Options&);
template std::unique_ptr<StretchedRun> stretched_run<false>(Run<>&, const DrivenForm&, AnyStepper, const Options&, const Budget&, std::vector<ListedEvent>);
template std::unique_ptr<StretchedRun> stretched_run<true>(Run<>&, const DrivenForm&, AnyStepper, const Options&, const Budget&, std::vector<ListedEvent>);
template NaturalTolerances natural_tolerances<double>(const DrivenForm&, const Options&, double, const Eigen::VectorXd&, double);
template class BranchCrossing<double>;
template std::unique_ptr<AnyWatch> watchdog<false>(std::unique_ptr<const WatchedForm>, const Options&);
template std::unique_ptr<AnyWatch> watchdog<true>(std::unique_ptr<const WatchedForm>, const Options&);
template class BasicChangeWatch<double>;
template std::string how_it_ended<double>(Outcome, const std::string&, double, long, const char*);
template void search_root<double>(RootSearch&, double, double, const double*);
template void set_clocks<double>(EventClocks&, const std::vector<ListedEvent>&, double, double);
template double radius_at<double>(SpectralRadius&, double, const Eigen::Ref<const Eigen::VectorXd>&);
template double damping_of<double>(SpectralRadius&);
template void differentiate_energies<double>(RecordedMotion&);
template void differentiate_rows<double>(RecordedMotion&, std::size_t, bool, const std::string&);
template void add_forces<double>(RecordedMotion&, std::size_t);
template void name_source<void>(RecordedMotion&, const char*, const std::string*);
template void note_returned<void>(RecordedMotion&, int);
template bool DerivedLines::with_mass_and_rhs<1>(const double*, const double*, double, const AccelerationTo<1>&) const;
template bool DerivedLines::with_mass_and_rhs<1>(const double*, const double*, double, const AccelerationTo<1, true>&) const;
template bool DerivedLines::with_mass_and_rhs<1>(const double*, const double*, double, const CopyTo<1>&) const;
template bool DerivedLines::with_mass_and_rhs<1>(const double*, const double*, double, const MassTo<1>&) const;
template bool DerivedLines::with_mass_and_rhs<2>(const double*, const double*, double, const AccelerationTo<2>&) const;
template bool DerivedLines::with_mass_and_rhs<2>(const double*, const double*, double, const AccelerationTo<2, true>&) const;
template bool DerivedLines::with_mass_and_rhs<2>(const double*, const double*, double, const CopyTo<2>&) const;
template bool DerivedLines::with_mass_and_rhs<2>(const double*, const double*, double, const MassTo<2>&) const;
template bool DerivedLines::with_mass_and_rhs<3>(const double*, const double*, double, const AccelerationTo<3>&) const;
template bool DerivedLines::with_mass_and_rhs<3>(const double*, const double*, double, const AccelerationTo<3, true>&) const;
template bool DerivedLines::with_mass_and_rhs<3>(const double*, const double*, double, const CopyTo<3>&) const;
template bool DerivedLines::with_mass_and_rhs<3>(const double*, const double*, double, const MassTo<3>&) const;
template bool DerivedLines::with_mass_and_rhs<4>(const double*, const double*, double, const AccelerationTo<4>&) const;
template bool DerivedLines::with_mass_and_rhs<4>(const double*, const double*, double, const AccelerationTo<4, true>&) const;
template bool DerivedLines::with_mass_and_rhs<4>(const double*, const double*, double, const CopyTo<4>&) const;
template bool DerivedLines::with_mass_and_rhs<4>(const double*, const double*, double, const MassTo<4>&) const;
template bool DerivedLines::with_mass_and_rhs<5>(const double*, const double*, double, const AccelerationTo<5>&) const;
template bool DerivedLines::with_mass_and_rhs<5>(const double*, const double*, double, const AccelerationTo<5, true>&) const;
template bool DerivedLines::with_mass_and_rhs<6>(const double*, const double*, double, const AccelerationTo<6>&) const;
template bool DerivedLines::with_mass_and_rhs<6>(const double*, const double*, double, const AccelerationTo<6, true>&) const;
template bool DerivedLines::with_mass_and_rhs<7>(const double*, const double*, double, const AccelerationTo<7>&) const;
template bool DerivedLines::with_mass_and_rhs<7>(const double*, const double*, double, const AccelerationTo<7, true>&) const;
template bool DerivedLines::with_mass_and_rhs<8>(const double*, const double*, double, const AccelerationTo<8>&) const;
template bool DerivedLines::with_mass_and_rhs<8>(const double*, const double*, double, const AccelerationTo<8, true>&) const;
template std::string sentence<void>(std::initializer_list<Phrase>);
template void throw_invalid_value<void>(std::initializer_list<Phrase>);
template std::string reason<void>(const OutsideOfDomain&);
template void throw_energy_not_finite<void>(const char*, double, double, const std::string&);
template AnyStepper stepper_of_rates<RungeKuttaStepper<Dop853Coefficients, 2>>(std::unique_ptr<Rates>, std::string, const Options&);
template AnyStepper stepper_of_rates<RungeKuttaStepper<Dop853Coefficients, 3>>(std::unique_ptr<Rates>, std::string, const Options&);
template AnyStepper stepper_of_rates<RungeKuttaStepper<Dop853Coefficients, 4>>(std::unique_ptr<Rates>, std::string, const Options&);
template AnyStepper stepper_of_rates<RungeKuttaStepper<Dop853Coefficients, 5>>(std::unique_ptr<Rates>, std::string, const Options&);
template AnyStepper stepper_of_rates<RungeKuttaStepper<Dop853Coefficients, 6>>(std::unique_ptr<Rates>, std::string, const Options&);
template AnyStepper stepper_of_rates<RungeKuttaStepper<Dop853Coefficients, 8>>(std::unique_ptr<Rates>, std::string, const Options&);
template AnyStepper stepper_of_rates<RungeKuttaStepper<Dop853Coefficients, Dynamic>>(std::unique_ptr<Rates>, std::string, const Options&);
template void throw_not_finite<double>(const std::string&, double);
template void throw_derivative_not_finite<double>(const std::string&, const std::string&, double);
template void throw_mass_matrix_error<double>(Eigen::MatrixXd, double, const std::vector<std::string>&);
template class KeptBranches<>;
template class LagrangeSeries<>;
template class BranchedSeries<>;
template std::shared_ptr<SharedDerivations> no_derivations_yet<void>();
template std::shared_ptr<SharedDerivations> derivations_by<void>(const std::shared_ptr<SharedDerivations>&, By);
template struct Derivation<double>;
template class BasicKeptDerivation<double>;
template class BasicBranchDerivations<double>;
template class BasicDerivations<double>;
template class BasicDerivedOnce<double>;
template Derivations& made_derivations<void>(SharedDerivations&);
template std::shared_ptr<DerivedOnce> derived_once<void>(const std::shared_ptr<SharedDerivations>&);
template void TracedEquations<double>::derive(bool, const std::vector<char>&);
template TracedEquations<double>::Slopes TracedEquations<double>::slopes();
template TracedLines<double>::TracedLines(TracedEquations<double>);
template std::vector<int> TracedLines<double>::numbers(const std::vector<int>&) const;
template std::shared_ptr<const formula::LineEvaluator> TracedLines<double>::written(const std::vector<int>&);
template TracedLines<double>::Solved TracedLines<double>::solved(const std::vector<int>&, const std::vector<int>&, const std::vector<int>&,
                                                                 const std::vector<int>&, double, std::size_t);
template TracedLines<double>::Solved TracedLines<double>::solved_rates(const LimitsOfPivots&, std::size_t, bool);
template TracedLines<double>::Solved TracedLines<double>::solved_projection(const LimitsOfPivots&, std::size_t);
template TracedMotion<double>::TracedMotion(TracedEquations<double>);
template std::unique_ptr<TracedRates> traced_rates<void>(const RecordableForm&);
template std::shared_ptr<TracedEquations<double>> recorded_equations<void>(const RecordableForm&);
template class TracedJacobian<1>;
template class TracedJacobian<2>;
template class TracedJacobian<3>;
template class TracedJacobian<4>;
template class TracedJacobian<Dynamic>;
template class BasicSharedRates<double>;
template class BasicRunRates<double>;
template SharedRates& made_rates<void>(SharedDerivations&);
template bool are_native<void>(const AnyRates&);
template std::unique_ptr<AnyJacobians> traced_jacobians<1>();
template std::unique_ptr<AnyJacobians> traced_jacobians<2>();
template std::unique_ptr<AnyJacobians> traced_jacobians<3>();
template std::unique_ptr<AnyJacobians> traced_jacobians<4>();
template std::unique_ptr<AnyJacobians> traced_jacobians<Eigen::Dynamic>();
template void PatternFactors<double>::order(const std::vector<int>&, const std::vector<int>&);
template std::string way_of_lines<void>(bool, By, bool);
}  // namespace qdot::detail

namespace qdot {
template class BasicDenseOutput<double>;
template class BasicAutomaticStepper<double>;
}  // namespace qdot
