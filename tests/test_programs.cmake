# SPDX-License-Identifier: MIT
#
# Every folder of *.test.cpp is one test program, test_<folder>; every TEST_CASE in it one entry of ctest.

# A range 2...3 is refused by both versions.
find_package(Catch2 3 QUIET CONFIG)
if(NOT Catch2_FOUND)
  find_package(Catch2 2 QUIET CONFIG)
endif()
if(NOT Catch2_FOUND)
  message(STATUS "Tests: no, Catch2 (catch2) not found")
  return()
endif()
list(APPEND CMAKE_MODULE_PATH ${Catch2_DIR})
include(Catch)

# One main and one set of precompiled headers for all test programs: Catch2 and Eigen are half of a test's compile time.
set(library qdot::qdot)
if(TARGET qdot::cvode)
  set(library qdot::cvode)
endif()
add_library(qdot_test_main STATIC catch2_main.cpp)
target_include_directories(qdot_test_main PUBLIC ${CMAKE_CURRENT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/src)
target_link_libraries(qdot_test_main PUBLIC ${library})
if(Catch2_VERSION VERSION_GREATER_EQUAL 3)
  target_link_libraries(qdot_test_main PUBLIC Catch2::Catch2WithMain)
else()
  target_link_libraries(qdot_test_main PUBLIC Catch2::Catch2)
endif()
if(TARGET qdot::optimal) # all see its headers, for they share precompiled ones; who uses them links it
  target_compile_definitions(qdot_test_main PUBLIC $<TARGET_PROPERTY:qdot::_ipopt,INTERFACE_COMPILE_DEFINITIONS>)
  target_include_directories(qdot_test_main SYSTEM PUBLIC $<TARGET_PROPERTY:qdot::_ipopt,INTERFACE_INCLUDE_DIRECTORIES>)
endif()
qdot_own_target(qdot_test_main)
set_source_files_properties(catch2_main.cpp PROPERTIES COMPILE_OPTIONS "-w;-O0;-fno-sanitize=all") # Catch2's code, not ours

add_library(qdot_test_headers OBJECT precompiled.cpp)
target_link_libraries(qdot_test_headers PRIVATE qdot_test_main)
target_precompile_headers(qdot_test_headers PRIVATE catch2_bridge.hpp <Eigen/Dense>)
qdot_own_target(qdot_test_headers)

file(GLOB_RECURSE sources CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} *.test.cpp)
# Quadruple precision is GCC's.
include(CheckCXXSourceCompiles)
set(CMAKE_REQUIRED_LIBRARIES quadmath)
check_cxx_source_compiles("extern \"C\" __float128 sinq(__float128); int main() { return static_cast<int>(sinq(0)); }" QDOT_HAS_QUADMATH)
unset(CMAKE_REQUIRED_LIBRARIES)
# Without SUNDIALS, what names qdot/integrate/cvode… is left out, and so are the folders whose own headers do; without Ipopt what names qdot/analysis/optimal…, without MPI the folder mpi.
set(left_out)
foreach(source IN LISTS sources)
  file(STRINGS ${source} names_cvode REGEX "#include [<\"]qdot/integrate/cvode")
  file(STRINGS ${source} names_optimal REGEX "#include [<\"]qdot/analysis/optimal")
  if(NOT TARGET qdot::optimal AND names_optimal
      OR NOT TARGET qdot::cvode AND (names_cvode OR source MATCHES "^systems_motion/|\\.cvode\\.test\\.cpp$")
      OR NOT (TARGET qdot::mpi AND MPIEXEC_EXECUTABLE) AND source MATCHES "^mpi/" OR NOT program_to_test AND source MATCHES "^program/" OR NOT QDOT_HAS_QUADMATH AND source MATCHES "^fuzz/(dual_math|hunt)")
    list(APPEND left_out ${source})
  endif()
endforeach()
if(left_out)
  list(REMOVE_ITEM sources ${left_out})
  list(LENGTH left_out count)
  message(STATUS "Tests: ${count} files left out, they need SUNDIALS, Ipopt, MPI, libquadmath or the program")
endif()

set(folders)
foreach(source IN LISTS sources)
  get_filename_component(folder ${source} DIRECTORY)
  string(REPLACE "/" "_" folder "${folder}")
  list(APPEND folders "${folder}")
  list(APPEND sources_of_${folder} ${source})
endforeach()
list(REMOVE_DUPLICATES folders)

include(units.cmake)
# Sanitizers stand where memory is handled: scalars and graphs, effects, integrators, events, failed runs. What is built on those, and on
# Eigen with its assertions on, does without the third of the compile time and the half of the run time that they take, unless
# QDOT_SANITIZE_ALL asks for them.
set(qdot_not_sanitized "^(mechanics|analysis|report|program|systems_motion|hard)$")
if(QDOT_SANITIZE_ALL)
  set(qdot_not_sanitized "^$")
endif()
set(shares_plain_headers)
foreach(folder IN LISTS folders)
  set(units ${sources_of_${folder}})
  set(most 80000)
  if(CMAKE_CXX_COMPILER_ID MATCHES "Clang") # which takes half of the memory that g++ takes
    set(most 180000)
    if(folder MATCHES "${qdot_not_sanitized}")
      set(most 250000)
    endif()
  endif()
  if(NOT folder MATCHES "^(optimized|fuzz)$") # what the optimizer makes of a file depends on no other; headers of many names
    qdot_test_units(units ${most} ${sources_of_${folder}})
  endif()
  add_executable(test_${folder} ${units})
  target_link_libraries(test_${folder} PRIVATE qdot_test_main)
  if(folder STREQUAL "analysis" AND TARGET qdot::optimal)
    target_link_libraries(test_${folder} PRIVATE qdot::optimal)
  endif()
  if(folder STREQUAL "optimized") # what exists only with the optimizer on and no sanitizer
    target_compile_options(test_${folder} PRIVATE $<$<CONFIG:Check>:-O2;-fno-sanitize=all>)
    target_link_options(test_${folder} PRIVATE $<$<CONFIG:Check>:-fno-sanitize=all>)
    target_precompile_headers(test_${folder} PRIVATE catch2_bridge.hpp <Eigen/Dense>) # of its own: other flags
    set_property(SOURCE optimized/moving_positions.test.cpp optimized/sensitivity_of_random_scenes.test.cpp optimized/many_scenes_in_lanes.test.cpp PROPERTY COMPILE_OPTIONS "$<$<CONFIG:Check>:-O1>") # half the compile time
  elseif(folder STREQUAL "ways") # the same ways as formulas: no optimizer, but code that takes it to be on
    # clang++ then leaves out even what it must inline, a quarter of the compile time, and each number that is zero counts as one that is known to
    # be. Whether an optimizer finds those zeros is the question of folder optimized. g++ inlines in any case.
    target_sources(test_${folder} PRIVATE ways/allocator.cpp)
    set(flags -O1)
    if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
      set(flags -O0 -D__OPTIMIZE__ "-D__builtin_constant_p(...)=(sizeof((__VA_ARGS__))!=0)" -Xclang=-disable-llvm-passes)
    endif()
    target_compile_options(test_${folder} PRIVATE "$<$<CONFIG:Check>:${flags};-fno-sanitize=all>")
    target_link_options(test_${folder} PRIVATE $<$<CONFIG:Check>:-fno-sanitize=all>)
    target_precompile_headers(test_${folder} PRIVATE catch2_bridge.hpp <Eigen/Dense>)
  elseif(folder STREQUAL "threads") # under the thread sanitizer, which goes with no other
    target_compile_options(test_${folder} PRIVATE $<$<CONFIG:Check>:-fno-sanitize=all;-fsanitize=thread>)
    target_link_options(test_${folder} PRIVATE $<$<CONFIG:Check>:-fno-sanitize=all;-fsanitize=thread>)
  elseif(folder STREQUAL "mpi") # with the optimizer on, by which there are lanes
    target_link_libraries(test_${folder} PRIVATE qdot::mpi)
    target_compile_options(test_${folder} PRIVATE $<$<CONFIG:Check>:-O1>)
  elseif(folder MATCHES "${qdot_not_sanitized}")
    target_compile_options(test_${folder} PRIVATE $<$<CONFIG:Check>:-fno-sanitize=all>)
    target_link_options(test_${folder} PRIVATE $<$<CONFIG:Check>:-fno-sanitize=all>)
    if(shares_plain_headers)
      target_precompile_headers(test_${folder} REUSE_FROM ${shares_plain_headers})
    else()
      target_precompile_headers(test_${folder} PRIVATE catch2_bridge.hpp <Eigen/Dense>)
      set(shares_plain_headers test_${folder})
    endif()
  else()
    target_precompile_headers(test_${folder} REUSE_FROM qdot_test_headers)
  endif()
  if(folder STREQUAL "fuzz" AND QDOT_HAS_QUADMATH)
    target_link_libraries(test_fuzz PRIVATE quadmath)
  endif()
  qdot_own_target(test_${folder})
  set(definitions QDOT_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  if(folder STREQUAL "program")
    list(APPEND definitions QDOT_PROGRAM="${program_to_test}")
    if(NOT QDOT_PROGRAM)
      list(APPEND definitions $<$<CONFIG:Check>:QDOT_PROGRAM_IS_SANITIZED>)
    endif()
    if(TARGET qdot_program)
      add_dependencies(test_${folder} qdot_program)
    endif()
  endif()
  set_source_files_properties(${units} PROPERTIES COMPILE_DEFINITIONS "${definitions}")
  if(folder STREQUAL "mpi") # all of its tests at once, on several ranks
    foreach(ranks IN ITEMS 1 2 4)
      add_test(NAME mpi.on_${ranks}_ranks COMMAND ${MPIEXEC_EXECUTABLE} ${MPIEXEC_NUMPROC_FLAG} ${ranks} $<TARGET_FILE:test_mpi>)
      set_tests_properties(mpi.on_${ranks}_ranks PROPERTIES PROCESSORS 2
        ENVIRONMENT "${qdot_mpirun_environment}")
    endforeach()
    continue()
  endif()
  # A program that cannot list its tests, because two have one name, would have none without anybody noticing.
  add_test(NAME list_of_tests.${folder} COMMAND test_${folder} --list-tests)
  set_tests_properties(list_of_tests.${folder} PROPERTIES PASS_REGULAR_EXPRESSION "[1-9][0-9]* (matching )?test case")
  # Tests tagged [long] bear the label long, which ./check leaves out unless asked for.
  catch_discover_tests(test_${folder} TEST_PREFIX "${folder}: " TEST_SPEC "~[long]~[.]")
  foreach(source IN LISTS sources_of_${folder})
    file(STRINGS ${source} long REGEX "\\[long\\]")
    if(long)
      catch_discover_tests(test_${folder} TEST_PREFIX "${folder}: " TEST_SPEC "[long]" PROPERTIES LABELS long TIMEOUT 1800)
      break()
    endif()
  endforeach()
endforeach()
