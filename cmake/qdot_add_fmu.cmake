# SPDX-License-Identifier: MIT
#
# qdot_add_fmu(NAME FILE [SET NAME=NUMBER…] [WITH EFFECT[=NUMBER]…]): the scene in FILE (scenes/own_scene.hpp) as NAME.fmu in the current binary
# directory, for whatever imports FMI 3.0 (docs/how-to/fmu.md).
#
#     qdot_add_fmu(swing swing.cpp)
#     qdot_add_fmu(long_chain chain.cpp SET n=20 WITH motor)
#
# Targets: NAME_fmu makes the file, and is a part of `all`; NAME_fmu_library, NAME_fmu_describe and NAME_fmu_scene are what it is made of.
# Needs qdot::qdot alone. What is the same for all scenes is compiled once. Who includes this sets the global properties qdot_program_folder and
# qdot_version.
function(qdot_add_fmu name file)
  cmake_parse_arguments(PARSE_ARGV 2 arg "" "" "SET;WITH")
  if(arg_UNPARSED_ARGUMENTS OR arg_KEYWORDS_MISSING_VALUES)
    message(FATAL_ERROR "qdot_add_fmu(${name} ${file} …) takes SET NAME=NUMBER… and WITH EFFECT[=NUMBER]…, given ${ARGN}")
  endif()
  if(NOT name MATCHES "^[A-Za-z_][A-Za-z0-9_]*$")
    message(FATAL_ERROR "qdot_add_fmu: the name of an FMU must be one of C, letters, digits and _, given ${name}")
  endif()
  string(TOLOWER "${CMAKE_SYSTEM_PROCESSOR}" processor)
  string(REPLACE "amd64" "x86_64" processor "${processor}")
  string(REPLACE "arm64" "aarch64" processor "${processor}")
  string(REGEX REPLACE "^i[3-6]86$" "x86" processor "${processor}")
  if(CMAKE_SYSTEM_NAME STREQUAL "Linux")
    set(platform ${processor}-linux)
    set(suffix .so)
  elseif(CMAKE_SYSTEM_NAME STREQUAL "Darwin")
    set(platform ${processor}-darwin)
    set(suffix .dylib)
  else()
    message(FATAL_ERROR "qdot_add_fmu(${name} ${file}) makes libraries for Linux and macOS, not for ${CMAKE_SYSTEM_NAME}")
  endif()
  get_property(folder GLOBAL PROPERTY qdot_program_folder)
  get_property(version GLOBAL PROPERTY qdot_version)

  # Hidden names and position-independent code: an importer loads many such libraries at the same time.
  if(NOT TARGET qdot_fmi_parts)
    add_library(qdot_fmi_parts OBJECT EXCLUDE_FROM_ALL
      ${folder}/fmi/answer.cpp ${folder}/fmi/description.cpp ${folder}/fmi/fmi3.cpp ${folder}/fmi/instance.cpp ${folder}/fmi/lacking.cpp ${folder}/fmi/variables.cpp)
    qdot_fmu_target(qdot_fmi_parts ${folder})
    qdot_keep_warnings_out(qdot_fmi_parts)
    set_target_properties(qdot_fmi_parts PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
  endif()
  set(set)
  set(with)
  foreach(text IN LISTS arg_SET)
    string(APPEND set "R\"(${text})\", ")
  endforeach()
  foreach(text IN LISTS arg_WITH)
    string(APPEND with "R\"(${text})\", ")
  endforeach()
  set(directory ${CMAKE_CURRENT_BINARY_DIR}/${name}_fmu)
  file(CONFIGURE OUTPUT ${directory}/choice.cpp CONTENT "#include \"fmi/choice.hpp\"

const qdot::fmi::Choice& qdot::fmi::choice() {
  static const Choice one{\"@name@\", \"@version@\", {@set@}, {@with@}};
  return one;
}
" @ONLY)
  add_library(${name}_fmu_scene OBJECT ${file} ${directory}/choice.cpp)
  qdot_fmu_target(${name}_fmu_scene ${folder})

  add_library(${name}_fmu_library MODULE $<TARGET_OBJECTS:${name}_fmu_scene> $<TARGET_OBJECTS:qdot_fmi_parts>)
  set_target_properties(${name}_fmu_library PROPERTIES PREFIX "" OUTPUT_NAME ${name} SUFFIX ${suffix} LINKER_LANGUAGE CXX
    LIBRARY_OUTPUT_DIRECTORY "$<1:${directory}/fmu/binaries/${platform}>") # without a folder for each configuration
  if(CMAKE_SYSTEM_NAME STREQUAL "Linux") # nothing else to be seen, not even what the standard library instantiates
    file(CONFIGURE OUTPUT ${directory}/shown.map CONTENT "{ global: fmi3*; local: *; };\n")
    target_link_options(${name}_fmu_library PRIVATE -Wl,--version-script=${directory}/shown.map)
  endif()
  add_executable(${name}_fmu_describe ${folder}/fmi/describe.cpp $<TARGET_OBJECTS:${name}_fmu_scene> $<TARGET_OBJECTS:qdot_fmi_parts>)
  qdot_fmu_target(${name}_fmu_describe ${folder})
  qdot_keep_warnings_out(${name}_fmu_describe)
  set_target_properties(${name}_fmu_describe PROPERTIES RUNTIME_OUTPUT_DIRECTORY "$<1:${directory}>")

  set(fmu ${CMAKE_CURRENT_BINARY_DIR}/${name}.fmu)
  add_custom_command(OUTPUT ${fmu}
    COMMAND ${name}_fmu_describe ${directory}/fmu/modelDescription.xml
    COMMAND ${CMAKE_COMMAND} -E tar cf ${fmu} --format=zip modelDescription.xml binaries
    WORKING_DIRECTORY ${directory}/fmu
    DEPENDS ${name}_fmu_describe ${name}_fmu_library
    COMMENT "Making ${name}.fmu"
    VERBATIM)
  add_custom_target(${name}_fmu ALL DEPENDS ${fmu})
endfunction()

function(qdot_fmu_target target folder)
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON CXX_EXTENSIONS OFF)
  if(qdot_IS_TOP_LEVEL)
    target_include_directories(${target} PRIVATE ${folder})
  else()
    target_include_directories(${target} SYSTEM PRIVATE ${folder})
  endif()
  target_link_libraries(${target} PRIVATE qdot::qdot)
endfunction()
