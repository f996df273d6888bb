# SPDX-License-Identifier: MIT
#
# What a header uses of the standard library it includes itself: newer libraries, Eigen 5 and SUNDIALS 7 bring in less by the
# way than their elders, and a header that leans on them compiles on one machine only.
set(rules
  "std::(string|to_string)[^_a-z]=string"
  "std::string_view=string_view"
  "std::vector<=vector"
  "std::array<=array"
  "std::function<=functional"
  "std::optional<=optional"
  "std::variant<=variant"
  "std::span<=span"
  "std::(unique_ptr|shared_ptr|make_unique|make_shared)[^a-z]=memory"
  "std::numeric_limits=limits"
  "std::(same_as|convertible_to|floating_point|integral|invocable)[^_a-z]=concepts"
  "std::(move|forward|pair|declval|exchange|swap|index_sequence|make_index_sequence)[^_a-z]=utility"
  "std::(is_[a-z_]+_v|conditional_t|remove_cvref_t|decay_t|enable_if_t|integral_constant)=type_traits"
  "std::(sqrt|sin|cos|tan|abs|fabs|exp|log|pow|isfinite|isnan|hypot|floor|ceil|fma|atan2)[^_a-z]=cmath"
  "std::(max|min|clamp|sort|find|any_of|all_of|copy|fill)[^_a-z]=algorithm"
  "std::(ostringstream|istringstream|stringstream)=sstream"
  "std::(initializer_list)=initializer_list"
  "std::(exception_ptr|current_exception|rethrow_exception)=exception"
  "std::u?int(8|16|32|64)_t=cstdint"
  "[^_a-z.]snprintf=cstdio"
  "[^_a-z]assert *\\(=cassert")

set(violations)
file(GLOB_RECURSE headers RELATIVE ${INCLUDE_DIR} ${INCLUDE_DIR}/*.hpp ${INCLUDE_DIR}/*.ipp)
foreach(header IN LISTS headers)
  file(READ ${INCLUDE_DIR}/${header} text)
  string(REPLACE ";" " " text "${text}")
  string(REGEX REPLACE "//[^\n]*" "" text "${text}")
  foreach(rule IN LISTS rules)
    string(REGEX MATCH "^(.*)=([a-z_]+)$" unused "${rule}")
    set(used "${CMAKE_MATCH_1}")
    set(needed "${CMAKE_MATCH_2}")
    if(text MATCHES "${used}" AND NOT text MATCHES "#include <${needed}>")
      string(REGEX MATCH "${used}" example "${text}")
      list(APPEND violations "${header}: ${example} needs <${needed}>")
    endif()
  endforeach()
endforeach()

if(violations)
  list(JOIN violations "\n  " violations)
  message(FATAL_ERROR "Headers lean on includes of others:\n  ${violations}")
endif()
