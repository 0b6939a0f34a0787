#pragma once

#include <string>
#include <string_view>

#include "armukf/io/byte_source.hpp"

namespace armukf {

/// A file as messages call it; "-" is standard output.
std::string shown_name(const std::string& path);

/// Opens for writing from the start; "-" is standard output. InputError where that fails.
Descriptor open_for_writing(const std::string& path);

/// Opens for writing behind what the file holds; "-" is standard output. InputError where that
/// fails.
Descriptor open_for_appending(const std::string& path);

/// Takes away what a file holds; devices and pipes hold nothing. std::system_error, `name: cannot
/// write: why`, where that fails.
void make_empty(int descriptor, const std::string& name);

/// InputError where a file of that name could not be opened for writing; touches nothing.
void check_writable(const std::string& path);

/// Writes all bytes; false if nobody reads the other end of the pipe any more.
/// std::system_error, `name: cannot write: why`, on any other failure. Once `stop` is set a reader
/// that takes nothing for a second is one.
bool write_all(int descriptor, std::string_view bytes, const std::string& name,
               StopFlag stop = nullptr);

/// Removes what writers of that file left beside it when they were killed.
void remove_stale(const std::string& target);

/// A file that takes its name only when complete, and on disk: written beside its target, renamed
/// by commit(), removed if commit() is never reached. Standard output ("-"), devices and pipes are
/// written directly.
class AtomicFile {
 public:
  explicit AtomicFile(const std::string& target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::string_view text);

  /// For a CsvWriter(descriptor(), name()), which must be flushed before commit().
  int descriptor() const { return output_.number(); }
  const std::string& name() const { return name_; }

  /// Puts the file in its place; nothing may be written afterwards.
  void commit();

 private:
  void open_beside(const std::string& target);
  void sync(int descriptor) const;

  std::string name_;       // as in messages
  std::string target_;     // where symbolic links led
  std::string temporary_;  // empty if written directly, or committed
  Descriptor output_;
};

}  // namespace armukf
