#pragma once
// SPDX-License-Identifier: MIT
//
// What FMI 3.0 calls things: the types, numbers and functions of its C interface, for code that implements it (fmi3.cpp) or loads
// it.
//
// The Functional Mock-up Interface (fmi-standard.org) is how simulators exchange models. An importer loads a shared library, looks these functions up by
// their names, and drives instances through modes:
//
//     instantiated → initialization →  event ⇄ continuous time        Model Exchange: the importer integrates
//                                      step ⇄ event                   Co-Simulation: the library does, from one point of time to the next
//
// Names and signatures are the standard's and may not be chosen; so they do not follow the style of the rest.

#include <cstddef>
#include <cstdint>

using fmi3Instance = void*;
using fmi3InstanceEnvironment = void*;
using fmi3FMUState = void*;
using fmi3ValueReference = std::uint32_t;

using fmi3Float32 = float;
using fmi3Float64 = double;
using fmi3Int8 = std::int8_t;
using fmi3UInt8 = std::uint8_t;
using fmi3Int16 = std::int16_t;
using fmi3UInt16 = std::uint16_t;
using fmi3Int32 = std::int32_t;
using fmi3UInt32 = std::uint32_t;
using fmi3Int64 = std::int64_t;
using fmi3UInt64 = std::uint64_t;
using fmi3Boolean = bool;
using fmi3Char = char;
using fmi3String = const fmi3Char*;
using fmi3Byte = std::uint8_t;
using fmi3Binary = const fmi3Byte*;
using fmi3Clock = bool;

/// What came of a call, from good to bad. After a discard nothing is changed and one may go on; after an error only Reset and SetFMUState lead on.
enum fmi3Status { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal };

enum fmi3DependencyKind { fmi3Independent, fmi3Constant, fmi3Fixed, fmi3Tunable, fmi3Discrete, fmi3Dependent };
enum fmi3IntervalQualifier { fmi3IntervalNotYetKnown, fmi3IntervalUnchanged, fmi3IntervalChanged };

// The library is built with its names hidden; these are what it shows.
#pragma GCC visibility push(default)
extern "C" {

// --- What the importer may be called back by -------------------------------------------------------------------------

using fmi3LogMessageCallback = void (*)(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message);
using fmi3ClockUpdateCallback = void (*)(fmi3InstanceEnvironment environment);
using fmi3IntermediateUpdateCallback = void (*)(fmi3InstanceEnvironment environment, fmi3Float64 time, fmi3Boolean set_requested, fmi3Boolean get_allowed,
                                                fmi3Boolean step_finished, fmi3Boolean can_return_early, fmi3Boolean* return_requested,
                                                fmi3Float64* return_time);
using fmi3LockPreemptionCallback = void (*)();
using fmi3UnlockPreemptionCallback = void (*)();

// --- Instances and their modes ---------------------------------------------------------------------------------------

const char* fmi3GetVersion();
fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t category_count, const fmi3String categories[]);

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resource_path, fmi3Boolean visible, fmi3Boolean logging_on,
                                          fmi3InstanceEnvironment environment, fmi3LogMessageCallback log);
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resource_path, fmi3Boolean visible, fmi3Boolean logging_on,
                                         fmi3Boolean event_mode_used, fmi3Boolean early_return_allowed, const fmi3ValueReference intermediate[],
                                         size_t intermediate_count, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update);
fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resource_path, fmi3Boolean visible, fmi3Boolean logging_on,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3ClockUpdateCallback update,
                                               fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock);
void fmi3FreeInstance(fmi3Instance instance);

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean tolerance_defined, fmi3Float64 tolerance, fmi3Float64 start_time,
                                       fmi3Boolean stop_time_defined, fmi3Float64 stop_time);
fmi3Status fmi3ExitInitializationMode(fmi3Instance instance);
fmi3Status fmi3EnterEventMode(fmi3Instance instance);
fmi3Status fmi3Terminate(fmi3Instance instance);
fmi3Status fmi3Reset(fmi3Instance instance);
fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance);
fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance);

// --- Values of variables ---------------------------------------------------------------------------------------------

fmi3Status fmi3GetFloat32(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Float32 values[], size_t value_count);
fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Float64 values[], size_t value_count);
fmi3Status fmi3GetInt8(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Int8 values[], size_t value_count);
fmi3Status fmi3GetUInt8(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3UInt8 values[], size_t value_count);
fmi3Status fmi3GetInt16(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Int16 values[], size_t value_count);
fmi3Status fmi3GetUInt16(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3UInt16 values[], size_t value_count);
fmi3Status fmi3GetInt32(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Int32 values[], size_t value_count);
fmi3Status fmi3GetUInt32(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3UInt32 values[], size_t value_count);
fmi3Status fmi3GetInt64(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Int64 values[], size_t value_count);
fmi3Status fmi3GetUInt64(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3UInt64 values[], size_t value_count);
fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Boolean values[], size_t value_count);
fmi3Status fmi3GetString(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3String values[], size_t value_count);
fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference references[], size_t count, size_t sizes[], fmi3Binary values[],
                         size_t value_count);
fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Clock values[]);

fmi3Status fmi3SetFloat32(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Float32 values[], size_t value_count);
fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Float64 values[], size_t value_count);
fmi3Status fmi3SetInt8(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Int8 values[], size_t value_count);
fmi3Status fmi3SetUInt8(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3UInt8 values[], size_t value_count);
fmi3Status fmi3SetInt16(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Int16 values[], size_t value_count);
fmi3Status fmi3SetUInt16(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3UInt16 values[], size_t value_count);
fmi3Status fmi3SetInt32(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Int32 values[], size_t value_count);
fmi3Status fmi3SetUInt32(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3UInt32 values[], size_t value_count);
fmi3Status fmi3SetInt64(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Int64 values[], size_t value_count);
fmi3Status fmi3SetUInt64(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3UInt64 values[], size_t value_count);
fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Boolean values[], size_t value_count);
fmi3Status fmi3SetString(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3String values[], size_t value_count);
fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const size_t sizes[], const fmi3Binary values[],
                         size_t value_count);
fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Clock values[]);

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference reference, size_t* count);
fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference dependent, size_t elements[], fmi3ValueReference independents[],
                                       size_t independent_elements[], fmi3DependencyKind kinds[], size_t count);

// --- The whole state, and derivatives --------------------------------------------------------------------------------

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState* state);
fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state);
fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState* state);
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t* size);
fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size);
fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState* state);

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t unknown_count,
                                        const fmi3ValueReference knowns[], size_t known_count, const fmi3Float64 seed[], size_t seed_count,
                                        fmi3Float64 sensitivity[], size_t sensitivity_count);
fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t unknown_count, const fmi3ValueReference knowns[],
                                    size_t known_count, const fmi3Float64 seed[], size_t seed_count, fmi3Float64 sensitivity[], size_t sensitivity_count);

// --- Events, and clocks, of which qdot has none ----------------------------------------------------------------------

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance);
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean* need_update, fmi3Boolean* terminate, fmi3Boolean* nominals_changed,
                                    fmi3Boolean* values_changed, fmi3Boolean* next_time_defined, fmi3Float64* next_time);

fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Float64 intervals[],
                                  fmi3IntervalQualifier qualifiers[]);
fmi3Status fmi3GetIntervalFraction(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3UInt64 counters[],
                                   fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[]);
fmi3Status fmi3GetShiftDecimal(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Float64 shifts[]);
fmi3Status fmi3GetShiftFraction(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3UInt64 counters[],
                                fmi3UInt64 resolutions[]);
fmi3Status fmi3SetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Float64 intervals[]);
fmi3Status fmi3SetIntervalFraction(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3UInt64 counters[],
                                   const fmi3UInt64 resolutions[]);
fmi3Status fmi3SetShiftDecimal(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Float64 shifts[]);
fmi3Status fmi3SetShiftFraction(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3UInt64 counters[],
                                const fmi3UInt64 resolutions[]);
fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clock, fmi3Float64 time);

// --- Model Exchange --------------------------------------------------------------------------------------------------

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance);
fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean no_set_state_before, fmi3Boolean* enter_event_mode, fmi3Boolean* terminate);
fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time);
fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 states[], size_t count);
fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 states[], size_t count);
fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[], size_t count);
fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 indicators[], size_t count);
fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t count);
fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t* count);
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t* count);

// --- Co-Simulation ---------------------------------------------------------------------------------------------------

fmi3Status fmi3EnterStepMode(fmi3Instance instance);
fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Int32 orders[],
                                    fmi3Float64 values[], size_t value_count);
fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 from, fmi3Float64 length, fmi3Boolean no_set_state_before, fmi3Boolean* event_handling_needed,
                      fmi3Boolean* terminate, fmi3Boolean* early_return, fmi3Float64* last_successful_time);

}  // extern "C"
#pragma GCC visibility pop
