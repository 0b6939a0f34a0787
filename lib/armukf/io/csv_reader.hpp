#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "armukf/core/constants.hpp"
#include "armukf/core/record.hpp"
#include "armukf/io/byte_source.hpp"

namespace armukf {

/// What the columns of a record are called in its header.
struct Columns {
  std::string t = "t";   // s
  std::string u = "u";   // N.m
  std::string y = "y";   // rad/s
  std::string key = {};  // of the arm that a row is about; none if empty
};

/// What a reader asks of the times of a record.
enum class TimeOrder { kRising, kAny };

/// The names from the option's text `t=NAME,u=NAME,y=NAME`, any of the three; InputError otherwise.
Columns parse_columns(std::string_view text);

/// The samples of a CSV record, one by one, in constant memory. Comma, semicolon or tab is taken
/// from the header; blank lines and lines that start with '#' are passed over.
class CsvReader {
 public:
  explicit CsvReader(ByteSource source, Columns columns = {}, TimeOrder order = TimeOrder::kRising);

  /// The next sample, nothing at the end of the record. InputError, `FILE:LINE: COLUMN: what`, on
  /// reaching what is faulty: the samples before it have been returned by then. It is a LineError
  /// where only a row is; the next call goes on after that.
  std::optional<Sample> next();

  /// The row that next() has thrown over, as a sample without a measurement; its torque is NaN
  /// where that cannot be read. Nothing where its time cannot.
  std::optional<Sample> salvaged() const;

  /// Which arm the last sample is of, valid until the next call; empty without such a column.
  std::string_view key() const { return key_; }

  /// Whether next() would wait for live input; the moment to flush what is to be seen downstream.
  bool would_wait();

  const std::string& name() const { return source_.name(); }
  std::size_t line_number() const { return source_.line_number(); }  // of the last row, from 1
  bool live() const { return source_.live(); }
  std::uint64_t consumed() const { return source_.consumed(); }         // bytes
  std::optional<std::uint64_t> size() const { return source_.size(); }  // bytes; none if live

 private:
  std::optional<Sample> next_sample();
  std::optional<std::string_view> next_line();
  std::optional<std::string_view> next_row();
  void read_header(std::string_view header);
  bool is_header(std::string_view row);
  std::size_t position(const std::string& column) const;
  void split(std::string_view row);
  void check_width() const;
  Sample parse(std::string_view row);
  double number(std::size_t role) const;
  void take_key();
  void check_order(double t) const;
  [[noreturn]] void fail(std::string_view column, std::string_view what) const;

  ByteSource source_;
  std::array<std::string, 3> names_;        // of t, u and y, in this order everywhere
  std::array<std::size_t, 3> positions_{};  // of them in a row
  std::string key_name_;
  std::size_t key_position_ = 0;
  std::string_view key_;
  TimeOrder order_;
  std::size_t width_ = 0;  // cells in the header; 0 before it is read
  char separator_ = ',';
  double last_t_ = -kInfinite;  // s
  bool has_samples_ = false;
  bool file_begun_ = false;              // since the last row
  std::vector<std::string_view> cells_;  // of the row at hand
};

/// All samples of a file, or of standard input for "-".
Record read_record(const std::string& path, const Columns& columns = {}, StopFlag stop = nullptr);

}  // namespace armukf
