#pragma once

#include <exception>
#include <utility>

namespace armukf::apps {

/// Lets several things be done whether or not others fail, and tells of the first that did.
class FirstFailure {
 public:
  /// before: what has failed already, or null.
  explicit FirstFailure(std::exception_ptr before = nullptr) : first_(std::move(before)) {}

  template <class Action>
  void of(const Action& action) {
    try {
      action();
    } catch (...) {
      if (!first_) first_ = std::current_exception();
    }
  }

  void rethrow() const {
    if (first_) std::rethrow_exception(first_);
  }

 private:
  std::exception_ptr first_;
};

}  // namespace armukf::apps
