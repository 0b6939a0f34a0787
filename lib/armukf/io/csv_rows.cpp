#include "armukf/io/csv_rows.hpp"

#include <array>
#include <charconv>
#include <cmath>

namespace armukf {
namespace {

constexpr std::size_t kLongestNumber = 24;  // "-2.2250738585072014e-308"

void append_number(double value, std::string& text) {
  std::array<char, kLongestNumber> digits;
  const auto end = std::to_chars(digits.begin(), digits.end(), value).ptr;
  if (std::isnan(value)) {
    text += "nan";  // not "-nan"
  } else {
    text.append(digits.begin(), end);
  }
}

void append_text(std::string_view cell, std::string& text) {
  if (cell.find_first_of(",\"\r\n") == std::string_view::npos) {
    text += cell;
    return;
  }
  text += '"';
  for (const char c : cell) text.append(c == '"' ? 2 : 1, c);
  text += '"';
}

}  // namespace

void CsvRows::row(std::span<const double> values) {
  for (const double value : values) cell(value);
  end_row();
}

void CsvRows::row(std::span<const std::string> texts) {
  for (const std::string& text : texts) cell(std::string_view(text));
  end_row();
}

void CsvRows::put(std::string_view text, Kind kind) {
  texts_ += text;
  cells_.push_back({0.0, static_cast<std::uint32_t>(text.size()), kind});
}

void CsvRows::append_to(std::string& text) {
  const char* next = texts_.data();
  bool in_row = false;
  for (const Cell& cell : cells_) {
    const std::string_view own(next, cell.length);
    next += cell.length;
    if (cell.kind == Kind::kEnd) {
      text += '\n';
    } else if (cell.kind == Kind::kRows) {
      text += own;
    } else {
      if (in_row) text += ',';
      cell.kind == Kind::kText ? append_text(own, text) : append_number(cell.number, text);
    }
    in_row = cell.kind == Kind::kNumber || cell.kind == Kind::kText;
  }
  cells_.clear();
  texts_.clear();
}

void CsvRows::swap(CsvRows& other) {
  cells_.swap(other.cells_);
  texts_.swap(other.texts_);
}

}  // namespace armukf
