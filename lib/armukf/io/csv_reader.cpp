#include "armukf/io/csv_reader.hpp"

#include <fast_float/fast_float.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <system_error>
#include <utility>

#include "armukf/core/constants.hpp"
#include "armukf/core/error.hpp"

namespace armukf {
namespace {

constexpr std::size_t kQuoted = 40;      // bytes of the user's text that a message repeats
constexpr std::size_t kListed = 20;      // names of columns that a message lists
constexpr std::size_t kMeasurement = 2;  // the role of y, which alone may be missing

/// The user's text as a message can show it: short, on one line, no control characters.
std::string shown(std::string_view text) {
  std::string result(text.substr(0, kQuoted));
  if (text.size() > kQuoted) {
    const auto is_continued = [&] { return (text[result.size()] & 0xC0) == 0x80; };
    while (!result.empty() && is_continued()) result.pop_back();  // keep whole UTF-8 characters
    result += "...";
  }
  const auto is_control = [](unsigned char c) { return c < ' ' || c == 0x7F; };
  std::replace_if(result.begin(), result.end(), is_control, '?');
  return result;
}

bool is_space(char c, char separator) {
  return c == ' ' || c == '\r' || (c == '\t' && separator != '\t');
}

/// Whether a line holds no row: blank, or a comment.
bool is_passed_over(std::string_view line) {
  const auto first = line.find_first_not_of(" \t\r");
  return first == std::string_view::npos || line[first] == '#';
}

/// Where the cell that starts at `begin` ends; a separator within quotes does not count.
const char* cell_end(const char* begin, const char* end, char separator) {
  while (begin != end && is_space(*begin, separator)) ++begin;
  if (begin != end && *begin == '"') {
    bool quoted = false;
    while (begin != end && (quoted || *begin != separator)) quoted ^= *begin++ == '"';
    return begin;
  }
  const void* found = std::memchr(begin, separator, static_cast<std::size_t>(end - begin));
  return found == nullptr ? end : static_cast<const char*>(found);
}

/// A cell without surrounding spaces and quotes.
std::string_view trimmed(const char* begin, const char* end, char separator) {
  while (begin != end && is_space(*begin, separator)) ++begin;
  while (begin != end && is_space(end[-1], separator)) --end;
  if (end - begin >= 2 && *begin == '"' && end[-1] == '"') ++begin, --end;
  return {begin, static_cast<std::size_t>(end - begin)};
}

/// The separator that occurs most often outside quotes.
char separator_of(std::string_view header) {
  std::array<std::pair<char, int>, 3> counts{{{',', 0}, {';', 0}, {'\t', 0}}};
  bool quoted = false;
  for (const char c : header) {
    quoted ^= c == '"';
    for (auto& [separator, count] : counts) count += c == separator && !quoted;
  }
  const auto fewer = [](const auto& a, const auto& b) { return a.second < b.second; };
  return std::max_element(counts.begin(), counts.end(), fewer)->first;
}

std::optional<double> to_number(std::string_view cell) {
  if (cell.size() > 1 && cell[0] == '+' && cell[1] != '-') cell.remove_prefix(1);
  const char* end = cell.data() + cell.size();
  double value = 0.0;
  const auto result = fast_float::from_chars(cell.data(), end, value);
  if (result.ec == std::errc::invalid_argument || result.ptr != end) return std::nullopt;
  return value;
}

std::string cells_counted(std::size_t count) {
  return fmt::format("{} {}", count, count == 1 ? "cell" : "cells");
}

}  // namespace

Columns parse_columns(std::string_view text) {
  const auto fail = [&](std::string_view what) {
    throw InputError("--columns", 0, "", fmt::format("'{}': {}", shown(text), what));
  };
  std::array<std::optional<std::string>, 3> names;
  for (std::string_view rest = text;;) {
    const std::string_view entry = rest.substr(0, rest.find(','));
    const auto role = std::string_view("tuy").find(entry.substr(0, 1));
    if (entry.size() < 3 || entry[1] != '=' || role == std::string_view::npos) {
      fail("expected t=NAME,u=NAME,y=NAME");
    }
    if (names[role]) fail(fmt::format("{} is given twice", entry[0]));
    names[role] = entry.substr(2);
    if (entry.size() == rest.size()) break;
    rest.remove_prefix(entry.size() + 1);
  }
  Columns result{names[0].value_or("t"), names[1].value_or("u"), names[2].value_or("y")};
  if (result.t == result.u || result.t == result.y || result.u == result.y) {
    fail("t, u and y must be three different columns");
  }
  return result;
}

CsvReader::CsvReader(ByteSource source, Columns columns, TimeOrder order)
    : source_(std::move(source)),
      names_{std::move(columns.t), std::move(columns.u), std::move(columns.y)},
      key_name_(std::move(columns.key)),
      order_(order) {}

std::optional<Sample> CsvReader::next() {
  cells_.clear();
  key_ = {};
  try {
    return next_sample();
  } catch (const LineError& error) {
    if (width_ == 0) throw InputError(error.what());  // without a header no row can be read
    throw;
  }
}

std::optional<Sample> CsvReader::salvaged() const {
  // The last cell of a row that was cut may have lost digits.
  const std::size_t whole = cells_.size() - (cells_.size() < width_ ? 1 : 0);
  if (cells_.empty() || positions_[0] >= whole || key_.empty() != key_name_.empty())
    return std::nullopt;
  const auto t = to_number(cells_[positions_[0]]);
  if (!t || !std::isfinite(*t) || (order_ == TimeOrder::kRising && *t <= last_t_))
    return std::nullopt;
  const auto u = positions_[1] < whole ? to_number(cells_[positions_[1]]) : std::nullopt;
  return Sample{.t = *t, .u = u.value_or(kNaN), .y = kNaN};
}

std::optional<Sample> CsvReader::next_sample() {
  auto row = next_row();
  if (row && width_ == 0) {
    read_header(*row);
    file_begun_ = false;
    row = next_row();
  }
  while (row && file_begun_ && is_header(*row)) row = next_row();
  file_begun_ = false;
  if (row) return parse(*row);
  if (has_samples_ || source_.stopped()) return std::nullopt;
  if (source_.line_number() == 0) throw InputError(name(), 0, "", "file is empty");
  throw InputError(name(), 0, "", width_ == 0 ? "no header line" : "has a header but no samples");
}

bool CsvReader::would_wait() {
  if (!live()) return false;
  while (source_.has_line()) {
    if (!is_passed_over(source_.front_line())) return false;
    next_line();
  }
  return true;
}

std::optional<std::string_view> CsvReader::next_line() {
  const auto line = source_.next_line();
  file_begun_ = file_begun_ || source_.begins_file();
  return line;
}

std::optional<std::string_view> CsvReader::next_row() {
  auto line = next_line();
  while (line && is_passed_over(*line)) line = next_line();
  if (line && line->find('\0') != std::string_view::npos) {
    fail("", "line holds a NUL byte: binary or UTF-16, not CSV text");
  }
  return line;
}

/// Whether the first row of another file than the first tells its columns; if so, reads it.
bool CsvReader::is_header(std::string_view row) {
  split(row);
  const auto is_cell = [&](const std::string& name) {
    return std::find(cells_.begin(), cells_.end(), name) != cells_.end();
  };
  if (!std::all_of(names_.begin(), names_.end(), is_cell)) return false;
  read_header(row);
  return true;
}

void CsvReader::read_header(std::string_view header) {
  separator_ = separator_of(header);
  split(header);
  while (cells_.size() > 1 && cells_.back().empty()) cells_.pop_back();  // closing separators
  for (std::size_t role = 0; role < names_.size(); ++role)
    positions_[role] = position(names_[role]);
  if (!key_name_.empty()) key_position_ = position(key_name_);
  width_ = cells_.size();
}

/// Where the header has this column.
std::size_t CsvReader::position(const std::string& column) const {
  const auto found = std::find(cells_.begin(), cells_.end(), column);
  if (found == cells_.end()) {
    std::string listed;
    for (std::size_t i = 0; i < std::min(cells_.size(), kListed); ++i) {
      listed += (i == 0 ? "" : ", ") + shown(cells_[i]);
    }
    fail(column, fmt::format("no such column; the header has {}{}", listed,
                             cells_.size() > kListed ? ", ..." : ""));
  }
  if (std::find(found + 1, cells_.end(), column) != cells_.end()) {
    fail(column, "the header has this column twice");
  }
  return static_cast<std::size_t>(found - cells_.begin());
}

void CsvReader::split(std::string_view row) {
  cells_.clear();
  const char* end = row.data() + row.size();
  for (const char* begin = row.data();;) {
    const char* stop = cell_end(begin, end, separator_);
    cells_.push_back(trimmed(begin, stop, separator_));
    if (stop == end) return;
    begin = stop + 1;
  }
}

void CsvReader::check_width() const {
  const bool closed = cells_.size() == width_ + 1 && cells_.back().empty();
  if (cells_.size() == width_ || closed) return;
  if (cells_.size() < width_ && !source_.terminated()) fail("", "row is cut in the middle");
  fail("", fmt::format("row has {}, the header has {}", cells_counted(cells_.size()), width_));
}

Sample CsvReader::parse(std::string_view row) {
  split(row);
  check_width();
  take_key();
  const Sample sample{.t = number(0), .u = number(1), .y = number(kMeasurement)};
  check_order(sample.t);
  last_t_ = sample.t;
  has_samples_ = true;
  return sample;
}

/// The arm's name, which may become part of a file's.
void CsvReader::take_key() {
  if (key_name_.empty()) return;
  key_ = cells_[key_position_];
  constexpr std::size_t kLongest = 100;  // bytes
  if (key_.empty()) fail(key_name_, "is empty");
  if (key_.size() > kLongest) fail(key_name_, fmt::format("'{}' is too long a name", shown(key_)));
  const auto is_unfit = [](unsigned char c) {
    return c < ' ' || c == 0x7F || c == '/' || c == '\\';
  };
  if (key_.front() == '.' || std::any_of(key_.begin(), key_.end(), is_unfit))
    fail(key_name_, fmt::format("'{}' is no name but a path", shown(key_)));
}

double CsvReader::number(std::size_t role) const {
  const std::string_view cell = cells_[positions_[role]];
  const auto value = cell.empty() ? kNaN : to_number(cell);
  if (value && std::isfinite(*value)) return *value;
  if (!value) {
    const bool has_comma = cell.find(',') != std::string_view::npos;
    fail(names_[role], fmt::format("'{}' is not a number{}", shown(cell),
                                   has_comma ? "; the decimal sign is a point" : ""));
  }
  if (std::isinf(*value)) fail(names_[role], fmt::format("'{}' is not finite", shown(cell)));
  if (role == kMeasurement) return kNaN;
  fail(names_[role],
       fmt::format("'{}' is missing, which only {} may be", shown(cell), names_[kMeasurement]));
}

void CsvReader::check_order(double t) const {
  if (t > last_t_ || order_ == TimeOrder::kAny) return;
  fail(names_[0], t == last_t_ ? fmt::format("time repeats: {} s after {} s", t, last_t_)
                               : fmt::format("time goes back: {} s after {} s", t, last_t_));
}

void CsvReader::fail(std::string_view column, std::string_view what) const {
  if (width_ == 0) throw InputError(name(), source_.line_number(), column, what);
  throw LineError(name(), source_.line_number(), column, what);
}

Record read_record(const std::string& path, const Columns& columns, StopFlag stop) {
  CsvReader reader(ByteSource(path, stop), columns);
  Record record{.name = reader.name(), .samples = {}};
  const auto check = [&](const std::string& column, double value) {
    constexpr double kLargest = 1e20;  // its square would drown all others
    if (std::abs(value) > kLargest)
      throw InputError(reader.name(), reader.line_number(), column,
                       fmt::format("{} is too large a number", value));
  };
  while (const auto sample = reader.next()) {
    check(columns.u, sample->u);
    check(columns.y, sample->y);
    record.samples.push_back(*sample);
  }
  return record;
}

}  // namespace armukf
