# SPDX-License-Identifier: MIT
import os

from spack_repo.builtin.build_systems.cmake import CMakePackage

from spack.package import *


class Qdot(CMakePackage):
    """From kinetic and potential energy to motion: Lagrangian dynamics by automatic differentiation."""

    # The checkout that this file lies in; `spack dev-build qdot` builds it as it stands.
    git = "file://" + os.path.abspath(os.path.join(os.path.dirname(__file__), *[os.pardir] * 6))

    license("MIT")

    version("0.3.0", branch="main")

    variant("cvode", default=False, description="The component cvode: methods of SUNDIALS")
    variant("optimal", default=False, description="The component optimal: optimal motions by Ipopt")
    variant("mpi", default=False, description="The component mpi: many motions by the processes of MPI")

    depends_on("cxx", type="build")
    depends_on("cmake@3.22:", type="build")
    depends_on("eigen@3.4:")
    depends_on("sundials@6:", when="+cvode")
    depends_on("ipopt", when="+optimal")
    depends_on("mpi@3:", when="+mpi")

    conflicts("%gcc@:11", msg="qdot is C++20 as g++ 12 and clang 16 compile it")
    conflicts("%clang@:15", msg="qdot is C++20 as g++ 12 and clang 16 compile it")

    def cmake_args(self):
        off = ("BUILD_PROGRAM", "BUILD_TESTS", "BUILD_EXAMPLES")
        return [self.define("QDOT_" + what, False) for what in off] + [
            self.define("QDOT_WITH_SUNDIALS", "ON" if "+cvode" in self.spec else "OFF"),
            self.define("QDOT_WITH_IPOPT", "ON" if "+optimal" in self.spec else "OFF"),
            self.define("QDOT_WITH_MPI", "ON" if "+mpi" in self.spec else "OFF"),
        ]
