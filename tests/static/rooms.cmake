# SPDX-License-Identifier: MIT
#
# What users include lies directly in a layer, and qdot.hpp names all of it; folders below a layer are the library's own. So README, examples
# and scenes, which show how qdot is used, include nothing from these.
file(GLOB headers RELATIVE ${INCLUDE_DIR} ${INCLUDE_DIR}/*/*.hpp)
file(READ ${INCLUDE_DIR}/qdot.hpp contents)
set(violations)
foreach(header IN LISTS headers)
  string(FIND "${contents}" "qdot/${header}\"" place)
  if(place EQUAL -1)
    list(APPEND violations "qdot.hpp does not name ${header}")
  endif()
endforeach()
file(GLOB_RECURSE shown ${SOURCE_DIR}/examples/*.cpp ${SOURCE_DIR}/src/scenes/*.hpp ${SOURCE_DIR}/src/scenes/*.cpp)
foreach(file IN LISTS shown ITEMS ${SOURCE_DIR}/README.md)
  file(STRINGS ${file} includes REGEX "#include [<\"]qdot/[a-z]+/[a-z_]+/")
  foreach(line IN LISTS includes)
    list(APPEND violations "${file}: ${line}")
  endforeach()
endforeach()

list(LENGTH headers count)
if(count EQUAL 0)
  message(FATAL_ERROR "No headers in ${INCLUDE_DIR}")
endif()
if(violations)
  list(JOIN violations "\n  " violations)
  message(FATAL_ERROR "Rooms of the library and of its users:\n  ${violations}")
endif()
