# SPDX-License-Identifier: MIT
#
# cmake --install: headers, and a package file that find_package(qdot [COMPONENTS cvode]) reads.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_DATADIR}/cmake/qdot)

# INCLUDES DESTINATION says again what the file set says, for users whose CMake (before 3.23) does not know file sets.
if(CMAKE_VERSION VERSION_GREATER_EQUAL 3.23)
  install(TARGETS qdot EXPORT qdot-targets FILE_SET HEADERS INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(TARGETS qdot_cvode EXPORT qdot-cvode-targets FILE_SET HEADERS INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(TARGETS qdot_optimal EXPORT qdot-optimal-targets FILE_SET HEADERS INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(TARGETS qdot_mpi EXPORT qdot-mpi-targets FILE_SET HEADERS INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
else()
  install(TARGETS qdot EXPORT qdot-targets INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(TARGETS qdot_cvode EXPORT qdot-cvode-targets INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(TARGETS qdot_optimal EXPORT qdot-optimal-targets INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(TARGETS qdot_mpi EXPORT qdot-mpi-targets INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/qdot DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN *.hpp PATTERN *.ipp)
endif()
install(EXPORT qdot-targets NAMESPACE qdot:: DESTINATION ${package_dir})
install(EXPORT qdot-cvode-targets NAMESPACE qdot:: DESTINATION ${package_dir})
install(EXPORT qdot-optimal-targets NAMESPACE qdot:: DESTINATION ${package_dir})
install(EXPORT qdot-mpi-targets NAMESPACE qdot:: DESTINATION ${package_dir})

# qdot_add_scene compiles the commands of the program where they are used, with the user's compiler and options; qdot_add_fmu the functions of FMI; and
# qdot::compiled is compiled there, too.
set(qdot_program_folder ${CMAKE_INSTALL_DATADIR}/qdot/src)
set(own_scene_headers ${PROJECT_SOURCE_DIR}/src/scenes/scene.hpp ${PROJECT_SOURCE_DIR}/src/scenes/own_scene.hpp ${PROJECT_SOURCE_DIR}/src/scenes/view.hpp)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/src/program ${PROJECT_SOURCE_DIR}/src/own ${PROJECT_SOURCE_DIR}/src/fmi ${PROJECT_SOURCE_DIR}/src/compiled DESTINATION ${qdot_program_folder}
  FILES_MATCHING PATTERN *.hpp PATTERN *.cpp PATTERN CMakeLists.txt)
install(FILES ${own_scene_headers} DESTINATION ${qdot_program_folder}/scenes)

configure_package_config_file(cmake/qdot-config.cmake.in qdot-config.cmake INSTALL_DESTINATION ${package_dir} PATH_VARS qdot_program_folder)
write_basic_package_version_file(qdot-config-version.cmake COMPATIBILITY SameMinorVersion ARCH_INDEPENDENT)
install(FILES
  ${PROJECT_BINARY_DIR}/qdot-config.cmake
  ${PROJECT_BINARY_DIR}/qdot-config-version.cmake
  ${PROJECT_SOURCE_DIR}/cmake/qdot_build_type.cmake
  ${PROJECT_SOURCE_DIR}/cmake/qdot_sundials.cmake
  ${PROJECT_SOURCE_DIR}/cmake/qdot_ipopt.cmake
  ${PROJECT_SOURCE_DIR}/cmake/qdot_mpi.cmake
  ${PROJECT_SOURCE_DIR}/cmake/qdot_add_scene.cmake
  ${PROJECT_SOURCE_DIR}/cmake/qdot_add_fmu.cmake
  ${PROJECT_SOURCE_DIR}/cmake/qdot_compiled.cmake
  DESTINATION ${package_dir})

# The core for tools that read the Common Package Specification. Only where it is asked for: find_package of CMake 4.3 and newer takes this file before
# qdot-config.cmake, and then knows neither components nor qdot_add_scene. The file has no place for options that depend on the compiler (clang's room for
# constants), so it is made of a target without them.
if(QDOT_INSTALL_CPS)
  if(CMAKE_VERSION VERSION_LESS 4.3)
    message(FATAL_ERROR "QDOT_INSTALL_CPS=ON needs CMake 4.3 or newer, this is ${CMAKE_VERSION}")
  endif()
  add_library(qdot_cps INTERFACE)
  set_target_properties(qdot_cps PROPERTIES EXPORT_NAME qdot)
  target_compile_features(qdot_cps INTERFACE cxx_std_20)
  target_link_libraries(qdot_cps INTERFACE Eigen3::Eigen)
  install(TARGETS qdot_cps EXPORT qdot-cps INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(PACKAGE_INFO qdot EXPORT qdot-cps LICENSE MIT VERSION ${PROJECT_VERSION} COMPAT_VERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}.0
    DEFAULT_TARGETS qdot DESTINATION ${CMAKE_INSTALL_DATADIR}/cps/qdot)
endif()

# Without CMake: pkg-config --cflags qdot, the core alone (SUNDIALS has no such file). What there is to read and to try.
configure_file(${PROJECT_SOURCE_DIR}/cmake/qdot.pc.in qdot.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/qdot.pc DESTINATION ${CMAKE_INSTALL_DATADIR}/pkgconfig)
install(FILES ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs ${PROJECT_SOURCE_DIR}/examples DESTINATION ${CMAKE_INSTALL_DOCDIR} PATTERN site EXCLUDE)
