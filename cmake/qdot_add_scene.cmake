# SPDX-License-Identifier: MIT
#
# qdot_add_scene(NAME FILE): an executable NAME of the scene in FILE (scenes/own_scene.hpp), with the command line of qdot:
#
#     qdot_add_scene(swing swing.cpp)            swing run --set l=2 --out out/swing, swing accuracy, swing equations, …
#
# Needs qdot::cvode, CLI11 and nlohmann json. The commands are compiled once for all scenes of a project, and only where there is one.
# Used in qdot's own build and, installed, by find_package(qdot). Who includes this sets the global properties qdot_program_folder and
# qdot_version.
function(qdot_add_scene name file)
  get_property(folder GLOBAL PROPERTY qdot_program_folder)
  if(NOT TARGET qdot_program_parts)
    add_subdirectory(${folder}/program ${CMAKE_BINARY_DIR}/qdot_program EXCLUDE_FROM_ALL)
  endif()
  if(NOT TARGET qdot_program_parts)
    get_property(missing GLOBAL PROPERTY qdot_program_missing)
    message(FATAL_ERROR "qdot_add_scene(${name} ${file}) makes a program, which needs what was not found: ${missing}")
  endif()
  add_executable(${name} ${file} ${folder}/own/main.cpp)
  if(NOT qdot_IS_TOP_LEVEL AND CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
    set_property(SOURCE ${folder}/own/main.cpp PROPERTY COMPILE_OPTIONS -w)
  endif()
  target_compile_definitions(${name} PRIVATE QDOT_SCENE_NAME="${name}")
  target_link_libraries(${name} PRIVATE qdot_program_parts)
endfunction()
