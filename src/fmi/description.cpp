// SPDX-License-Identifier: MIT
#include "fmi/description.hpp"

#include <cmath>
#include <cstdio>
#include <set>

#include "fmi/instance.hpp"
#include "qdot/integrate/simulator_state.hpp"
#include "qdot/report/number.hpp"

namespace qdot::fmi {

namespace {

using report::exact_text;

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else if (static_cast<unsigned char>(c) < 0x20)
      out += ' ';  // XML has no words for most of these
    else
      out += c;
  }
  return out;
}

std::string attribute(const char* name, const std::string& value) { return std::string(" ") + name + "=\"" + escaped(value) + "\""; }
std::string given(const char* name, const std::string& value) { return value.empty() ? std::string() : attribute(name, value); }

// How the standard tells roles apart.
struct Kind {
  const char *causality, *variability, *initial;
};

Kind kind_of(const Variable& v) {
  switch (v.role) {
    case Role::time:
      return {"independent", "continuous", ""};
    case Role::parameter:
    case Role::effect_value:
    case Role::effect_on:
      return {"parameter", "fixed", "exact"};
    case Role::count:
      return {"local", "constant", "exact"};
    case Role::input:
      return {"input", "continuous", ""};
    case Role::state:
      return {"output", "continuous", v.follows_others ? "approx" : "exact"};
    case Role::phase:
      return {"local", "discrete", "calculated"};
    default:
      return {"local", "continuous", "calculated"};
  }
}

std::string element_of(const Variables& variables, std::size_t reference) {
  const Variable& v = variables.all[reference];
  const Kind kind = kind_of(v);
  const bool starts = v.role != Role::time && std::string(kind.initial) != "calculated";
  const char* type = v.type() == Type::boolean ? "Boolean" : v.type() == Type::int32 ? "Int32" : "Float64";
  std::string text = std::string("    <") + type + attribute("name", v.name) + attribute("valueReference", std::to_string(reference)) +
                     given("description", v.description) + attribute("causality", kind.causality) + attribute("variability", kind.variability) +
                     given("initial", kind.initial);
  if (v.type() == Type::float64) {
    text += given("unit", v.unit);
    if (std::isfinite(v.range.least)) text += attribute("min", exact_text(v.range.least));
    if (std::isfinite(v.range.most)) text += attribute("max", exact_text(v.range.most));
    if (v.role == Role::rate) text += attribute("derivative", std::to_string(v.state_reference));
    if (v.role == Role::state && (variables.constrained || !variables.guards.empty())) text += attribute("reinit", "true");
  }
  if (starts) text += attribute("start", v.type() == Type::boolean ? (v.start != 0 ? "true" : "false") : exact_text(v.start));
  return text + "/>\n";
}

std::string units(const Variables& variables) {
  std::set<std::string> names;
  for (const Variable& v : variables.all)
    if (!v.unit.empty()) names.insert(v.unit);
  if (names.empty()) return {};
  std::string text = "  <UnitDefinitions>\n";
  for (const std::string& name : names) text += "    <Unit" + attribute("name", name) + "/>\n";
  return text + "  </UnitDefinitions>\n";
}

std::string structure(const Variables& variables) {
  const auto element = [](const char* name, std::size_t reference) {
    return std::string("    <") + name + attribute("valueReference", std::to_string(reference)) + "/>\n";
  };
  std::string text = "  <ModelStructure>\n";
  for (const std::size_t x : variables.states) text += element("Output", x);
  for (const std::size_t x : variables.rates) text += element("ContinuousStateDerivative", x);
  for (const std::size_t x : variables.states)
    if (variables.all[x].follows_others) text += element("InitialUnknown", x);
  for (const std::size_t x : variables.rates) text += element("InitialUnknown", x);
  for (const std::size_t x : variables.guards) text += element("EventIndicator", x);
  return text + "  </ModelStructure>\n";
}

std::string document(const Choice& choice, const Variables& variables, const std::string& token) {
  const std::string can = attribute("modelIdentifier", choice.identifier) + attribute("canGetAndSetFMUState", "true") +
                          attribute("canSerializeFMUState", "true") + attribute("providesDirectionalDerivatives", "true") +
                          attribute("providesAdjointDerivatives", "true");
  std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription" + attribute("fmiVersion", "3.0") +
                     attribute("modelName", variables.title) + attribute("instantiationToken", token) + given("description", variables.summary) +
                     attribute("generationTool", "qdot " + choice.version) + attribute("variableNamingConvention", "flat") + ">\n";
  text += "  <ModelExchange" + can + attribute("needsCompletedIntegratorStep", variables.constrained ? "true" : "false") + "/>\n";
  text += "  <CoSimulation" + can + attribute("canHandleVariableCommunicationStepSize", "true") + attribute("maxOutputDerivativeOrder", "1") +
          attribute("mightReturnEarlyFromDoStep", "true") + attribute("hasEventMode", "true") + "/>\n";
  text += units(variables) + "  <LogCategories>\n";
  for (const LogCategory& category : log_categories)
    text += std::string("    <Category") + attribute("name", category.name) + attribute("description", category.description) + "/>\n";
  text += "  </LogCategories>\n";
  text += "  <DefaultExperiment" + attribute("startTime", exact_text(variables.start_time)) + attribute("stopTime", exact_text(variables.end_time)) +
          attribute("tolerance", exact_text(default_tolerance)) + "/>\n";
  text += "  <ModelVariables>\n";
  for (std::size_t i = 0; i < variables.all.size(); ++i) text += element_of(variables, i);
  return text + "  </ModelVariables>\n" + structure(variables) + "</fmiModelDescription>\n";
}

}  // namespace

Description description_of(const Choice& choice, const Variables& variables) {
  const std::string rest = document(choice, variables, "");
  char token[40];
  std::snprintf(token, sizeof token, "{qdot-%016llx}",
                static_cast<unsigned long long>(qdot::detail::checksum(qdot::detail::empty_checksum, rest.data(), rest.size())));
  return {token, document(choice, variables, token)};
}

std::string model_description() { return description_of(choice(), variables_of(choice())).xml; }

}  // namespace qdot::fmi
