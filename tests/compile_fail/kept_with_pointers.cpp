// What means nothing in another process, and what nobody knows how to send there.
// message: qdot: what a motion keeps is sent from process to process: it must be a number, a trivially copyable struct without pointers
#include <map>
#include <string_view>
#include <vector>

#include <qdot/integrate/mpi/bytes.hpp>

int main() {
  qdot::detail::require_sendable<std::vector<double>>();
  qdot::detail::require_sendable<std::vector<const char*>>();
  qdot::detail::require_sendable<std::string_view>();
  qdot::detail::require_sendable<std::map<int, double>>();
}
