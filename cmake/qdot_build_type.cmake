# SPDX-License-Identifier: MIT
#
# qdot_say_build_type(): says, once, that a project without a build type is compiled without optimization. Its build type is its own: it is not changed.
# Used in qdot's own build, where it is a part of another project, and, installed, by find_package(qdot).
function(qdot_say_build_type)
  get_property(several GLOBAL PROPERTY GENERATOR_IS_MULTI_CONFIG)
  get_property(said GLOBAL PROPERTY qdot_build_type_said)
  if(several OR said OR CMAKE_BUILD_TYPE OR CMAKE_CXX_FLAGS MATCHES "(^| )-O")
    return()
  endif()
  set_property(GLOBAL PROPERTY qdot_build_type_said ON)
  message(NOTICE "-- qdot: CMAKE_BUILD_TYPE is not set, so ${CMAKE_PROJECT_NAME} is compiled without optimization, and motions take some thirty times as long: "
    "-DCMAKE_BUILD_TYPE=Release")
endfunction()
