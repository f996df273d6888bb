# SPDX-License-Identifier: MIT
#
# Every examples/NN_name.cpp is a program of its own, example_NN_name.
file(GLOB examples CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/examples/*.cpp)
# An example includes what it uses. What many of them include is read once for those that do, the first of these headers that is among their own, and
# once more for those with SUNDIALS, whose flags are others.
#
# QDOT_EXAMPLES_TOGETHER: for the tests, examples are compiled several to a unit, which is one program and runs the example that is its first argument.
# Most of what an example makes the compiler write, others make it write, too: alone they take nearly twice the time. Each is in a namespace of its own, behind
# its own includes; what it sees besides is what those before it in the unit include.
set(read_once qdot/qdot.hpp qdot/integrate/simulate.hpp)
set(units_together)
foreach(source IN LISTS examples)
  get_filename_component(name ${source} NAME_WE)
  set(library qdot::qdot)
  file(STRINGS ${source} names_cvode REGEX "#include [<\"](qdot/integrate/cvode|scenes/)")
  if(names_cvode)
    set(library qdot::cvode)
  endif()
  file(STRINGS ${source} names_optimal REGEX "#include [<\"]qdot/analysis/(optimal|trajectory_optimization)")
  if(names_optimal)
    set(library qdot::optimal)
  endif()
  file(STRINGS ${source} names_mpi REGEX "#include [<\"]qdot/integrate/(ensemble|simulate_many)_mpi")
  if(names_mpi)
    set(library qdot::mpi)
  endif()
  if(NOT TARGET ${library})
    message(STATUS "Example ${name}: no, it needs what ${library} does")
    continue()
  endif()
  if(QDOT_EXAMPLES_TOGETHER AND library MATCHES "qdot$|cvode$")
    set(unit with_${library})
    file(STRINGS ${source} analyses REGEX "#include [<\"]qdot/analysis/")
    if(analyses AND library STREQUAL "qdot::qdot") # eigenvalues and the like, which those need that search
      set(unit of_analysis)
    endif()
    string(MAKE_C_IDENTIFIER ${unit} unit)
    list(APPEND units_together ${unit})
    list(APPEND together_${unit} ${source})
    set(library_of_${unit} ${library})
    continue()
  endif()
  add_executable(example_${name} ${source})
  set_target_properties(example_${name} PROPERTIES OUTPUT_NAME ${name} RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/examples)
  target_include_directories(example_${name} PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(example_${name} PRIVATE ${library})
  qdot_own_target(example_${name})
  foreach(header IN LISTS read_once)
    file(STRINGS ${source} names_header REGEX "#include <${header}>")
    string(MAKE_C_IDENTIFIER "${library}_${header}" key)
    if(names_header AND library MATCHES "qdot$|cvode$")
      if(shares_${key})
        target_precompile_headers(example_${name} REUSE_FROM ${shares_${key}})
      else()
        target_precompile_headers(example_${name} PRIVATE <${header}>)
        set(shares_${key} example_${name})
      endif()
      break()
    endif()
  endforeach()
  # Built as a user builds them: the tests watch the same headers under sanitizers, and this halves the compile time.
  target_compile_options(example_${name} PRIVATE $<$<CONFIG:Check>:-fno-sanitize=all>)
endforeach()

# The example in a function of its name, in which `return 0` is no longer understood.
function(qdot_example_as_function result name source)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${source})
  file(READ ${source} text)
  string(REGEX MATCHALL "#include [^\n]*\n" includes "${text}")
  list(JOIN includes "" includes)
  string(REGEX REPLACE "\nint main\\(" "\nint run(" text "${text}")
  string(REGEX REPLACE "}\n$" "  return 0;\n}\n" text "${text}")
  set(${result} "${includes}namespace example_${name} {\n#line 1 \"${source}\"\n${text}}\n" PARENT_SCOPE)
endfunction()

# The program examples_<unit>, whose first argument is the name of an example.
function(qdot_examples_together unit library)
  set(text)
  set(calls)
  foreach(source IN LISTS ARGN)
    get_filename_component(name ${source} NAME_WE)
    qdot_example_as_function(example ${name} ${source})
    string(APPEND text "${example}")
    set(arguments "")
    if(example MATCHES "\nint run\\(int ")
      set(arguments "count - 1, arguments + 1")
    endif()
    string(APPEND calls "  if (std::strcmp(arguments[1], \"${name}\") == 0) return example_${name}::run(${arguments});\n")
    set_property(GLOBAL PROPERTY qdot_program_of_example_${name} examples_${unit})
  endforeach()
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/examples/${unit}.cpp CONTENT "${text}
#include <cstring>
int main(int count, char** arguments) {
  if (count < 2) return 2;
${calls}  return 2;
}
" @ONLY)
  add_executable(examples_${unit} ${PROJECT_BINARY_DIR}/examples/${unit}.cpp)
  target_include_directories(examples_${unit} PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(examples_${unit} PRIVATE ${library})
  qdot_own_target(examples_${unit})
  target_compile_options(examples_${unit} PRIVATE $<$<CONFIG:Check>:-fno-sanitize=all>)
endfunction()

list(REMOVE_DUPLICATES units_together)
foreach(unit IN LISTS units_together)
  qdot_examples_together(${unit} ${library_of_${unit}} ${together_${unit}})
endforeach()
