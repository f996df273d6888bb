# SPDX-License-Identifier: MIT
#
# An overlay port of the checkout that it lies in: vcpkg install qdot[cvode] --overlay-ports=packaging/vcpkg. In a registry of its own the
# next line is vcpkg_from_github(…).
get_filename_component(SOURCE_PATH "${CURRENT_PORT_DIR}/../../.." ABSOLUTE)

# Headers alone: what is installed is the same for all features, which bring SUNDIALS, Ipopt and MPI along for find_package(qdot COMPONENTS …).
set(VCPKG_BUILD_TYPE release)
vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS
    -DQDOT_BUILD_PROGRAM=OFF
    -DQDOT_BUILD_TESTS=OFF
    -DQDOT_BUILD_EXAMPLES=OFF
    -DQDOT_WITH_SUNDIALS=OFF
    -DQDOT_WITH_IPOPT=OFF
    -DQDOT_WITH_MPI=OFF
)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH share/cmake/qdot)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/lib" "${CURRENT_PACKAGES_DIR}/share/cmake" "${CURRENT_PACKAGES_DIR}/share/doc")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
