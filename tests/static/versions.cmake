# SPDX-License-Identifier: MIT
#
# include/qdot/version.hpp is the only place of the version that CMake and Conan read; what registries read as it stands says the same, and so does the
# changelog's newest heading.
file(STRINGS ${INCLUDE_DIR}/version.hpp version REGEX "int version_[a-z]+ = [0-9]+;")
list(TRANSFORM version REPLACE "[^0-9]" "")
list(JOIN version "." version)
if(NOT version MATCHES "^[0-9]+\\.[0-9]+\\.[0-9]+$")
  message(FATAL_ERROR "${INCLUDE_DIR}/version.hpp gives no version of three numbers: ${version}")
endif()

set(number "[0-9]+\\.[0-9]+\\.[0-9]+")
set(places
  "packaging/vcpkg/qdot/vcpkg.json=\"version\": \"(${number})\""
  "packaging/spack/spack_repo/qdot/packages/qdot/package.py=version\\(\"(${number})\""
  "packaging/conda/recipe.yaml=version: \"(${number})\""
  "CHANGELOG.md=\n## (${number})")
set(violations)
foreach(place IN LISTS places)
  string(REGEX MATCH "^([^=]+)=(.+)$" both "${place}")
  set(file ${CMAKE_MATCH_1})
  set(pattern "${CMAKE_MATCH_2}")
  file(READ ${SOURCE_DIR}/${file} text)
  if(NOT text MATCHES "${pattern}")
    list(APPEND violations "${file} gives no version")
  elseif(NOT CMAKE_MATCH_1 STREQUAL version)
    list(APPEND violations "${file} says ${CMAKE_MATCH_1}")
  endif()
endforeach()
if(violations)
  list(JOIN violations "\n  " violations)
  message(FATAL_ERROR "include/qdot/version.hpp says ${version}, but\n  ${violations}")
endif()
message(STATUS "all recipes and the changelog say ${version}")
