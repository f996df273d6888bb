# SPDX-License-Identifier: MIT
#
# The core, qdot::qdot, headers with Eigen: conan create packaging/conan. The components cvode, optimal and mpi are installed along; whoever asks
# find_package for them brings SUNDIALS 6 or 7, Ipopt and MPI along, from the system or by a requirement of their own.
import os
import re

from conan import ConanFile
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load


class QdotConan(ConanFile):
    name = "qdot"
    license = "MIT"
    description = "From kinetic and potential energy to motion: Lagrangian dynamics by automatic differentiation"
    topics = ("mechanics", "dynamics", "lagrangian", "automatic-differentiation", "header-only")
    package_type = "header-library"
    settings = "os", "arch", "compiler", "build_type"
    options = {"eigen": ["conan", "system"]}
    default_options = {"eigen": "conan"}
    no_copy_source = True

    def _checkout(self):
        return os.path.normpath(os.path.join(self.recipe_folder, "..", ".."))

    def set_version(self):
        numbers = re.findall(r"int version_[a-z]+ = ([0-9]+);", load(self, os.path.join(self._checkout(), "include", "qdot", "version.hpp")))
        self.version = ".".join(numbers)

    def export_sources(self):
        for pattern in ("CMakeLists.txt", "LICENSE", "README.md", "CHANGELOG.md", "cmake/*", "include/*", "src/*", "docs/*", "examples/*"):
            copy(self, pattern, self._checkout(), self.export_sources_folder)

    def layout(self):
        cmake_layout(self)

    def requirements(self):
        if self.options.eigen == "conan":
            self.requires("eigen/[>=3.4.0 <6]", transitive_headers=True)

    def validate(self):
        check_min_cppstd(self, 20)

    def generate(self):
        toolchain = CMakeToolchain(self)
        for what in ("BUILD_PROGRAM", "BUILD_TESTS", "BUILD_EXAMPLES", "WITH_SUNDIALS", "WITH_IPOPT", "WITH_MPI"):
            toolchain.cache_variables["QDOT_" + what] = "OFF"
        toolchain.generate()
        if self.options.eigen == "conan":
            from conan.tools.cmake import CMakeDeps
            CMakeDeps(self).generate()

    def build(self):
        CMake(self).configure()

    def package(self):
        CMake(self).install()
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))

    def package_id(self):
        self.info.clear()

    def package_info(self):
        # qdot's own package file, which knows the components, and no second one by CMakeDeps.
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = [os.path.join("share", "cmake", "qdot")]
        self.cpp_info.set_property("pkg_config_name", "qdot")
        self.cpp_info.bindirs = []
        self.cpp_info.libdirs = []
