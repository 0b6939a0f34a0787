#include "armukf/io/csv_writer.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <system_error>
#include <utility>

#include "armukf/io/atomic_file.hpp"

namespace armukf {
namespace {

constexpr std::size_t kBufferSize = std::size_t{1} << 16;  // bytes; one write fills a pipe
constexpr std::size_t kLongestNumber = 24;                 // "-2.2250738585072014e-308"

}  // namespace

CsvWriter::CsvWriter(const std::string& path, StopFlag stop)
    : owned_(open_for_writing(path)),
      descriptor_(owned_.number()),
      name_(path == "-" ? "<stdout>" : path),
      stop_(stop) {
  buffer_.reserve(kBufferSize);
}

CsvWriter::CsvWriter(int descriptor, std::string name)
    : descriptor_(descriptor), name_(std::move(name)) {
  buffer_.reserve(kBufferSize);
}

CsvWriter::~CsvWriter() {
  try {
    flush();
  } catch (const std::system_error&) {
  }
}

void CsvWriter::cell(double value) {
  separate();
  std::array<char, kLongestNumber> text;
  const auto end = std::to_chars(text.begin(), text.end(), value).ptr;
  if (std::isnan(value)) {
    buffer_ += "nan";  // not "-nan"
  } else {
    buffer_.append(text.begin(), end);
  }
}

void CsvWriter::cell(std::string_view text) {
  separate();
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) {
    buffer_ += text;
    return;
  }
  buffer_ += '"';
  for (const char c : text) buffer_.append(c == '"' ? 2 : 1, c);
  buffer_ += '"';
}

void CsvWriter::separate() {
  if (in_row_) buffer_ += ',';
  in_row_ = true;
}

void CsvWriter::end_row() {
  buffer_ += '\n';
  in_row_ = false;
  if (buffer_.size() >= kBufferSize) flush();
}

void CsvWriter::append_rows(std::string_view rows) {
  buffer_ += rows;
  if (buffer_.size() >= kBufferSize) flush();
}

void CsvWriter::row(std::span<const double> values) {
  for (const double value : values) cell(value);
  end_row();
}

void CsvWriter::row(std::span<const std::string> texts) {
  for (const std::string& text : texts) cell(std::string_view(text));
  end_row();
}

void CsvWriter::flush() {
  if (descriptor_ == kNone) return;
  std::string rows = std::move(buffer_);
  buffer_.clear();  // also after a failure, so that no row is written twice
  closed_ = closed_ || !write_all(descriptor_, rows, name_, stop_);
  rows.clear();
  buffer_ = std::move(rows);  // keeps its capacity
}

}  // namespace armukf
