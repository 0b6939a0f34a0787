#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "armukf/core/error.hpp"
#include "armukf/online/filters.hpp"
#include "armukf/online/settings.hpp"

namespace armukf {
namespace {

constexpr std::string_view kAdaptive = "adaptive";

template <class... F>
std::vector<std::string_view> names_of(TypeList<F...> /*registry*/) {
  return {F::name...};
}

}  // namespace

bool is_adaptive(std::string_view filter) { return filter.starts_with(kAdaptive); }

std::string_view kind_of(std::string_view filter) {
  if (!is_adaptive(filter)) return filter;
  filter.remove_prefix(kAdaptive.size());
  if (filter.empty()) return names_of(Filters<PublishedShape>()).front();
  filter.remove_prefix(1);  // the underscore
  return filter;
}

std::vector<std::string> filter_names() {
  const std::vector<std::string_view> kinds = names_of(Filters<PublishedShape>());
  std::vector<std::string> names(kinds.begin(), kinds.end());
  names.emplace_back(kAdaptive);
  for (std::size_t i = 1; i < kinds.size(); ++i)
    names.push_back(fmt::format("{}_{}", kAdaptive, kinds[i]));
  return names;
}

std::vector<std::string> smoothing_filter_names() {
  const std::vector<std::string_view> names = names_of(SmoothingFilters<PublishedShape>());
  return {names.begin(), names.end()};
}

std::string find_filter(std::string_view name) {
  const std::vector<std::string> names = filter_names();
  if (std::ranges::find(names, name) != names.end()) return std::string(name);
  throw InputError(fmt::format("unknown filter '{}'; known are: {}", name, fmt::join(names, ", ")));
}

}  // namespace armukf
