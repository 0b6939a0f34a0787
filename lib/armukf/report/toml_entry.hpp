#pragma once

#include <toml++/toml.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "armukf/core/error.hpp"
#include "armukf/report/settings_fields.hpp"

namespace armukf {

/// A value in a TOML file beside its dotted key and its line. Whatever it is asked for and does not
/// hold is an InputError, `FILE:LINE: KEY: what is wrong`. The parsed file must outlive it.
class TomlEntry {
 public:
  /// The whole file, whose key is empty.
  TomlEntry(const std::string& file, const toml::table& root) : TomlEntry(file, "", "", root) {}

  /// Its key in the table that holds it.
  const std::string& name() const { return name_; }

  double number() const;             // any, also infinite; not NaN
  double number(Range range) const;  // finite and in range
  int count() const;                 // 1 or more
  bool truth() const;
  std::string text() const;
  std::vector<TomlEntry> elements() const;

  /// What a table holds, in alphabetical order of the keys.
  std::vector<TomlEntry> fields() const;

  /// Those fields, each of which must be among the known ones.
  std::vector<TomlEntry> fields(const std::vector<std::string_view>& known) const;

  [[noreturn]] void fail(std::string_view what) const;

  /// The result of an action; an InputError of it gets this entry's place.
  template <class Action>
  auto placed(const Action& action) const {
    try {
      return action();
    } catch (const InputError& error) {
      fail(error.what());
    }
  }

 private:
  TomlEntry(const std::string& file, std::string key, std::string name, const toml::node& node)
      : file_(&file), key_(std::move(key)), name_(std::move(name)), node_(&node) {}

  const std::string* file_;
  std::string key_;  // dotted, from the top of the file
  std::string name_;
  const toml::node* node_;
};

}  // namespace armukf
