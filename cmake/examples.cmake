# SPDX-License-Identifier: MIT
#
# Every examples/NN_name.cpp is a program of its own, example_NN_name.
file(GLOB examples CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/examples/*.cpp)
# Eigen is read once for all of them, and once for those with SUNDIALS, whose flags are others; what else they use they include themselves.
set(shares_eigen_with_qdot::qdot)
set(shares_eigen_with_qdot::cvode)
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
  if(shares_eigen_with_${library})
    target_precompile_headers(example_${name} REUSE_FROM ${shares_eigen_with_${library}})
  else()
    target_precompile_headers(example_${name} PRIVATE <Eigen/Core>)
    set(shares_eigen_with_${library} example_${name})
  endif()
  # Built as a user builds them: the tests watch the same headers under sanitizers, and this halves the compile time. Nobody looks for
  # their lines there.
  target_compile_options(example_${name} PRIVATE $<$<CONFIG:Check>:-fno-sanitize=all;-g0>)
endforeach()
