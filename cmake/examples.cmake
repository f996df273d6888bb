# SPDX-License-Identifier: MIT
#
# Every examples/NN_name.cpp is a program of its own, example_NN_name.
file(GLOB examples CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/examples/*.cpp)
foreach(source IN LISTS examples)
  get_filename_component(name ${source} NAME_WE)
  set(library qdot::qdot)
  file(STRINGS ${source} names_cvode REGEX "#include [<\"](qdot/integrate/cvode|scenes/)")
  if(names_cvode)
    set(library qdot::cvode)
  endif()
  if(NOT TARGET ${library})
    message(STATUS "Example ${name}: no, it needs SUNDIALS")
    continue()
  endif()
  add_executable(example_${name} ${source})
  set_target_properties(example_${name} PROPERTIES OUTPUT_NAME ${name} RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/examples)
  target_include_directories(example_${name} PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(example_${name} PRIVATE ${library})
  qdot_own_target(example_${name})
  # Built as a user builds them: the tests watch the same headers under sanitizers, and this halves the compile time.
  target_compile_options(example_${name} PRIVATE $<$<CONFIG:Check>:-fno-sanitize=all>)
endforeach()
