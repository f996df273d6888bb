# SPDX-License-Identifier: MIT
#
# Makes the target qdot::_sundials, which is all of SUNDIALS that qdot::cvode links, and sets qdot_sundials_status to how
# it was found or why it was not. Used by qdot's own build and, installed, by find_package(qdot COMPONENTS cvode).
#
# SUNDIALS' own package file is tried first, with no version (6.4 refuses every range) and no component but cvode. It asks
# for whatever its packager switched on (OpenMP, MPI, ...), and is "not found" where one of those is missing, for example
# with clang and no libomp: then its header and libraries are looked for by name.

# An MPI build links MPI::MPI_C, which FindMPI makes only in projects that have switched the language C on.
function(qdot_provide_mpi_for_cxx_only_projects)
  get_property(languages GLOBAL PROPERTY ENABLED_LANGUAGES)
  if(TARGET MPI::MPI_C OR "C" IN_LIST languages)
    return()
  endif()
  find_package(MPI QUIET COMPONENTS CXX)
  if(TARGET MPI::MPI_CXX)
    add_library(MPI::MPI_C INTERFACE IMPORTED GLOBAL)
    target_link_libraries(MPI::MPI_C INTERFACE MPI::MPI_CXX)
  endif()
endfunction()

function(qdot_find_sundials_by_package)
  set(how "as the target SUNDIALS::cvode of this project")
  if(NOT TARGET SUNDIALS::cvode) # which a project may have made, of its own copy
    qdot_provide_mpi_for_cxx_only_projects()
    find_package(SUNDIALS CONFIG QUIET COMPONENTS cvode ${qdot_sundials_places})
    if(NOT SUNDIALS_FOUND OR NOT TARGET SUNDIALS::cvode)
      return()
    endif()
    set(how "${SUNDIALS_VERSION} by its package file in ${SUNDIALS_DIR}")
  endif()
  # 6.x has generic, 7.x has core in its place; which of the rest are targets depends on the build.
  set(libraries)
  foreach(name IN ITEMS cvode core generic nvecserial sunmatrixdense sunlinsoldense sunnonlinsolnewton sunnonlinsolfixedpoint)
    if(TARGET SUNDIALS::${name})
      list(APPEND libraries SUNDIALS::${name})
    endif()
  endforeach()
  add_library(qdot::_sundials INTERFACE IMPORTED GLOBAL)
  target_link_libraries(qdot::_sundials INTERFACE ${libraries})
  set(qdot_sundials_status "${how}" PARENT_SCOPE)
endfunction()

function(qdot_find_sundials_by_name)
  find_path(QDOT_SUNDIALS_INCLUDE_DIR cvode/cvode.h PATH_SUFFIXES include ${qdot_sundials_places})
  set(libraries)
  foreach(name IN ITEMS cvode core generic nvecserial)
    find_library(QDOT_SUNDIALS_${name}_LIBRARY sundials_${name} PATH_SUFFIXES lib lib64 ${qdot_sundials_places})
    mark_as_advanced(QDOT_SUNDIALS_${name}_LIBRARY)
    if(QDOT_SUNDIALS_${name}_LIBRARY)
      list(APPEND libraries ${QDOT_SUNDIALS_${name}_LIBRARY})
    endif()
  endforeach()
  mark_as_advanced(QDOT_SUNDIALS_INCLUDE_DIR)
  if(NOT QDOT_SUNDIALS_INCLUDE_DIR OR NOT QDOT_SUNDIALS_cvode_LIBRARY)
    return()
  endif()
  add_library(qdot::_sundials INTERFACE IMPORTED GLOBAL)
  target_include_directories(qdot::_sundials INTERFACE ${QDOT_SUNDIALS_INCLUDE_DIR})
  target_link_libraries(qdot::_sundials INTERFACE ${libraries})
  if(TARGET MPI::MPI_C) # its headers include mpi.h where it was built with MPI
    target_link_libraries(qdot::_sundials INTERFACE MPI::MPI_C)
  endif()
  set(qdot_sundials_status "by its header in ${QDOT_SUNDIALS_INCLUDE_DIR}" PARENT_SCOPE)
endfunction()

if(TARGET qdot::_sundials)
  return()
endif()

# Who says SUNDIALS_ROOT, as a variable or in the environment, means that one and no other.
set(qdot_sundials_places)
set(qdot_sundials_status "not found: no package file and no cvode/cvode.h with its libraries")
if(SUNDIALS_ROOT OR DEFINED ENV{SUNDIALS_ROOT})
  set(qdot_sundials_places PATHS ${SUNDIALS_ROOT} $ENV{SUNDIALS_ROOT} NO_DEFAULT_PATH)
  string(APPEND qdot_sundials_status " in SUNDIALS_ROOT (${SUNDIALS_ROOT}$ENV{SUNDIALS_ROOT})")
endif()
if(CMAKE_DISABLE_FIND_PACKAGE_SUNDIALS)
  set(qdot_sundials_status "not looked for (CMAKE_DISABLE_FIND_PACKAGE_SUNDIALS)")
else()
  qdot_find_sundials_by_package()
  if(NOT TARGET qdot::_sundials)
    qdot_find_sundials_by_name()
  endif()
endif()

# Without these an MPI build's headers bring in MPI's C++ bindings: slow to compile, and undefined when linked.
if(TARGET qdot::_sundials)
  target_compile_definitions(qdot::_sundials INTERFACE OMPI_SKIP_MPICXX MPICH_SKIP_MPICXX)
endif()
