# SPDX-License-Identifier: MIT
#
# qdot_test_units(result bytes sources...): units of compilation that hold the test files, several in each, about so many bytes of source
# at most.
# At 80 000 g++'s largest units take three minutes and 5 GB; Clang's take 80 seconds and 4 GB at 180 000 with sanitizers, at 250 000 without.
#
# More than half of what a test file makes the compiler write is what others make it write, too: the standard library's, Eigen's and
# qdot's templates. Files of one unit share it. To its reader, and to the compiler, each stays a file of its own: what it includes
# is read before, and its own names are in a namespace of its own.

function(qdot_test_units result most)
  set(units)
  set(files)
  set(total 0)
  foreach(source IN LISTS ARGN)
    file(STRINGS ${source} not_in_a_namespace REGEX "^#include .*\\.cpp[>\"]|^template <>|operator (new|delete)\\(")
    if(not_in_a_namespace) # sources of the program, specializations of others' templates, allocation
      list(APPEND units ${source})
      continue()
    endif()
    file(SIZE ${CMAKE_CURRENT_SOURCE_DIR}/${source} size_${source})
    math(EXPR total "${total} + ${size_${source}}")
    list(APPEND files ${source})
  endforeach()
  # As few units as there can be, of about the same size: a file is in the unit in whose share of the bytes its middle lies.
  math(EXPR count "(${total} + ${most} - 1) / ${most}")
  set(bytes 0)
  foreach(source IN LISTS files)
    math(EXPR number "(2 * ${bytes} + ${size_${source}}) * ${count} / (2 * ${total})")
    math(EXPR bytes "${bytes} + ${size_${source}}")
    list(APPEND files_of_${number} ${source})
  endforeach()
  set(number 0)
  while(number LESS count)
    if(files_of_${number})
      qdot_write_test_unit(unit ${files_of_${number}})
      list(APPEND units ${unit})
    endif()
    math(EXPR number "${number} + 1")
  endwhile()
  set(${result} ${units} PARENT_SCOPE)
endfunction()

function(qdot_write_test_unit result)
  list(GET ARGN 0 first)
  string(REPLACE ".test.cpp" ".unit.cpp" unit ${CMAKE_CURRENT_BINARY_DIR}/units/${first})
  set(includes)
  set(files)
  foreach(source IN LISTS ARGN)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${source}) # its includes are read here
    file(STRINGS ${source} lines REGEX "^#include [<\"]")
    get_filename_component(folder ${source} DIRECTORY)
    foreach(line IN LISTS lines)
      string(REGEX REPLACE "^#include [<\"](.*)[>\"].*" "\\1" name "${line}")
      if(EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/${name}) # beside the file itself
        set(line "#include \"${CMAKE_CURRENT_SOURCE_DIR}/${folder}/${name}\"")
      endif()
      list(APPEND includes ${line})
    endforeach()
    string(MAKE_C_IDENTIFIER ${source} name)
    string(APPEND files "namespace ${name} {\n#include \"${CMAKE_CURRENT_SOURCE_DIR}/${source}\"\n}\n")
  endforeach()
  list(REMOVE_DUPLICATES includes)
  list(JOIN includes "\n" includes)
  file(CONFIGURE OUTPUT ${unit} CONTENT "${includes}\n\n${files}" @ONLY)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU") # which takes what a unit includes for headers, that others may include, too
    set_property(SOURCE ${unit} PROPERTY COMPILE_OPTIONS -Wno-subobject-linkage)
  endif()
  set(${result} ${unit} PARENT_SCOPE)
endfunction()
