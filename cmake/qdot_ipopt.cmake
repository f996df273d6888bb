# SPDX-License-Identifier: MIT
#
# Makes the target qdot::_ipopt, which is all of Ipopt that qdot::optimal links, and sets qdot_ipopt_status to how it was found or why it was not. Used by
# qdot's own build and, installed, by find_package(qdot COMPONENTS optimal).
#
# Ipopt has no package file for CMake. Its headers lie in coin/ (up to 3.13) or coin-or/, its library is called ipopt.
if(TARGET qdot::_ipopt)
  return()
endif()

# A project may have made a target of its own copy.
foreach(name IN ITEMS Ipopt::Ipopt ipopt::ipopt PkgConfig::IPOPT PkgConfig::Ipopt PkgConfig::ipopt)
  if(TARGET ${name})
    add_library(qdot::_ipopt INTERFACE IMPORTED GLOBAL)
    target_link_libraries(qdot::_ipopt INTERFACE ${name})
    target_compile_definitions(qdot::_ipopt INTERFACE HAVE_CSTDDEF)
    set(qdot_ipopt_status "as the target ${name} of this project")
    return()
  endif()
endforeach()

# Who says IPOPT_ROOT, as a variable or in the environment, means that one and no other.
set(qdot_ipopt_places)
set(qdot_ipopt_status "not found: no coin/IpTNLP.hpp or coin-or/IpTNLP.hpp with its library")
if(IPOPT_ROOT OR DEFINED ENV{IPOPT_ROOT})
  set(qdot_ipopt_places PATHS ${IPOPT_ROOT} $ENV{IPOPT_ROOT} NO_DEFAULT_PATH)
  string(APPEND qdot_ipopt_status " in IPOPT_ROOT (${IPOPT_ROOT}$ENV{IPOPT_ROOT})")
endif()
if(CMAKE_DISABLE_FIND_PACKAGE_IPOPT)
  set(qdot_ipopt_status "not looked for (CMAKE_DISABLE_FIND_PACKAGE_IPOPT)")
else()
  find_path(QDOT_IPOPT_INCLUDE_DIR NAMES coin-or/IpTNLP.hpp coin/IpTNLP.hpp PATH_SUFFIXES include ${qdot_ipopt_places})
  find_library(QDOT_IPOPT_LIBRARY ipopt PATH_SUFFIXES lib lib64 ${qdot_ipopt_places})
  mark_as_advanced(QDOT_IPOPT_INCLUDE_DIR QDOT_IPOPT_LIBRARY)
  if(QDOT_IPOPT_INCLUDE_DIR AND QDOT_IPOPT_LIBRARY)
    add_library(qdot::_ipopt INTERFACE IMPORTED GLOBAL)
    target_include_directories(qdot::_ipopt INTERFACE ${QDOT_IPOPT_INCLUDE_DIR})
    target_link_libraries(qdot::_ipopt INTERFACE ${QDOT_IPOPT_LIBRARY})
    target_compile_definitions(qdot::_ipopt INTERFACE HAVE_CSTDDEF) # without which headers up to 3.13 refuse to be read
    set(qdot_ipopt_status "by its header in ${QDOT_IPOPT_INCLUDE_DIR}")
  endif()
endif()
