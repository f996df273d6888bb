// SPDX-License-Identifier: MIT
#include "program/steady_points.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "program/arguments.hpp"
#include "program/catalogue.hpp"
#include "qdot/analysis/equilibrium_branch.hpp"
#include "qdot/report/csv.hpp"
#include "qdot/report/file.hpp"
#include "qdot/report/html.hpp"
#include "qdot/report/number.hpp"
#include "qdot/report/table.hpp"

namespace qdot::program {

namespace {

/// A model as the analysis of small motions asks for it.
class ModelFlow final : public qdot::detail::FlowOfForm<const Model&> {
 public:
  explicit ModelFlow(std::shared_ptr<const Model> model) : FlowOfForm(*model), model_(std::move(model)) {}

  Eigen::Index dof() const override { return form_.dof(); }
  qdot::detail::ConstraintsAt constraints(double t, const Eigen::VectorXd& y) const override { return form_.constraints_at(t, y); }
  std::vector<std::string> constraint_names() const override { return form_.constraint_names(); }

 private:
  std::shared_ptr<const Model> model_;
};

using report::rounded_text;

std::string complex_text(const std::complex<double>& z) {
  if (z.imag() == 0.0) return rounded_text(z.real(), 6);
  return (z.real() == 0.0 ? "" : rounded_text(z.real(), 6)) + (z.real() == 0.0 ? "±" : " ± ") +
         rounded_text(std::abs(z.imag()), 6) + "i";
}

std::string shape_text(const DampedMode& mode, const std::vector<scenes::Coordinate>& coordinates) {
  std::string text;
  constexpr Eigen::Index most = 6;
  for (Eigen::Index i = 0; i < std::min(mode.shape.size(), most); ++i) {
    const auto visible = [](double x) { return std::abs(x) < 1e-7 ? 0.0 : x; };  // beside an entry of 1
    const double re = visible(mode.shape[i].real()), im = visible(mode.shape[i].imag());
    text += (i == 0 ? "" : ", ") + coordinates[static_cast<std::size_t>(i)].name + " " + rounded_text(re, 4);
    if (im != 0.0) text += (im < 0.0 ? " - " : " + ") + rounded_text(std::abs(im), 4) + "i";
  }
  return text + (mode.shape.size() > most ? ", …" : "");
}

report::Plot pole_map(const std::vector<SteadyPoint>& points, const std::string& rate) {
  const std::string unit = rate.empty() ? "" : " [" + rate + "]";
  report::Plot plot{.title = "Exponents", .x = {.label = "Re λ" + unit}, .y = {.label = "Im λ" + unit}, .height = 420};
  int number = 0;
  for (const SteadyPoint& point : points) {
    report::Series series{.label = points.size() == 1
                                       ? description(point.modes.stability)
                                       : std::to_string(++number) + ": " + description(point.modes.stability),
                          .x = {},
                          .y = {},
                          .markers = true};
    for (const std::complex<double>& lambda : point.modes.exponents) {
      for (const double gap :
           {0.0, std::numeric_limits<double>::quiet_NaN()}) {  // points, and no line from one to the next
        series.x.push_back(lambda.real() + gap);
        series.y.push_back(lambda.imag() + gap);
      }
    }
    plot.series.push_back(std::move(series));
  }
  return plot;
}

}  // namespace

SteadyRequest steady_request(const ModesOptions& options) {
  SteadyRequest request{chosen_scene(options)};
  if (request.model->guard_count() > 0) {
    throw UsageError("SCENE: must have constraints that last, for small motions beside a state, but " +
                     request.scene->name() + " has contacts or friction that switch (try --without, or another scene)");
  }
  request.steady = options.steady;
  request.paths = writable_files(options.out, {".csv", ".html"});
  return request;
}

SteadyPoint steady_point(const SteadyRequest& request, const Eigen::VectorXd& q) {
  const ModelFlow model(request.model);
  const qdot::detail::Flow& flow = model;
  State<Dynamic> start = request.start;
  start.q = q;
  if (!request.steady) start.qdot.setZero();
  const EquilibriumOptions search;
  const Eigen::VectorXd y = qdot::detail::steady_state_near(
      flow, {request.steady ? "steady motion" : "equilibrium", search.max_iterations, search.tolerance}, start.t,
      request.model->packed(start));
  SteadyPoint point{qdot::detail::linearized(flow, start.t, y), {}, request.model->reactions(start.t, y)};
  point.modes = damped_modes(point.linear);
  return point;
}

std::vector<bool> cyclic_coordinates(const SteadyRequest& request) {
  const Eigen::Index n = request.model->dof();
  State<Dynamic> start = request.start;
  if (!request.steady) start.qdot.setZero();
  const Eigen::VectorXd y = request.model->packed(start);
  Eigen::MatrixXd F(y.size(), y.size());
  request.model->jacobian(start.t, y, F);
  const Eigen::MatrixXd slopes = request.model->constraints_at(start.t, y).slopes;
  std::vector<bool> cyclic;
  for (Eigen::Index j = 0; j < n; ++j) {
    const bool in_constraints = slopes.size() > 0 && (!slopes.col(j).isZero(0.0) || !slopes.col(n + j).isZero(0.0));
    cyclic.push_back(!in_constraints && F.col(j).isZero(0.0));
  }
  return cyclic;
}

std::vector<PointsOfBranch> branches_along(const SteadyRequest& request, const ModelsAlong& models, double from, double to) {
  const qdot::detail::FlowAt flow_at = [&](double p) { return std::make_shared<const ModelFlow>(models(p)); };
  BranchOptions how;
  if (request.steady) how.qdot = request.start.qdot;
  std::vector<PointsOfBranch> all;
  for (const EquilibriumBranch& branch : qdot::detail::BranchSearch(flow_at, request.start.q, from, to, how).branches()) {
    all.push_back({{}, branch.message, branch.from});
    for (const BranchPoint& point : branch.points)
      all.back().points.push_back({std::string(name(point.kind)), point.p, point.q, point.z, point.exponents, point.growing, point.stability});
  }
  return all;
}

void print_modes(const SteadyRequest& request, const SteadyPoint& point) {
  const std::string unit = request.scene->time_unit(), per = unit.empty() ? "" : "/" + unit;
  std::printf("  %-26s %-18s %-14s %s\n", (per.empty() ? "exponent" : "exponent [1" + per + "]").c_str(),
              (per.empty() ? "frequency" : "frequency [rad" + per + "]").c_str(), "damping ratio", "shape");
  for (const DampedMode& mode : point.modes.modes) {
    const std::string exponent = complex_text(mode.exponent);
    const int wide = exponent.find("±") == std::string::npos ? 26 : 27;  // which is two bytes
    std::printf("  %-*s %-18s %-14s %s\n", wide, exponent.c_str(), rounded_text(mode.frequency(), 6).c_str(),
                rounded_text(mode.damping_ratio, 4).c_str(), shape_text(mode, request.scene->coordinates()).c_str());
  }
}

void write_steady_points(const SteadyRequest& request, const std::vector<SteadyPoint>& points) {
  if (request.paths.empty()) return;
  const std::string unit = request.scene->time_unit(), rate = unit.empty() ? "" : "1/" + unit,
                    angular = unit.empty() ? "" : "rad/" + unit;
  report::Table table;
  table.columns = {{"point", "", {}},
                   {"re", rate, {}},
                   {"im", angular, {}},
                   {"natural_frequency", angular, {}},
                   {"damping_ratio", "", {}}};
  const auto coordinates = request.scene->coordinates();
  for (const auto& c : coordinates) table.columns.push_back({c.name, c.unit, {}});
  report::Page page{.title = request.scene->title(), .lead = request.scene->summary()};
  double number = 0;
  for (const SteadyPoint& point : points) {
    ++number;
    report::Facts place{.heading = points.size() == 1 ? "Where" : "Where, " + rounded_text(number, 3), .rows = {}};
    for (std::size_t i = 0; i < coordinates.size(); ++i)
      place.rows.push_back({coordinates[i].name,
                            rounded_text(point.linear.q[static_cast<Eigen::Index>(i)], 8) + " " + coordinates[i].unit});
    for (std::size_t i = 0; i < coordinates.size(); ++i)
      if (const double turns = point.linear.qdot[static_cast<Eigen::Index>(i)]; turns != 0.0)
        place.rows.push_back({"rate of " + coordinates[i].name,
                              rounded_text(turns, 8) + " " + coordinates[i].unit + (unit.empty() ? "" : "/" + unit)});
    place.rows.push_back({"stability", description(point.modes.stability)});
    report::Facts modes{.heading = "Modes", .rows = {}};
    for (const DampedMode& mode : point.modes.modes) {
      const double row[] = {number, mode.exponent.real(), mode.exponent.imag(), mode.natural_frequency,
                            mode.damping_ratio};
      for (std::size_t i = 0; i < 5; ++i) table.columns[i].values.push_back(row[i]);
      for (Eigen::Index i = 0; i < point.linear.q.size(); ++i)
        table.columns[5 + static_cast<std::size_t>(i)].values.push_back(point.linear.q[i]);
      modes.rows.push_back(
          {complex_text(mode.exponent), "ζ = " + rounded_text(mode.damping_ratio, 4), shape_text(mode, coordinates)});
    }
    page.tables.push_back(std::move(place));
    page.tables.push_back(std::move(modes));
  }
  page.plots.push_back(pole_map(points, rate));
  report::write_files({{request.paths[0], report::csv(table)}, {request.paths[1], report::html(report::in_symbols(std::move(page)))}});
}

}  // namespace qdot::program
