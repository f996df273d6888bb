# SPDX-License-Identifier: MIT
#
# qdot_own_target(name): the flags of our own programs, tests and examples. Never for qdot::qdot, whose users keep theirs.
set(qdot_own_warnings)
if(CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
  set(qdot_own_warnings -Wall -Wextra -Wpedantic -Wconversion -Wshadow $<$<BOOL:${QDOT_WERROR}>:-Werror>)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  list(APPEND qdot_own_warnings -Wno-restrict) # g++ 12 warns of std::string's own operator+ (GCC bug 105651)
endif()
set(qdot_own_speed)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU") # collect garbage late: a tenth of the compile time, for a sixth more memory
  set(qdot_own_speed "SHELL:--param ggc-min-heapsize=1000000" "SHELL:--param ggc-min-expand=100")
endif()

function(qdot_own_target target)
  target_compile_features(${target} PRIVATE cxx_std_20)
  if(NOT DEFINED CMAKE_CXX_EXTENSIONS)
    set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF)
  endif()
  target_compile_options(${target} PRIVATE ${qdot_own_warnings} ${qdot_own_speed})
endfunction()
