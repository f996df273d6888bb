# SPDX-License-Identifier: MIT
#
# cmake -DCOMPILER=… -DHEADERS=… -DSOURCE=… -DINCLUDE=… -P compile.cmake: compiles SOURCE, and compares with its "// message: …" lines.
# With the precompiled HEADERS, or with the options that a line "// flags: …" names, for which there are none.
file(STRINGS ${SOURCE} messages REGEX "^// message: ")
list(TRANSFORM messages REPLACE "^// message: " "")

file(STRINGS ${SOURCE} options REGEX "^// flags: ")
string(REGEX REPLACE "^// flags: " "" options "${options}")
separate_arguments(options)
if(NOT options)
  set(options -include ${HEADERS})
endif()
list(LENGTH messages count)
if(count EQUAL 1) # nothing is asked of what comes after the first error, which takes the compiler ten times as long as all before
  list(APPEND options -Wfatal-errors)
endif()

list(TRANSFORM INCLUDE PREPEND -isystem OUTPUT_VARIABLE flags)
execute_process(COMMAND ${COMPILER} -std=c++20 -fsyntax-only ${options} ${flags} ${SOURCE}
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)

if(NOT messages)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "The control does not compile:\n${output}")
  endif()
  return()
endif()
if(result EQUAL 0)
  message(FATAL_ERROR "It compiles, and should say: ${messages}")
endif()
string(REGEX MATCH "error: [^\n]*" first_error "${output}")
list(GET messages 0 first_message)
string(FIND "${first_error}" "${first_message}" place)
if(place EQUAL -1)
  message(FATAL_ERROR "The first error should say: ${first_message}\nbut the compiler says:\n${output}")
endif()
foreach(message IN LISTS messages)
  string(FIND "${output}" "${message}" place)
  if(place EQUAL -1)
    message(FATAL_ERROR "An error should say: ${message}\nbut the compiler says:\n${output}")
  endif()
endforeach()
