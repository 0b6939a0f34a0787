#pragma once

#include <string>
#include <vector>

namespace armukf::apps {

/// A file that an option writes; none where the path is empty.
struct Output {
  const char* option;
  std::string path;
};

/// Before anything is done: InputError where an output would replace a record that is read (- is
/// standard input) or another output, or could not be written. Standard output, devices and pipes
/// replace nothing.
void check_outputs(const std::vector<std::string>& records, const std::vector<Output>& outputs);

}  // namespace armukf::apps
