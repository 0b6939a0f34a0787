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
/// standard input) or another output, or could not be written. Devices and pipes replace nothing,
/// and standard output (-), which only one of them may take.
void check_outputs(const std::vector<std::string>& records, const std::vector<Output>& outputs);

}  // namespace armukf::apps
