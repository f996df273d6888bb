#pragma once
// SPDX-License-Identifier: MIT
//
// Arguments as text, and what is wrong with them.
//
// Every message is one line: the argument, the rule, what was given, and for an unknown name the nearest one. Numbers are
// read by std::from_chars, and pi is std::numbers::pi, so they mean the same double as in a C++ program, in every locale.

#include <optional>
#include <string>
#include <vector>

#include "qdot/error.hpp"

namespace qdot::program {

/// A bad argument: the program ends with status 2 and this one line on stderr.
class UsageError : public Error {
 public:
  using Error::Error;
};

/// The candidate that needs the fewest edits (insert, delete, replace, swap) to become `wanted`; "" if there are none.
std::string nearest_name(const std::string& wanted, const std::vector<std::string>& candidates);

/// "--method: \"adam\" is not a method; the nearest is \"adams\" (there are: adams, bdf)".
UsageError unknown_name(const std::string& argument, const std::string& what, const std::string& given,
                        const std::vector<std::string>& valid);

/// The number that a text denotes, all of it: 0.5, -1e-3, pi/2, 3*pi/4, 0.5pi, 90deg.
///
/// Factors stand between * and /, and are multiplied and divided from left to right. Each is a decimal number, pi, or a decimal number with
/// pi or deg behind it. `deg` makes radians of degrees.
///
/// @throws UsageError  unless it is one finite number
double finite_number(const std::string& argument, const std::string& text);

/// The number above zero that a text denotes.
double positive_number(const std::string& argument, const std::string& text);

/// The whole number between two bounds that a text denotes.
long whole_number(const std::string& argument, const std::string& text, long least, long most);

/// Makes the directory that PATH of --out lies in, where it is missing and can be made.
void make_directory_of(const std::string& out);

/// Refuses an --out whose files could not be written; the directory that they lie in is made.
///
/// @throws UsageError
void require_files(const std::string& out, const std::vector<std::string>& files);

/// OUT with each of these endings, if there is an OUT.
///
/// @throws UsageError  as require_files()
std::vector<std::string> writable_files(const std::optional<std::string>& out, const std::vector<std::string>& endings);

/// NAME=VALUE, taken apart.
struct Assignment {
  std::string name;
  double value = 0;
};

/// @throws UsageError  where there is no "=", no name, or no finite number
Assignment assignment(const std::string& argument, const std::string& text);

}  // namespace qdot::program
