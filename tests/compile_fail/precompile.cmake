# SPDX-License-Identifier: MIT
#
# cmake -DCOMPILER=… -DHEADERS=… -DINCLUDE=… -P precompile.cmake: precompiles HEADERS for compile.cmake, with the same options.
list(TRANSFORM INCLUDE PREPEND -isystem OUTPUT_VARIABLE flags)
execute_process(COMMAND ${COMPILER} -std=c++20 ${flags} -x c++-header ${HEADERS} -o ${HEADERS}.gch COMMAND_ERROR_IS_FATAL ANY)
