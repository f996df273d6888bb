// SPDX-License-Identifier: MIT
#include "program/json.hpp"

#include <cmath>
#include <complex>
#include <nlohmann/json.hpp>

#include "program/orbit_search.hpp"
#include "program/orbit_turns.hpp"
#include "program/sensitivity.hpp"
#include "program/steady_points.hpp"

namespace qdot::program {

namespace {

using Json = nlohmann::ordered_json;

Json numbers(const Eigen::Ref<const Eigen::VectorXd>& values) {
  Json array = Json::array();
  for (const double value : values) array.push_back(value);
  return array;
}

Json parameter_values(const RunnableScene& scene) {
  Json object = Json::object();
  for (const ParameterInfo& p : scene.parameters()) {
    if (p.whole) {
      object[p.name] = std::lround(p.value);
    } else {
      object[p.name] = p.value;
    }
  }
  return object;
}

Json effects_that_are_on(const RunnableScene& scene) {
  Json array = Json::array();
  for (const EffectInfo& effect : scene.effects()) {
    if (effect.on) array.push_back({{"name", effect.name}, {"value", effect.value}});
  }
  return array;
}

Json coordinate_names(const RunnableScene& scene) {
  Json array = Json::array();
  for (const auto& c : scene.coordinates()) array.push_back(c.name);
  return array;
}

Json json_of(const std::vector<Reaction>& reactions) {
  Json array = Json::array();
  for (const Reaction& r : reactions) array.push_back({{"name", r.name}, {"lambda", r.lambda}});
  return array;
}

/// The scene and how it is to be simulated, with what the run chose where that was left to it.
Json asked_json(const RunnableScene& scene, const Request& request, const Result& result) {
  Json json;
  json["scene"] = scene.name();
  json["parameters"] = parameter_values(scene);
  json["effects"] = effects_that_are_on(scene);
  json["method"] = request.method;
  json["method_chosen"] = result.statistics.method;
  json["method_reason"] = nullptr;
  if (!result.statistics.method_reason.empty()) json["method_reason"] = result.statistics.method_reason;
  json["evaluated_by"] = result.statistics.evaluated_by;
  json["step"] = nullptr;
  if (result.step) json["step"] = *result.step;
  json["rtol"] = request.rtol;
  json["atol"] = request.atol;
  return json;
}

/// How the run ended, and both ends of the motion.
void add_motion(Json& json, const RunnableScene& scene, const Request& request, const Result& result) {
  const Eigen::Index n = request.start.q.size();
  json["outcome"] = std::string(name(result.outcome));
  json["message"] = result.message;
  json["coordinates"] = coordinate_names(scene);
  json["t_start"] = request.start.t;
  json["t_end"] = request.t_end;
  json["q_initial"] = numbers(request.start.q);
  json["qdot_initial"] = numbers(request.start.qdot);
  json["t"] = result.end.t;
  json["q"] = numbers(result.end.y.head(n));
  json["qdot"] = numbers(result.end.y.segment(n, n));
}

void add_energies(Json& json, const Result& result) {
  json["energy_initial"] = result.energy.initial;
  json["energy_final"] = result.energy.final;
  json["energy_drift_max"] = result.energy.largest;
  json["jacobi_energy_initial"] = result.jacobi.initial;
  json["jacobi_energy_final"] = result.jacobi.final;
  json["jacobi_energy_drift_max"] = result.jacobi.largest;
  json["energy_work"] = result.balance.work;
  json["energy_impacts"] = result.balance.impacts;
  json["energy_balance_max"] = result.balance.residual;
}

/// How well constraints are kept, how far they moved the start, and their reactions; null and no more where there are none.
void add_constraints(Json& json, const Result& result) {
  json["constraint_residual_max"] = nullptr;
  json["constraint_velocity_max"] = nullptr;
  if (!result.start_moved) return;
  json["constraint_residual_max"] = result.statistics.constraint_residual;
  json["constraint_velocity_max"] = result.statistics.constraint_velocity;
  json["start_moved"] = {{"q", result.start_moved->moved_q}, {"qdot", result.start_moved->moved_qdot}};
  json["reactions"] = json_of(result.reactions);
}

void add_cost(Json& json, const Statistics& statistics) {
  json["mass_rcond_min"] = statistics.mass_rcond;
  json["steps"] = statistics.steps;
  json["rejected"] = statistics.rejected();
  json["evaluations"] = statistics.evaluations;
  json["jacobians"] = statistics.jacobians;
  json["wall_seconds"] = statistics.wall_seconds;
}

/// What the search for an accuracy of the whole motion found; null where none was asked for.
void add_accuracy(Json& json, const std::optional<AccuracyReport>& report) {
  json["accuracy"] = nullptr;
  json["error_estimate"] = nullptr;
  if (!report) return;
  json["accuracy"] = report->accuracy;
  json["error_estimate"] = report->error_estimate;  // null where nothing could be compared
  json["event_time_error"] = report->event_time_error;
  json["accuracy_runs"] = report->trials.size();
  json["accuracy_seconds"] = report->seconds;
  Json forecast = Json::array();
  for (const AccuracyForecast& f : report->forecast) {
    Json entry = {{"accuracy", f.accuracy}, {"seconds", f.seconds}, {"factor", f.factor}};
    if (!f.reachable) entry["seconds"] = entry["factor"] = nullptr;
    if (f.accuracy > 0) forecast.push_back(entry);
  }
  json["forecast"] = forecast;
}

std::string range_text(const ParameterInfo& p) { return p.whole ? "whole number " + p.range.text() : p.range.text(); }

}  // namespace

std::string run_json(const RunnableScene& scene, const Request& request, const Result& result,
                     const std::vector<std::string>& files) {
  Json json = asked_json(scene, request, result);
  add_motion(json, scene, request, result);
  add_energies(json, result);
  add_constraints(json, result);
  add_cost(json, result.statistics);
  add_accuracy(json, result.accuracy);
  Json events = Json::array();
  for (const RecordedEvent& e : result.events) events.push_back({{"t", e.t}, {"name", e.name}});
  json["events"] = events;
  json["files"] = files;
  return json.dump(2);
}

std::string steady_states_json(const RunnableScene& scene, const std::vector<SteadyPoint>& points, SteadyList list) {
  const auto complex = [](const std::complex<double>& z) { return Json::array({z.real(), z.imag()}); };
  Json all = Json::array();
  for (const SteadyPoint& point : points) {
    Json json;
    json["q"] = numbers(point.linear.q);
    json["qdot"] = numbers(point.linear.qdot);
    json["stability"] = description(point.modes.stability);
    json["growth"] = point.modes.growth;
    json["states"] = point.linear.states;
    json["exponents"] = Json::array();
    for (const std::complex<double>& lambda : point.modes.exponents) json["exponents"].push_back(complex(lambda));
    json["modes"] = Json::array();
    for (const DampedMode& mode : point.modes.modes) {
      Json shape = Json::array();
      for (const std::complex<double>& entry : mode.shape) shape.push_back(complex(entry));
      json["modes"].push_back({{"exponent", complex(mode.exponent)}, {"frequency", mode.frequency()}, {"natural_frequency", mode.natural_frequency},
                               {"damping_ratio", mode.damping_ratio}, {"shape", shape}});
    }
    json["A"] = Json::array();
    for (Eigen::Index i = 0; i < point.linear.A.rows(); ++i) json["A"].push_back(numbers(point.linear.A.row(i).transpose()));
    json["reactions"] = json_of(point.reactions);
    all.push_back(json);
  }
  Json json;
  json["scene"] = scene.name();
  json["parameters"] = parameter_values(scene);
  json["effects"] = effects_that_are_on(scene);
  json["coordinates"] = coordinate_names(scene);
  if (list == SteadyList::the_only_one) {
    json.update(all.front());
  } else {
    json["family"] = list == SteadyList::some_of_a_family;
    json["equilibria"] = all;
  }
  return json.dump(2);
}

std::string branches_json(const RunnableScene& scene, const std::string& name, double from, double to, const std::vector<PointsOfBranch>& branches) {
  Json json;
  json["scene"] = scene.name();
  json["parameters"] = parameter_values(scene);
  json["along"] = {{"name", name}, {"from", from}, {"to", to}};
  json["coordinates"] = coordinate_names(scene);
  json["branches"] = Json::array();
  for (const PointsOfBranch& branch : branches) {
    Json points = Json::array();
    for (const PointOfBranch& point : branch.points) {
      Json exponents = Json::array();
      for (const std::complex<double>& lambda : point.exponents) exponents.push_back({lambda.real(), lambda.imag()});
      points.push_back({{"kind", point.kind}, {"p", point.p}, {"q", numbers(point.q)}, {"z", numbers(point.z)}, {"growing", point.growing},
                        {"stability", description(point.stability)}, {"exponents", exponents}});
    }
    Json begins = nullptr;
    if (branch.from) begins = {{"branch", branch.from->first}, {"point", branch.from->second}};
    json["branches"].push_back({{"from", begins}, {"message", branch.message}, {"points", points}});
  }
  return json.dump(2);
}

namespace {

Json json_of(const Orbit& orbit) {
  Json json;
  json["outcome"] = name(orbit.outcome);
  json["message"] = orbit.message;
  json["run_outcome"] = name(orbit.run_outcome);
  json["t"] = orbit.t;
  json["x"] = numbers(orbit.x);
  json["period"] = orbit.period;
  json["energy"] = orbit.energy;
  json["conserves_energy"] = orbit.conserves_energy;
  json["stability"] = orbit.found() ? Json(description(orbit.stability)) : Json(nullptr);
  json["multipliers"] = Json::array();
  for (const Multiplier& m : orbit.multipliers)
    json["multipliers"].push_back({{"re", m.value.real()}, {"im", m.value.imag()}, {"radius", m.radius}, {"trivial", m.trivial}});
  json["residual"] = numbers(orbit.residual);
  json["extent"] = numbers(orbit.extent);
  json["symmetries"] = orbit.symmetries;
  json["undetermined"] = orbit.undetermined;
  return json;
}

}  // namespace

std::string orbit_json(const RunnableScene& scene, const std::vector<std::string>& names, const Orbit& orbit, const std::vector<Turns>& turns,
                       const Eigen::VectorXd& moved) {
  Json json;
  json["scene"] = scene.name();
  json["parameters"] = parameter_values(scene);
  json["components"] = names;
  json.update(json_of(orbit));
  json["swings"] = json["rounds"] = Json::array();
  for (const Turns& each : turns) {
    json["swings"].push_back(each.swings);
    json["rounds"].push_back(each.rounds);
  }
  json["moved"] = numbers(moved);
  return json.dump(2);
}

std::string family_json(const RunnableScene& scene, const std::vector<std::string>& names, const std::string& along, const FamilyFound& family) {
  Json json;
  json["scene"] = scene.name();
  json["parameters"] = parameter_values(scene);
  json["components"] = names;
  json["along"] = along;
  json["outcome"] = family.outcome;
  json["message"] = family.message;
  json["orbits"] = Json::array();
  for (const OrbitOfFamily& each : family.orbits) {
    Json one = {{"kind", each.kind}, {"value", each.value}};
    one.update(json_of(each.orbit));
    json["orbits"].push_back(one);
  }
  return json.dump(2);
}

std::string sensitivity_json(const RunnableScene& scene, const SensitivityTable& table) {
  Json json;
  json["scene"] = scene.name();
  json["method"] = table.method;
  json["parameters"] = parameter_values(scene);
  json["outcome"] = table.outcome;
  json["message"] = table.message;
  json["t"] = table.t;
  json["of"] = table.of;
  json["values"] = numbers(table.values);
  json["to"] = Json::array();
  for (const DependsOn& to : table.to) json["to"].push_back({{"name", to.name}, {"unit", to.unit}, {"value", to.value}});
  json["derivative"] = Json::array();
  json["error"] = Json::array();
  for (Eigen::Index i = 0; i < table.derivative.rows(); ++i) {
    json["derivative"].push_back(numbers(table.derivative.row(i).transpose()));
    json["error"].push_back(numbers(table.error.row(i).transpose()));
  }
  return json.dump(2);
}

std::string list_json(const std::vector<std::unique_ptr<RunnableScene>>& scenes) {
  Json list = Json::array();
  for (const auto& scene : scenes) {
    Json parameters = Json::array();
    for (const ParameterInfo& p : scene->parameters()) {
      Json parameter = {{"name", p.name}, {"default", p.value}, {"unit", p.unit}, {"range", range_text(p)}, {"meaning", p.meaning}};
      if (p.whole) parameter["default"] = std::lround(p.value);
      parameters.push_back(parameter);
    }
    Json coordinates = Json::array();
    for (const auto& c : scene->coordinates()) coordinates.push_back({{"name", c.name}, {"unit", c.unit}});
    Json effects = Json::array();
    for (const EffectInfo& e : scene->effects()) {
      effects.push_back({{"name", e.name}, {"default", e.value}, {"unit", e.unit}, {"meaning", e.meaning}});
    }
    const auto start = scene->start();
    list.push_back({{"name", scene->name()},
                    {"title", scene->title()},
                    {"summary", scene->summary()},
                    {"degrees_of_freedom", scene->coordinates().size()},
                    {"coordinates", coordinates},
                    {"parameters", parameters},
                    {"q", numbers(start.q)},
                    {"qdot", numbers(start.qdot)},
                    {"t_end", scene->t_end()},
                    {"effects", effects}});
  }
  return Json{{"scenes", list}, {"methods", method_names()}}.dump(2);
}

}  // namespace qdot::program
