// SPDX-License-Identifier: MIT
//
// The program qdot: the command line with the scenes of the catalogue.
#include "program/command_line.hpp"

int main(int argc, char** argv) { return qdot::program::command_line(argc, argv, qdot::program::bench); }
