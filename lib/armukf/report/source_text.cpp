#include "armukf/report/source_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "armukf/core/error.hpp"

namespace armukf {
namespace {

constexpr std::array<std::string_view, 2> kLanguages{"c", "matlab"};

/// Names that both languages take, and that are none of their words.
void check_name(std::string_view name) {
  constexpr std::size_t kLongest = 50;  // MATLAB takes 63 letters, some of which we add
  constexpr std::array<std::string_view, 12> kWords{"for",      "end",    "if",       "while",
                                                    "function", "return", "switch",   "case",
                                                    "else",     "break",  "continue", "global"};
  const auto fits = [](unsigned char c) { return std::isalnum(c) || c == '_'; };
  const bool good = !name.empty() && name.size() <= kLongest &&
                    std::isalpha(static_cast<unsigned char>(name[0])) &&
                    std::ranges::all_of(name, fits) && !std::ranges::count(kWords, name);
  if (!good)
    throw InputError(
        fmt::format("'{}' cannot be a name there: a letter, then letters, digits and _, {} at most",
                    name, kLongest));
}

}  // namespace

Language find_language(std::string_view name) {
  if (name == kLanguages[0]) return Language::kC;
  if (name == kLanguages[1]) return Language::kMatlab;
  throw InputError(fmt::format("unknown language '{}', it is one of {}, {}", name, kLanguages[0],
                               kLanguages[1]));
}

std::vector<SourceFile> source_files(const Model& model, std::string_view name, Language language,
                                     const Propagation& propagation) {
  check_name(name);
  return language == Language::kC ? c_files(model, name, propagation) : matlab_files(model, name);
}

}  // namespace armukf
