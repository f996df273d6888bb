# SPDX-License-Identifier: MIT
#
# Makes the target qdot::_mpi, which is all of MPI that qdot::mpi links, and sets qdot_mpi_status to how it was found or why it was not. Used by
# qdot's own build and, installed, by find_package(qdot COMPONENTS mpi).
#
# It is the MPI that the compiler's wrapper mpicxx on the PATH belongs to; MPI_HOME or MPI_CXX_COMPILER choose another, as CMake's FindMPI says.
if(TARGET qdot::_mpi)
  return()
endif()

# A project may have made the target itself. One that FindMPI made is seen in its directory only, and is found again below.
if(TARGET MPI::MPI_CXX)
  get_target_property(qdot_mpi_imported MPI::MPI_CXX IMPORTED)
  get_target_property(qdot_mpi_global MPI::MPI_CXX IMPORTED_GLOBAL)
  if(NOT qdot_mpi_imported OR qdot_mpi_global)
    add_library(qdot::_mpi INTERFACE IMPORTED GLOBAL)
    target_link_libraries(qdot::_mpi INTERFACE MPI::MPI_CXX)
    set(qdot_mpi_status "as the target MPI::MPI_CXX of this project")
    return()
  endif()
endif()

set(qdot_mpi_status "not looked for (CMAKE_DISABLE_FIND_PACKAGE_MPI)")
if(NOT CMAKE_DISABLE_FIND_PACKAGE_MPI)
  set(MPI_CXX_SKIP_MPICXX ON) # the C++ functions that MPI had until version 2
  find_package(MPI 3.0 QUIET COMPONENTS CXX)
  set(qdot_mpi_status "not found: no mpi.h of MPI 3 or newer with its library, by mpicxx or in MPI_HOME (${MPI_HOME}$ENV{MPI_HOME})")
  if(MPI_CXX_FOUND)
    add_library(qdot::_mpi INTERFACE IMPORTED GLOBAL)
    # What MPI::MPI_CXX says, which is seen in one directory only.
    target_include_directories(qdot::_mpi INTERFACE ${MPI_CXX_INCLUDE_DIRS})
    target_compile_definitions(qdot::_mpi INTERFACE ${MPI_CXX_COMPILE_DEFINITIONS})
    target_compile_options(qdot::_mpi INTERFACE ${MPI_CXX_COMPILE_OPTIONS})
    separate_arguments(qdot_mpi_link_flags NATIVE_COMMAND "${MPI_CXX_LINK_FLAGS}")
    target_link_options(qdot::_mpi INTERFACE ${qdot_mpi_link_flags})
    target_link_libraries(qdot::_mpi INTERFACE ${MPI_CXX_LIBRARIES})
    set(qdot_mpi_status "${MPI_CXX_VERSION} by ${MPI_CXX_COMPILER}")
  endif()
endif()
