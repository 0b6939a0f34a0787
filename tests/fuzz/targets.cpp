#include "fuzz/targets.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "armukf/core/archive.hpp"
#include "armukf/core/error.hpp"
#include "armukf/io/atomic_file.hpp"
#include "armukf/io/csv_reader.hpp"
#include "armukf/online/description.hpp"
#include "armukf/online/seals.hpp"
#include "armukf/online/session.hpp"
#include "armukf/online/track.hpp"
#include "armukf/report/model_file.hpp"

namespace armukf::fuzz {
namespace {

/// Ends the program where that does not hold, as a sanitizer would.
void demand(bool holds, std::string_view what) {
  if (holds) return;
  fmt::print(stderr, "fuzz: {}\n", what);
  std::abort();
}

ByteSource file(std::string_view content) {
  Descriptor memory(::memfd_create("fuzz", MFD_CLOEXEC));
  write_all(memory.number(), content, "fuzz");
  ::lseek(memory.number(), 0, SEEK_SET);
  return {std::move(memory), "fuzz"};
}

void read_all(CsvReader& reader) {
  for (;;) {
    try {
      const auto sample = reader.next();
      if (!sample) return;
      demand(std::isfinite(sample->t) && std::isfinite(sample->u) && !std::isinf(sample->y),
             "a sample is not finite");
    } catch (const LineError&) {
      if (const auto sample = reader.salvaged())
        demand(std::isfinite(sample->t) && std::isnan(sample->y), "salvage without a time");
    }
  }
}

void step_some(Session& session) {
  for (int k = 0; k < 3; ++k) session.step({.t = 1e6 + 5e-4 * k, .u = 1.0, .y = 2.0});
}

template <class Action>
void unless_refused(const Action& action) {
  try {
    action();
  } catch (const InputError&) {  // as it should be
  }
}

}  // namespace

void csv(std::string_view bytes) {
  for (const char* key : {"", "arm"}) {
    for (const TimeOrder order : {TimeOrder::kRising, TimeOrder::kAny}) {
      CsvReader reader(file(bytes), {.key = key}, order);
      unless_refused([&] { read_all(reader); });
    }
  }
}

void model(std::string_view bytes) {
  unless_refused([&] {
    const ModelFile content = parse_model_file(std::string(bytes), "fuzz");
    const std::string text = model_file_text(content);
    demand(model_file_text(parse_model_file(text, "again")) == text, "does not read back");
  });
}

void checkpoint(std::string_view bytes) {
  Session session(published_arm(), {});
  unless_refused([&] {
    session.load(bytes);
    step_some(session);
  });
  OutArchive content;
  std::string described = description(published_arm(), {});
  content(described);
  unless_refused([&] {
    session.load(sealed(kSessionSeal, content.bytes() + std::string(bytes)));
    step_some(session);
  });
  Track track(published_arm(), {});
  unless_refused([&] {
    track.load(sealed(kTrackSeal, bytes));
    track.put({.t = 1e6});
    while (track.next()) {
    }
  });
}

void estimate(std::string_view bytes) {
  if (bytes.empty()) return;
  const auto choice = static_cast<unsigned char>(bytes[0]);
  const std::vector<std::string> filters = filter_names();
  EstimatorSettings settings;
  settings.filter = filters[choice % filters.size()];
  // What takes longer than a second shall be a fault, not an interval of many steps, each of which
  // takes a sanitizer 0.1 ms.
  constexpr double kMostS = 10.0;
  settings.propagation.max_step_s = 0.01;
  double integrated_s = 0.0;
  double last_s = std::nan("");
  Track track(published_arm(), settings, {.reorder_s = choice >= 128 ? 0.002 : 0.0});
  const auto expect_finite = [&] {
    while (const auto e = track.next()) {
      for (const double value : e->values) demand(std::isfinite(value), "a value is not finite");
      for (const double sd : e->deviations)
        demand(std::isfinite(sd) && sd >= 0.0, "a deviation is none");
    }
  };
  std::array<double, 3> row{};
  for (std::size_t at = 1; at + sizeof row <= bytes.size(); at += sizeof row) {
    std::memcpy(row.data(), bytes.data() + at, sizeof row);
    const double dt = row[0] - last_s;
    if (dt > 0.0 && dt <= kMostS) integrated_s += dt;
    if (integrated_s > kMostS) break;
    last_s = row[0];
    track.put({.t = row[0], .u = row[1], .y = row[2]});
    expect_finite();
  }
  track.end();
  expect_finite();
}

}  // namespace armukf::fuzz
