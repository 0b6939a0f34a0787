// Someone else's program: it finds the installed headers and links the installed library.

#include <cstdlib>
#include <string_view>

#include "armukf/core/error.hpp"

int main() {
  const armukf::InputError fault("run.csv", 17, "u", "'abc' is not a number");
  const bool as_promised = std::string_view(fault.what()) == "run.csv:17: u: 'abc' is not a number";
  return as_promised ? EXIT_SUCCESS : EXIT_FAILURE;
}
