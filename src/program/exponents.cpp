// SPDX-License-Identifier: MIT
#include "program/exponents.hpp"

#include <functional>

#include "program/first_order_model.hpp"

namespace qdot::program {

namespace {

qdot::detail::FlowInPieces flow_of(const std::shared_ptr<const Model>& model, const Request& request, const std::function<void(double)>& reached) {
  Options options;
  options.rtol = request.rtol;
  options.atol = atol_of(request);
  const auto pieces = qdot::detail::flow_in_pieces(FirstOrderModel{model}, Dop853{}, options);
  return [pieces, reached](double t, const Eigen::VectorXd& y, double until) {
    reached(t);
    return pieces(t, y, until);
  };
}

}  // namespace

std::string lacks_exponents(const Model& model) {
  return model.guard_count() > 0 || model.is_constrained() ? "must have no constraints and nothing that switches, for exponents" : "";
}

LyapunovSpectrum exponents_of(const std::shared_ptr<const Model>& model, const Request& request, const LyapunovOptions& options,
                              const std::function<void(double)>& reached) {
  return qdot::detail::lyapunov_spectrum_of<Eigen::MatrixXd>(flow_of(model, request, reached), request.start.t,
                                                             model->packed(request.start), request.t_end, options);
}

GeneralizedAlignmentIndex gali_of(const std::shared_ptr<const Model>& model, const Request& request) {
  return qdot::detail::gali_of<Eigen::MatrixXd>(flow_of(model, request, [](double) {}), request.start.t, model->packed(request.start), request.t_end, {});
}

}  // namespace qdot::program
