// SPDX-License-Identifier: MIT
//
// What of CVODE depends on no type of a user's.
#include <qdot/integrate/cvode/sparse.hpp>
#include <qdot/integrate/cvode_stepper.hpp>

namespace qdot::detail::cvode {
template std::unique_ptr<Core> new_core<double>(std::unique_ptr<MethodForm>, NewtonMaker, CvodeSettings, const Options&);
template void reset<double>(Core&, const TimePoint&, const Eigen::Ref<const Eigen::VectorXd>&);
template bool step<double>(Core&, double);
template PolynomialView polynomial<double>(Core&);
template void tolerate<double>(Core&, const Eigen::VectorXd&);
template std::unique_ptr<NewtonEquations> newton_equations<double>(const MethodForm&, SUNContext);
}  // namespace qdot::detail::cvode
