// SPDX-License-Identifier: MIT
#include "program/swept_quantities.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "program/arguments.hpp"
#include "program/chosen_scene.hpp"
#include "program/exponents.hpp"

namespace qdot::program {

namespace {

using Kind = Quantity::Kind;
constexpr int places = 8;  // in a step

// Events have the name of a contact or a dry friction, perhaps with what it does behind it: "floor", "block sticks".
void require_event(const std::string& event, const RunnableScene& scene, const Model& model) {
  std::string names;
  for (const OwnState& state : model.own_states()) {
    if (state.kind != OwnState::phase) continue;
    if (event == state.name || event.starts_with(state.name + " ")) return;
    names += (names.empty() ? "" : ", ") + state.name;
  }
  throw UsageError("--record t(event " + event + "): " + scene.name() +
                   (names.empty() ? " has no contacts or dry friction, and no events; t(NAME=VALUE) is when a coordinate passes a value"
                                  : " has events of " + names + " only"));
}

/// Reads what --record says of one scene.
class RecordReader {
 public:
  RecordReader(const RunnableScene& scene, const Model& model)
      : scene_(scene), model_(model), time_(scene.time_unit()), names_(names_of_start(scene)) {}

  /// @throws UsageError
  Quantity quantity(const std::string& text) const {
    Quantity quantity{.text = text};
    if (!is_of_motion(quantity)) read_of_component(quantity);
    if (quantity.kind == Kind::at_end || quantity.kind == Kind::greatest || quantity.kind == Kind::least)
      quantity.unit = names_[static_cast<std::size_t>(quantity.component)].unit;
    return quantity;
  }

 private:
  /// Whether it is one that has a name of its own, and is of the whole motion; kind and unit, if so.
  bool is_of_motion(Quantity& quantity) const {
    if (quantity.text == "alignment") {
      std::fputs("qdot sweep: --record alignment is deprecated; say --record gali\n", stderr);
      quantity.text = "gali";
    }
    const std::string& text = quantity.text;
    if (text == "energy" || text == "energy_drift_max") {
      quantity.kind = text == "energy" ? Kind::energy : Kind::energy_drift;
      quantity.unit = scene_.energy_unit();
    } else if (text == "steps") {
      quantity.kind = Kind::steps;
    } else if (text == "lyapunov" || text == "gali") {
      if (const std::string why = lacks_exponents(model_); !why.empty()) throw UsageError("--record " + text + ": " + scene_.name() + " " + why);
      quantity.kind = text == "lyapunov" ? Kind::lyapunov : Kind::gali;
      if (text == "lyapunov" && !time_.empty()) quantity.unit = "1/" + time_;
    } else if (text == "t") {
      quantity.kind = Kind::time;
      quantity.unit = time_;
    } else {
      return false;
    }
    return true;
  }

  /// NAME, min(NAME), max(NAME) and t(…).
  void read_of_component(Quantity& quantity) const {
    const std::string& text = quantity.text;
    if (const std::string least = inside("min", text); !least.empty()) {
      quantity.kind = Kind::least;
      quantity.component = component(least);
    } else if (const std::string greatest = inside("max", text); !greatest.empty()) {
      quantity.kind = Kind::greatest;
      quantity.component = component(greatest);
    } else if (const std::string when = inside("t", text); !when.empty()) {
      read_time(quantity, when);
    } else {
      quantity.component = component(text);
    }
  }

  /// When something happens first: "NAME=VALUE", "|NAME|=VALUE" or "event EVENT".
  void read_time(Quantity& quantity, const std::string& when) const {
    quantity.unit = time_;
    if (when.starts_with("event ")) {
      quantity.kind = Kind::event;
      quantity.event = when.substr(6);
      require_event(quantity.event, scene_, model_);
      return;
    }
    const std::size_t equals = when.find('=');
    if (equals == std::string::npos) throw UsageError("--record: must be t(NAME=VALUE), t(|NAME|=VALUE) or t(event NAME), given " + quantity.text);
    std::string name = when.substr(0, equals);
    quantity.absolute = name.size() > 2 && name.front() == '|' && name.back() == '|';
    if (quantity.absolute) name = name.substr(1, name.size() - 2);
    quantity.kind = Kind::passage;
    quantity.component = component(name);
    quantity.value = finite_number("--record", when.substr(equals + 1));
  }

  /// What stands in the parentheses of head(…); "" where the text is not that.
  static std::string inside(const std::string& head, const std::string& text) {
    return text.size() > head.size() + 2 && text.starts_with(head + "(") && text.back() == ')'
               ? text.substr(head.size() + 1, text.size() - head.size() - 2)
               : std::string();
  }

  /// The place of a coordinate or velocity in [q; q̇].
  Eigen::Index component(const std::string& name) const {
    std::vector<std::string> all;
    for (std::size_t i = 0; i < names_.size(); ++i) {
      if (name == names_[i].name || name == names_[i].plain) return static_cast<Eigen::Index>(i);
      all.push_back(names_[i].name);
    }
    for (const ComponentNames& entry : names_) all.push_back(entry.plain);
    for (const char* other : {"t", "energy", "energy_drift_max", "steps", "lyapunov", "gali"}) all.emplace_back(other);
    throw unknown_name("--record", "a coordinate, a velocity or a quantity of " + scene_.name(), name, all);
  }

  const RunnableScene& scene_;
  const Model& model_;
  std::string time_;  // its unit
  std::vector<ComponentNames> names_;
};

}  // namespace

std::vector<Quantity> quantities_of(const std::vector<std::string>& records, const RunnableScene& scene, const Model& model) {
  std::vector<std::string> wanted = records;
  if (wanted.empty())
    for (const auto& coordinate : scene.coordinates()) wanted.push_back(coordinate.name);
  const RecordReader reader(scene, model);
  std::vector<Quantity> quantities;
  for (const std::string& text : wanted) quantities.push_back(reader.quantity(text));
  return quantities;
}

QuantityWatch::QuantityWatch(const std::vector<Quantity>& quantities, std::shared_ptr<const Model> model)
    : quantities_(quantities), model_(std::move(model)), found_(quantities.size(), std::numeric_limits<double>::quiet_NaN()), before_(quantities.size(), 0.0) {
  for (const Quantity& quantity : quantities) {
    wants_steps_ = wants_steps_ || quantity.kind == Kind::greatest || quantity.kind == Kind::least || quantity.kind == Kind::passage ||
                   quantity.kind == Kind::energy_drift;
    only_passages_ = only_passages_ && quantity.kind == Kind::passage;
  }
}

double QuantityWatch::off(const Quantity& quantity, const Eigen::Ref<const Eigen::VectorXd>& y) const {
  const double x = y[quantity.component];
  return (quantity.absolute ? std::abs(x) : x) - quantity.value;
}

bool QuantityWatch::see(const StepView& step) {
  const double from = step.t_previous(), to = step.t();
  const auto time = [&](int k) { return k == places ? to : from + (to - from) * k / places; };
  bool all_found = true;
  for (int k = begun_ ? 1 : 0; k <= places; ++k) {
    const Eigen::VectorXd y = k == places ? Eigen::VectorXd(step.y()) : step.y_at(time(k));
    for (std::size_t i = 0; i < quantities_.size(); ++i) {
      const Quantity& quantity = quantities_[i];
      double& found = found_[i];
      if (quantity.kind == Kind::greatest) found = std::isnan(found) ? y[quantity.component] : std::max(found, y[quantity.component]);
      if (quantity.kind == Kind::least) found = std::isnan(found) ? y[quantity.component] : std::min(found, y[quantity.component]);
      if (quantity.kind == Kind::passage && std::isnan(found)) {
        const double now = off(quantity, y);
        if (k > 0 && before_[i] * now <= 0.0 && before_[i] != now && before_[i] != 0.0) {
          double a = time(k - 1), b = time(k);
          for (int halving = 0; halving < 60 && b - a > 4e-16 * std::abs(b); ++halving) {
            const double middle = 0.5 * (a + b);
            (off(quantity, step.y_at(middle)) * before_[i] > 0.0 ? a : b) = middle;
          }
          found = b;
        }
        before_[i] = now;
      }
      if (quantity.kind == Kind::energy_drift && (k == 0 || k == places)) {
        const double energy = model_->energies(time(k), y).jacobi;
        if (!begun_ && k == 0) energy_ = energy, found = 0.0;
        found = std::max(found, std::abs(energy - energy_));
      }
      all_found = all_found && !std::isnan(found);
    }
  }
  begun_ = true;
  return !(only_passages_ && all_found);
}

std::vector<double> QuantityWatch::values(const Request& request, const BareResult& run) const {
  std::vector<double> values = found_;
  for (std::size_t i = 0; i < quantities_.size(); ++i) {
    const Quantity& quantity = quantities_[i];
    switch (quantity.kind) {
      case Kind::at_end: values[i] = run.y[quantity.component]; break;
      case Kind::energy: values[i] = model_->energies(run.t, run.y).total(); break;
      case Kind::steps: values[i] = static_cast<double>(run.statistics.steps); break;
      case Kind::time: values[i] = run.t; break;
      case Kind::event:
        for (auto e = run.events.rbegin(); e != run.events.rend(); ++e)
          if (e->name == quantity.event) values[i] = e->t;
        break;
      case Kind::lyapunov: {
        const auto spectrum = exponents_of(model_, request, {.interval = (run.t - request.start.t) / 100.0, .directions = 1});
        if (spectrum.lambda.size() > 0) values[i] = spectrum.lambda[0];
        break;
      }
      case Kind::gali: {
        const auto found = gali_of(model_, request);
        if (found.completed()) values[i] = found.index.back();
        break;
      }
      default: break;
    }
  }
  return values;
}

}  // namespace qdot::program
