#pragma once

#include <optional>
#include <string>

#include "armukf/core/sequence.hpp"
#include "armukf/io/csv_reader.hpp"
#include "complaints.hpp"
#include "stream_options.hpp"

namespace armukf::apps {

/// The rows of an input, whatever some of them are.
class Rows {
 public:
  Rows(const std::string& input, const Columns& columns, const StreamOptions& options,
       Complaints& complaints);

  /// The next row that can be used; nothing at the end. InputError where the user wants to stop at
  /// a faulty one.
  std::optional<Sample> next();

  /// Of rows that could not be read, since this was asked last.
  int take_faulty();

  /// Says what has become of the last row, if that is not what its sender hoped.
  void tell(Fate fate);

  /// How samples of these rows come.
  Arrival arrival() const { return arrival_; }

  CsvReader& reader() { return reader_; }

 private:
  Rows(ByteSource source, const Columns& columns, const StreamOptions& options,
       Complaints& complaints);

  OnError on_error_;
  Arrival arrival_;
  CsvReader reader_;
  Complaints& complaints_;
  int faulty_ = 0;
};

}  // namespace armukf::apps
