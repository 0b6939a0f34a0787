#pragma once

#include <span>
#include <string>
#include <string_view>

#include "armukf/io/byte_source.hpp"

namespace armukf {

/// Writes comma-separated rows through a buffer of 64 KiB, whole rows at a time. A number takes its
/// shortest text that reads back to the same double; a missing one is `nan`.
class CsvWriter {
 public:
  /// Writes to the file from its start; "-" is standard output. `stop`: see write_all.
  explicit CsvWriter(const std::string& path, StopFlag stop = nullptr);

  /// Keeps all rows in text(), writes none.
  CsvWriter() = default;

  /// Writes to what another owns; `name` stands for it in messages.
  CsvWriter(int descriptor, std::string name);

  /// Flushes, so that rows reach the user also when an error ends the program; a failure to do so
  /// shows only in an explicit flush().
  ~CsvWriter();
  CsvWriter(const CsvWriter&) = delete;
  CsvWriter& operator=(const CsvWriter&) = delete;

  void cell(double value);
  void cell(std::string_view text);
  void end_row();

  void row(std::span<const double> values);
  void row(std::span<const std::string> texts);

  /// Whole rows that another writer has put together.
  void append_rows(std::string_view rows);

  /// Rows that are not written yet.
  std::string& text() { return buffer_; }

  /// Hands over what is in the buffer. std::system_error, `name: cannot write: why`, on failure.
  void flush();

  /// Whether nobody reads the other end of the pipe any more (SIGPIPE being ignored); what is
  /// written afterwards is dropped.
  bool closed() const { return closed_; }

 private:
  static constexpr int kNone = -1;
  void separate();

  Descriptor owned_;  // none if another owns descriptor_
  int descriptor_ = kNone;
  std::string name_;
  StopFlag stop_ = nullptr;
  std::string buffer_;
  bool in_row_ = false;
  bool closed_ = false;
};

}  // namespace armukf
