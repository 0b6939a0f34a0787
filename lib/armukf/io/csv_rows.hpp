#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace armukf {

/// Comma-separated rows, kept as cells until their text is wanted: to keep a number costs a tenth
/// of what its text does. A number takes its shortest text that reads back to the same double; a
/// missing one is `nan`.
class CsvRows {
 public:
  CsvRows() = default;
  virtual ~CsvRows() = default;
  CsvRows(const CsvRows&) = delete;
  CsvRows& operator=(const CsvRows&) = delete;

  void cell(double value) { cells_.push_back({value, 0, Kind::kNumber}); }
  void cell(std::string_view text) { put(text, Kind::kText); }
  virtual void end_row() { cells_.push_back({0.0, 0, Kind::kEnd}); }

  void row(std::span<const double> values);
  void row(std::span<const std::string> texts);

  /// Whole rows that are text already.
  virtual void append_rows(std::string_view rows) { put(rows, Kind::kRows); }

  /// Memory that they take until then, in bytes.
  std::size_t size() const { return cells_.size() * sizeof(Cell) + texts_.size(); }

  /// Moves the text of all of them to the end of another.
  void append_to(std::string& text);

  void swap(CsvRows& other);

 private:
  enum class Kind : std::uint8_t { kNumber, kText, kEnd, kRows };
  struct Cell {
    double number;
    std::uint32_t length;  // of its text among `texts_`, in bytes
    Kind kind;
  };

  void put(std::string_view text, Kind kind);

  std::vector<Cell> cells_;
  std::string texts_;  // of the cells that have one, one after the other
};

}  // namespace armukf
