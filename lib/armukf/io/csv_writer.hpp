#pragma once

#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "armukf/io/byte_source.hpp"
#include "armukf/io/csv_rows.hpp"

namespace armukf {

/// Writes comma-separated rows, whole ones at a time, in batches of some hundred. A full batch
/// becomes text and is written by a thread of its own, if there is more than one processor.
class CsvWriter : public CsvRows {
 public:
  /// Writes to the file from its start; "-" is standard output. `stop`: see write_all.
  explicit CsvWriter(const std::string& path, StopFlag stop = nullptr);

  /// Writes to what another owns; `name` stands for it in messages.
  CsvWriter(int descriptor, std::string name, StopFlag stop = nullptr);

  /// Flushes, so that rows reach the user also when an error ends the program; a failure to do so
  /// shows only in an explicit flush().
  ~CsvWriter() override;
  CsvWriter(const CsvWriter&) = delete;
  CsvWriter& operator=(const CsvWriter&) = delete;

  /// These hand a full batch over. std::system_error, `name: cannot write: why`, where one before
  /// it has failed.
  void end_row() override;
  void append_rows(std::string_view rows) override;

  /// Writes all rows so far before it returns. std::system_error as above.
  void flush();

  /// Whether nobody reads the other end of the pipe any more (SIGPIPE being ignored), or something
  /// could not be written; what comes afterwards is dropped, so that no row is missing before one
  /// that is there.
  bool closed() const { return closed_; }

 private:
  void hand_over_full();
  void wait_until_written(std::unique_lock<std::mutex>& lock);
  void write(CsvRows& rows);
  void work(const std::stop_token& stop);

  Descriptor owned_;  // none if another owns descriptor_
  int descriptor_;
  std::string name_;
  StopFlag stop_ = nullptr;
  std::string text_;  // of the batch that is being written
  std::atomic<bool> closed_ = false;

  std::mutex mutex_;  // of what both threads use
  std::condition_variable_any changed_;
  CsvRows given_;  // to the thread
  bool busy_ = false;
  std::exception_ptr failure_;
  std::jthread worker_;  // ends before all the rest
};

}  // namespace armukf
