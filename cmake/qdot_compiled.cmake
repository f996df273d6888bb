# SPDX-License-Identifier: MIT
#
# qdot_add_compiled(): the targets qdot::compiled and qdot::compiled_analysis, for shorter waits at the compiler:
#
#     target_link_libraries(simulator PRIVATE qdot::compiled)      instead of qdot::cvode, or of qdot::qdot where there is no SUNDIALS
#
# What of qdot depends on no user's type is compiled once then, and not again with each source that includes qdot. It is compiled in the project that asks
# for it, with its compiler and options (an archive made elsewhere would have other ideas of how vectors are aligned), and only where a target links it.
# qdot::compiled_analysis, which brings qdot::compiled along, does the same for qdot/analysis, in a minute or two (docs/lab/speed.md).
# Used in qdot's own build and, installed, by find_package(qdot). Who includes this sets the global property qdot_program_folder.
function(qdot_add_compiled)
  if(TARGET qdot_compiled)
    return()
  endif()
  get_property(folder GLOBAL PROPERTY qdot_program_folder)
  # Runs of systems whose number of coordinates is known when compiling (runs_…) need the rest; ./run links the rest alone at first.
  add_library(qdot_compiled_equations OBJECT EXCLUDE_FROM_ALL ${folder}/compiled/equations.cpp ${folder}/compiled/effects.cpp)
  add_library(qdot_compiled STATIC EXCLUDE_FROM_ALL ${folder}/compiled/runs_1_to_4.cpp ${folder}/compiled/runs_5_to_8.cpp
    $<TARGET_OBJECTS:qdot_compiled_equations>)
  set(library qdot::qdot)
  if(TARGET qdot::cvode)
    target_sources(qdot_compiled_equations PRIVATE ${folder}/compiled/cvode.cpp)
    set(library qdot::cvode)
  endif()
  foreach(part qdot_compiled_equations qdot_compiled)
    target_link_libraries(${part} PUBLIC ${library})
    set_target_properties(${part} PROPERTIES POSITION_INDEPENDENT_CODE ON) # shared libraries may have it, too
    qdot_keep_warnings_out(${part})
  endforeach()
  target_compile_definitions(qdot_compiled INTERFACE QDOT_COMPILED)
  add_library(qdot::compiled ALIAS qdot_compiled)
  add_library(qdot_compiled_analysis STATIC EXCLUDE_FROM_ALL ${folder}/compiled/analysis.cpp)
  target_link_libraries(qdot_compiled_analysis PUBLIC qdot_compiled)
  target_compile_definitions(qdot_compiled_analysis INTERFACE QDOT_COMPILED_ANALYSIS)
  qdot_keep_warnings_out(qdot_compiled_analysis)
  add_library(qdot::compiled_analysis ALIAS qdot_compiled_analysis)
endfunction()

# In another project: its warnings are for its own sources, and not for those of qdot that are compiled there.
function(qdot_keep_warnings_out target)
  if(NOT qdot_IS_TOP_LEVEL AND CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
    target_compile_options(${target} PRIVATE -w)
  endif()
endfunction()
