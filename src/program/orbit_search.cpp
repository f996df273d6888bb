// SPDX-License-Identifier: MIT
#include "program/orbit_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <utility>

#include "program/varied_motion.hpp"
#include "qdot/analysis/orbit_family.hpp"
#include "qdot/integrate/accurate/motion.hpp"
#include "qdot/mechanics/equations/ordinary_size.hpp"

namespace qdot::program {

namespace {

using qdot::detail::Shot;

Options precise() { return Options{.rtol = 1e-13, .atol = AbsoluteTolerance::at_most(1e-14)}; }

VariedMotion plain_motion(const std::shared_ptr<const Model>& model, double t, const Eigen::VectorXd& x, double duration, int count, Options options) {
  const Eigen::Index n = model->dof();
  for (int k = 0; k <= count; ++k) options.output_times.push_back(k == count ? t + duration : t + duration * k / count);
  const Eigen::VectorXd y = settled(*model, t, model->packed({t, x.head(n), x.tail(n)}));
  return varied_motion({model, false}, t, y, t + duration, options);
}

Eigen::VectorXd x_of(const State<Dynamic>& state) {
  Eigen::VectorXd x(2 * state.q.size());
  x << state.q, state.qdot;
  return x;
}

// What the search for orbits asks of a scene.
class ModelShooting final : public qdot::detail::Shooting {
 public:
  /// Shots that take more steps have failed.
  explicit ModelShooting(const OrbitRequest& request, long max_steps = Options{}.max_steps)
      : request_(request), dof_(request.model->dof()), max_steps_(max_steps) {}

  Eigen::Index size() const override { return 2 * dof_; }
  double time() const override { return request_.start.t; }
  bool has_parameter() const override { return request_.models.has_value(); }
  bool projects() const override { return request_.model->is_constrained(); }
  std::string name(Eigen::Index i) const override { return request_.model->component_name(i); }

  Shot shot(const Eigen::VectorXd& x, double period, double p, double coarser) const override {
    constexpr int samples = 24;
    Options options = precise();
    options.max_steps = max_steps_;
    options.rtol *= coarser;
    options.atol = AbsoluteTolerance::at_most(1e-14 * coarser);
    for (int k = 0; k <= samples; ++k) options.output_times.push_back(k == samples ? time() + period : time() + period * k / samples);
    VariedModel varied{model(p)};
    if (has_parameter()) {
      varied.parameters = {p};
      varied.with_parameter = [&](Eigen::Index, double value) { return (*request_.models)(value); };
    }
    const VariedMotion motion = varied_motion(varied, time(), packed(*varied.model, x), time() + period, options);
    Shot shot{motion.outcome, motion.message, motion.y.head(size()), motion.ydot.head(size()), motion.Phi.topLeftCorner(size(), size())};
    if (has_parameter()) shot.by_parameter = motion.Phi.col(size()).head(size());
    Eigen::VectorXd least = x, most = x;
    for (const Eigen::VectorXd& y : motion.samples) {
      least = least.cwiseMin(y.head(size()));
      most = most.cwiseMax(y.head(size()));
    }
    shot.extent = most - least;
    return shot;
  }
  Eigen::VectorXd rate(const Eigen::VectorXd& x, double p, double later) const override {
    const auto here = model(p);
    const Eigen::VectorXd y = packed(*here, x);
    Eigen::VectorXd f(y.size());
    here->derivative(time() + later, y, f);
    return f.head(size());
  }
  double energy(const Eigen::VectorXd& x, double p, double later) const override {
    const auto here = model(p);
    return here->energies(time() + later, here->packed({time(), x.head(dof_), x.tail(dof_)})).jacobi;
  }
  Eigen::VectorXd momenta(const Eigen::VectorXd& x, double p, double later) const override {
    return model(p)->momenta(time() + later, x.head(dof_), x.tail(dof_));
  }
  Eigen::VectorXd settled(const Eigen::VectorXd& x, double p) const override {
    if (!projects()) return x;
    return packed(*model(p), x).head(size());
  }

 private:
  std::shared_ptr<const Model> model(double p) const {
    if (!request_.models) return request_.model;
    if (!last_ || p != at_) {
      last_ = (*request_.models)(p);
      at_ = p;
    }
    return last_;
  }
  Eigen::VectorXd packed(const Model& model, const Eigen::VectorXd& x) const {
    return program::settled(model, time(), model.packed({time(), x.head(dof_), x.tail(dof_)}));
  }

  const OrbitRequest& request_;
  Eigen::Index dof_;
  long max_steps_;
  mutable std::shared_ptr<const Model> last_;
  mutable double at_ = 0.0;
};

Held held_of(const OrbitRequest& request) {
  switch (request.held) {
    case OrbitRequest::Held::energy: return request.energy ? hold_energy(*request.energy) : hold_energy();
    case OrbitRequest::Held::period: return hold_period();
    case OrbitRequest::Held::coordinate: return hold_coordinate(request.coordinate);
    case OrbitRequest::Held::drive: return driven();
    default: return hold_nothing();
  }
}

Eigen::VectorXd guess_of(const OrbitRequest& request, const Eigen::VectorXd& x, double period) {
  Eigen::VectorXd X(x.size() + 2);
  X << x, period, request.models ? request.from : 0.0;
  return X;
}

/// Whether q̇ or q̈ differs at another time of the window; also beside the start, because a drive may vanish where the motion begins.
///
/// @throws Error  where the start has no derivative
bool is_driven(const Model& model, double t, const Eigen::VectorXd& y0, double window) {
  const Eigen::Index n = model.dof();
  Eigen::VectorXd f(y0.size()), later(y0.size());
  Eigen::VectorXd sizes = y0.cwiseAbs();
  detail::lend_sizes(sizes, n, 0.0);
  for (double& size : sizes) size = detail::reach_of(size);
  bool driven = false;
  for (const double beside : {0.0, 0.1}) {
    Eigen::VectorXd y = y0;
    for (Eigen::Index i = 0; i < 2 * n; ++i) y[i] += beside * (1.0 + 0.3 * static_cast<double>(i % 3)) * sizes[i];
    try {
      model.derivative(t, y, f);
      for (const double part : {0.31, 0.77}) {
        model.derivative(t + part * window, y, later);
        driven = driven || (later - f).head(2 * n).cwiseAbs().maxCoeff() > 1e-9 * f.cwiseAbs().maxCoeff();
      }
    } catch (const Error&) {
      if (beside == 0.0) throw;
    }
  }
  return driven;
}

/// Whether Jacobi's energy keeps the value h on the motion, as far as energies are large.
bool keeps_energy(const Model& model, const VariedMotion& motion, double h) {
  double drift = 0.0, scale = 0.0;
  for (std::size_t k = 0; k < motion.samples.size(); ++k) {
    const Energies energies = model.energies(motion.times[k], motion.samples[k]);
    drift = std::max(drift, std::abs(energies.jacobi - h));
    scale = std::max({scale, std::abs(energies.kinetic), std::abs(energies.potential)});
  }
  return drift <= 1e-6 * scale;
}

/// How far states [q; q̇] are from the start of a motion, whole turns of angles aside.
struct FromStart {
  Eigen::VectorXd start;
  std::vector<scenes::Coordinate> coordinates;
  Eigen::Index n;

  double turns(const Eigen::VectorXd& y, Eigen::Index i) const {
    constexpr double turn = 2.0 * std::numbers::pi;
    return coordinates[static_cast<std::size_t>(i)].unit == "rad" ? turn * std::round((y[i] - start[i]) / turn) : 0.0;
  }
  double distance(const Eigen::VectorXd& y, Eigen::Index i) const { return std::abs(y[i] - start[i] - (i < n ? turns(y, i) : 0.0)); }

  /// The largest distance of each entry.
  Eigen::VectorXd extent(const std::vector<Eigen::VectorXd>& samples) const {
    Eigen::VectorXd extent = Eigen::VectorXd::Zero(2 * n);
    for (const Eigen::VectorXd& y : samples)
      for (Eigen::Index i = 0; i < 2 * n; ++i) extent[i] = std::max(extent[i], distance(y, i));
    return extent;
  }

  /// For each sample, the largest distance of its entries in parts of their extent.
  std::vector<double> away(const std::vector<Eigen::VectorXd>& samples) const {
    const Eigen::VectorXd extent = this->extent(samples);
    std::vector<double> away;
    for (const Eigen::VectorXd& y : samples) {
      double farthest = 0.0;
      for (Eigen::Index i = 0; i < 2 * n; ++i)
        if (extent[i] > 1e-9 * extent.maxCoeff()) farthest = std::max(farthest, distance(y, i) / extent[i]);
      away.push_back(farthest);
    }
    return away;
  }
};

/// The samples at which a motion that has left its start is nearer to it than at any before, up to the first that is near; else the last sample.
std::vector<std::size_t> returns_in(const std::vector<double>& away) {
  constexpr double near = 0.05, far = 0.5;
  constexpr std::size_t most = 6;
  std::vector<std::size_t> returns;
  bool left = false;
  double least = 2.0;
  for (std::size_t k = 1; k + 1 < away.size() && least >= near; ++k) {
    left = left || away[k] > far;
    if (!left || away[k] > away[k - 1] || away[k] > away[k + 1] || away[k] >= least) continue;
    if (least > far) returns.clear();
    least = away[k];
    returns.push_back(k);
  }
  if (returns.empty()) return {away.size() - 1};
  if (returns.size() > most) returns.erase(returns.begin() + most - 1, returns.end() - 1);
  return returns;
}

Return return_at(const FromStart& from_start, const Eigen::VectorXd& y, double period) {
  Return back{period, Eigen::VectorXd::Zero(from_start.n)};
  for (Eigen::Index i = 0; i < from_start.n; ++i) back.advance[i] = from_start.turns(y, i);
  return back;
}

/// The same orbit with the shortest part of its period that closes it, and with what its angles advance in that.
Orbit shortest_round(OrbitRequest& request, Orbit orbit) {
  constexpr int samples = 4000;
  constexpr double near = 0.1, same = 1e-6;
  if (request.held == OrbitRequest::Held::drive || request.held == OrbitRequest::Held::period) return orbit;
  const std::vector<Eigen::VectorXd> points = points_of(request, orbit, samples);
  const FromStart from_start{orbit.x, request.scene->coordinates(), request.model->dof()};
  const std::vector<double> away = from_start.away(points);
  bool left = false;
  for (std::size_t j = 1; 2 * j <= away.size(); ++j) {
    left = left || away[j] > 0.5;
    if (!left || away[j] > near || away[j] > away[j - 1] || away[j] > away[j + 1]) continue;
    const double parts = std::round(samples / static_cast<double>(j));
    if (std::abs(samples / parts - static_cast<double>(j)) > 1.0) continue;
    const Return part = return_at(from_start, points[j], orbit.period / parts);
    Orbit shorter = orbit;
    shorter.period = part.period;
    std::vector<Eigen::VectorXd> with_end = points;  // which say how far entries extend
    with_end.push_back(points_of(request, shorter, 1).back());
    if (from_start.away(with_end).back() > same) continue;
    Orbit found = qdot::detail::orbit_near(ModelShooting(request), guess_of(request, orbit.x, part.period), held_of(request), {.advance = part.advance});
    if (!found.found() || std::abs(found.period - part.period) > same * part.period) continue;
    request.period = found.period;
    request.advance = part.advance;
    return found;
  }
  return orbit;
}

}  // namespace

Returns returns_to_start(const ChosenScene& chosen, const Model& model, std::optional<double> period) {
  constexpr int samples = 4000;
  constexpr double usual_windows = 4.0;
  const State<Dynamic>& start = chosen.start;
  const Eigen::Index n = model.dof();
  const double usual = std::abs(chosen.scene->t_end() - start.t), window = period ? *period : usual_windows * usual;
  const std::shared_ptr<const Model> borrowed(std::shared_ptr<const Model>(), &model);
  Returns found;
  const Eigen::VectorXd y0 = settled(model, start.t, model.packed(start));
  found.driven = is_driven(model, start.t, y0, window);

  Options options{.rtol = 1e-9, .atol = AbsoluteTolerance::at_most(1e-9)};
  const VariedMotion motion = plain_motion(borrowed, start.t, x_of(start), window, samples, options);
  if (motion.samples.size() < 3) {
    found.each = {{window, Eigen::VectorXd::Zero(n)}};
    return found;
  }
  found.conserves_energy = keeps_energy(model, motion, model.energies(start.t, y0).jacobi);
  const FromStart from_start{y0, chosen.scene->coordinates(), n};
  const std::vector<std::size_t> last = {motion.samples.size() - 1};
  for (const std::size_t k : period ? last : returns_in(from_start.away(motion.samples)))
    found.each.push_back(return_at(from_start, motion.samples[k], std::abs(motion.times[k] - start.t)));
  return found;
}

Orbit orbit_near(OrbitRequest& request, const std::vector<Return>& returns) {
  constexpr double near = 0.1, much = 0.5;  // in parts of what components extend over
  constexpr long few_steps = 20'000;        // of a shot, where a later return can be taken instead
  Orbit best;
  Return taken;
  double least = std::numeric_limits<double>::infinity();
  for (const Return& back : returns) {
    const bool is_last = &back == &returns.back();
    const ModelShooting shooting(request, is_last ? Options{}.max_steps : few_steps);
    Orbit orbit = qdot::detail::orbit_near(shooting, guess_of(request, x_of(request.start), back.period), held_of(request), {.advance = back.advance});
    const double moved = orbit.found() ? moved_by(request, orbit).maxCoeff() : std::numeric_limits<double>::infinity();
    if (moved < much * least || (is_last && !best.found())) {
      best = std::move(orbit);
      taken = back;
      least = moved;
    }
    if (least <= near) break;
  }
  request.period = taken.period;
  request.advance = taken.advance;
  return best.found() ? shortest_round(request, std::move(best)) : best;
}

Eigen::VectorXd beginning_of(const OrbitRequest& request) {
  return ModelShooting(request).settled(x_of(request.start), request.models ? request.from : 0.0);
}

Eigen::VectorXd moved_by(const OrbitRequest& request, const Orbit& orbit) {
  constexpr double visible = 1e-6;
  const Eigen::Index n = request.model->dof();
  const FromStart from_start{beginning_of(request), request.scene->coordinates(), n};
  Eigen::VectorXd moved = Eigen::VectorXd::Zero(2 * n);
  for (Eigen::Index i = 0; i < 2 * n; ++i) {
    const std::vector<std::string>& open = orbit.undetermined;
    if (std::find(open.begin(), open.end(), request.model->component_name(i)) != open.end()) continue;
    const double size = std::max(std::abs(orbit.x[i]), std::abs(from_start.start[i]));
    const double extent = i < orbit.extent.size() && orbit.extent[i] > visible * size ? orbit.extent[i] : size;
    if (extent > 0.0) moved[i] = from_start.distance(orbit.x, i) / extent;
  }
  return moved;
}

FamilyFound family_from(const OrbitRequest& request, const Orbit& orbit) {
  using In = OrbitRequest::In;
  const ModelShooting shooting(request);
  const FamilyIn in = request.in == In::energy ? in_energy(request.to) : request.in == In::period ? in_period(request.to) : in_parameter(request.to);
  FamilyOptions options;
  options.orbit.advance = request.advance;
  options.longest_step = options.first_step;  // so that curves look like curves
  const auto found = qdot::detail::family_from(shooting, guess_of(request, orbit.x, orbit.period), in, held_of(request), options);
  FamilyFound family{std::string(name(found.outcome)), found.message, {}, found.outcome == FamilyOutcome::reached || found.outcome == FamilyOutcome::returned};
  for (const FamilyOrbit& each : found.orbits) family.orbits.push_back({std::string(name(each.kind)), each.value, each});
  return family;
}

std::vector<Eigen::VectorXd> points_of(const OrbitRequest& request, const Orbit& orbit, int count) {
  const auto model = request.models ? (*request.models)(orbit.parameter) : request.model;
  return plain_motion(model, orbit.t, orbit.x, orbit.period, count, Options{.rtol = 1e-11}).samples;
}

State<Dynamic> state_after(const ChosenScene& chosen, const Model& model, double time) {
  const std::shared_ptr<const Model> borrowed(std::shared_ptr<const Model>(), &model);
  const Options options{.rtol = 1e-10, .atol = AbsoluteTolerance::at_most(1e-10)};
  const VariedMotion motion = plain_motion(borrowed, chosen.start.t, x_of(chosen.start), time, 1, options);
  if (motion.outcome != Outcome::completed) throw Error(motion.message);
  const Eigen::Index n = model.dof();
  return {motion.t, motion.y.head(n), motion.y.segment(n, n)};
}

}  // namespace qdot::program
