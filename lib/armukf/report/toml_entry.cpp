#include "armukf/report/toml_entry.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

namespace armukf {

void TomlEntry::fail(std::string_view what) const {
  throw InputError(*file_, node_->source().begin.line, key_, what);
}

double TomlEntry::number() const {
  const std::optional<double> value = node_->is_number() ? node_->value<double>() : std::nullopt;
  if (!value) fail("must be a number");
  if (std::isnan(*value)) fail("must be a number, not nan");
  return *value;
}

double TomlEntry::number(Range range) const {
  const double value = number();
  if (std::isinf(value)) fail(fmt::format("must be finite, not {}", value));
  if (range == Range::kNotNegative && value < 0.0)
    fail(fmt::format("must be at least 0, not {}", value));
  if (range == Range::kPositive && value <= 0.0)
    fail(fmt::format("must be above 0, not {}", value));
  return value;
}

int TomlEntry::count() const {
  if (!node_->is_integer()) fail("must be a whole number");
  const std::int64_t value = node_->as_integer()->get();
  if (value < 1 || value > std::numeric_limits<int>::max())
    fail(fmt::format("must be 1 to {}, not {}", std::numeric_limits<int>::max(), value));
  return static_cast<int>(value);
}

bool TomlEntry::truth() const {
  if (!node_->is_boolean()) fail("must be true or false");
  return node_->as_boolean()->get();
}

std::string TomlEntry::text() const {
  if (!node_->is_string()) fail("must be a string");
  return node_->as_string()->get();
}

std::vector<TomlEntry> TomlEntry::elements() const {
  if (!node_->is_array()) fail("must be an array");
  std::vector<TomlEntry> entries;
  for (const toml::node& element : *node_->as_array())
    entries.push_back({*file_, fmt::format("{}[{}]", key_, entries.size()), "", element});
  return entries;
}

std::vector<TomlEntry> TomlEntry::fields() const {
  if (!node_->is_table()) fail("must be a table");
  std::vector<TomlEntry> entries;
  for (const auto& [key, node] : *node_->as_table()) {
    const std::string name(key.str());
    entries.push_back({*file_, key_.empty() ? name : key_ + "." + name, name, node});
  }
  return entries;
}

std::vector<TomlEntry> TomlEntry::fields(const std::vector<std::string_view>& known) const {
  std::vector<TomlEntry> entries = fields();
  for (const TomlEntry& entry : entries) {
    if (std::ranges::find(known, entry.name_) == known.end())
      entry.fail(fmt::format("unknown key; known are: {}", fmt::join(known, ", ")));
  }
  return entries;
}

}  // namespace armukf
