// SPDX-License-Identifier: MIT
//
// The functions of FMI that have nothing to answer here: an importer that calls them gets an error.
#include "fmi/answer.hpp"

namespace {

using namespace qdot::fmi;

fmi3Status lacking(fmi3Instance instance, const char* function, const char* what) noexcept {
  return answer(instance, function, [&](Handle&) { forbid(what); });
}

fmi3Status lacking_type(fmi3Instance instance, const char* function, const char* type, std::size_t count) noexcept {
  return answer(instance, function, [&](Handle&) {
    if (count > 0) forbid(std::string("there are no variables of type ") + type + "; see modelDescription.xml");
  });
}

constexpr const char* no_clocks = "there are no clocks";

}  // namespace

extern "C" {

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean, fmi3InstanceEnvironment environment,
                                               fmi3LogMessageCallback log, fmi3ClockUpdateCallback, fmi3LockPreemptionCallback,
                                               fmi3UnlockPreemptionCallback) {
  if (log != nullptr) log(environment, fmi3Error, log_categories[0].name, "Scheduled Execution is not offered; Model Exchange and Co-Simulation are");
  return nullptr;
}
fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance) {
  return lacking(instance, "fmi3EnterConfigurationMode", "there are no structural parameters");
}
fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance) {
  return lacking(instance, "fmi3ExitConfigurationMode", "there are no structural parameters");
}
fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference, size_t*) {
  return lacking(instance, "fmi3GetNumberOfVariableDependencies", "dependencies are not listed; each rate may depend on all states and inputs");
}
fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference, size_t*, fmi3ValueReference*, size_t*, fmi3DependencyKind*, size_t) {
  return lacking(instance, "fmi3GetVariableDependencies", "dependencies are not listed; each rate may depend on all states and inputs");
}
fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance) {
  return lacking(instance, "fmi3EvaluateDiscreteStates", "it is not offered; fmi3UpdateDiscreteStates does all of it");
}
fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference*, size_t, fmi3Float64*, fmi3IntervalQualifier*) {
  return lacking(instance, "fmi3GetIntervalDecimal", no_clocks);
}
fmi3Status fmi3GetIntervalFraction(fmi3Instance instance, const fmi3ValueReference*, size_t, fmi3UInt64*, fmi3UInt64*, fmi3IntervalQualifier*) {
  return lacking(instance, "fmi3GetIntervalFraction", no_clocks);
}
fmi3Status fmi3GetShiftDecimal(fmi3Instance instance, const fmi3ValueReference*, size_t, fmi3Float64*) {
  return lacking(instance, "fmi3GetShiftDecimal", no_clocks);
}
fmi3Status fmi3GetShiftFraction(fmi3Instance instance, const fmi3ValueReference*, size_t, fmi3UInt64*, fmi3UInt64*) {
  return lacking(instance, "fmi3GetShiftFraction", no_clocks);
}
fmi3Status fmi3SetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference*, size_t, const fmi3Float64*) {
  return lacking(instance, "fmi3SetIntervalDecimal", no_clocks);
}
fmi3Status fmi3SetIntervalFraction(fmi3Instance instance, const fmi3ValueReference*, size_t, const fmi3UInt64*, const fmi3UInt64*) {
  return lacking(instance, "fmi3SetIntervalFraction", no_clocks);
}
fmi3Status fmi3SetShiftDecimal(fmi3Instance instance, const fmi3ValueReference*, size_t, const fmi3Float64*) {
  return lacking(instance, "fmi3SetShiftDecimal", no_clocks);
}
fmi3Status fmi3SetShiftFraction(fmi3Instance instance, const fmi3ValueReference*, size_t, const fmi3UInt64*, const fmi3UInt64*) {
  return lacking(instance, "fmi3SetShiftFraction", no_clocks);
}
fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference, fmi3Float64) {
  return lacking(instance, "fmi3ActivateModelPartition", no_clocks);
}

// Types that no variable has.
fmi3Status fmi3GetFloat32(fmi3Instance instance, const fmi3ValueReference*, size_t count, fmi3Float32*, size_t) {
  return lacking_type(instance, "fmi3GetFloat32", "Float32", count);
}
fmi3Status fmi3SetFloat32(fmi3Instance instance, const fmi3ValueReference*, size_t count, const fmi3Float32*, size_t) {
  return lacking_type(instance, "fmi3SetFloat32", "Float32", count);
}
fmi3Status fmi3GetInt8(fmi3Instance instance, const fmi3ValueReference*, size_t count, fmi3Int8*, size_t) {
  return lacking_type(instance, "fmi3GetInt8", "Int8", count);
}
fmi3Status fmi3SetInt8(fmi3Instance instance, const fmi3ValueReference*, size_t count, const fmi3Int8*, size_t) {
  return lacking_type(instance, "fmi3SetInt8", "Int8", count);
}
fmi3Status fmi3GetUInt8(fmi3Instance instance, const fmi3ValueReference*, size_t count, fmi3UInt8*, size_t) {
  return lacking_type(instance, "fmi3GetUInt8", "UInt8", count);
}
fmi3Status fmi3SetUInt8(fmi3Instance instance, const fmi3ValueReference*, size_t count, const fmi3UInt8*, size_t) {
  return lacking_type(instance, "fmi3SetUInt8", "UInt8", count);
}
fmi3Status fmi3GetInt16(fmi3Instance instance, const fmi3ValueReference*, size_t count, fmi3Int16*, size_t) {
  return lacking_type(instance, "fmi3GetInt16", "Int16", count);
}
fmi3Status fmi3SetInt16(fmi3Instance instance, const fmi3ValueReference*, size_t count, const fmi3Int16*, size_t) {
  return lacking_type(instance, "fmi3SetInt16", "Int16", count);
}
fmi3Status fmi3GetUInt16(fmi3Instance instance, const fmi3ValueReference*, size_t count, fmi3UInt16*, size_t) {
  return lacking_type(instance, "fmi3GetUInt16", "UInt16", count);
}
fmi3Status fmi3SetUInt16(fmi3Instance instance, const fmi3ValueReference*, size_t count, const fmi3UInt16*, size_t) {
  return lacking_type(instance, "fmi3SetUInt16", "UInt16", count);
}
fmi3Status fmi3GetUInt32(fmi3Instance instance, const fmi3ValueReference*, size_t count, fmi3UInt32*, size_t) {
  return lacking_type(instance, "fmi3GetUInt32", "UInt32", count);
}
fmi3Status fmi3SetUInt32(fmi3Instance instance, const fmi3ValueReference*, size_t count, const fmi3UInt32*, size_t) {
  return lacking_type(instance, "fmi3SetUInt32", "UInt32", count);
}
fmi3Status fmi3GetInt64(fmi3Instance instance, const fmi3ValueReference*, size_t count, fmi3Int64*, size_t) {
  return lacking_type(instance, "fmi3GetInt64", "Int64", count);
}
fmi3Status fmi3SetInt64(fmi3Instance instance, const fmi3ValueReference*, size_t count, const fmi3Int64*, size_t) {
  return lacking_type(instance, "fmi3SetInt64", "Int64", count);
}
fmi3Status fmi3GetUInt64(fmi3Instance instance, const fmi3ValueReference*, size_t count, fmi3UInt64*, size_t) {
  return lacking_type(instance, "fmi3GetUInt64", "UInt64", count);
}
fmi3Status fmi3SetUInt64(fmi3Instance instance, const fmi3ValueReference*, size_t count, const fmi3UInt64*, size_t) {
  return lacking_type(instance, "fmi3SetUInt64", "UInt64", count);
}
fmi3Status fmi3GetString(fmi3Instance instance, const fmi3ValueReference*, size_t count, fmi3String*, size_t) {
  return lacking_type(instance, "fmi3GetString", "String", count);
}
fmi3Status fmi3SetString(fmi3Instance instance, const fmi3ValueReference*, size_t count, const fmi3String*, size_t) {
  return lacking_type(instance, "fmi3SetString", "String", count);
}
fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference*, size_t count, size_t*, fmi3Binary*, size_t) {
  return lacking_type(instance, "fmi3GetBinary", "Binary", count);
}
fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference*, size_t count, const size_t*, const fmi3Binary*, size_t) {
  return lacking_type(instance, "fmi3SetBinary", "Binary", count);
}
fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference*, size_t count, fmi3Clock*) {
  return lacking_type(instance, "fmi3GetClock", "Clock", count);
}
fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference*, size_t count, const fmi3Clock*) {
  return lacking_type(instance, "fmi3SetClock", "Clock", count);
}

}  // extern "C"
