#pragma once

#include <exception>
#include <stop_token>

namespace armukf {

/// What a fit throws that was asked to stop: it has found nothing that is worth anything.
class Stopped : public std::exception {
 public:
  const char* what() const noexcept override { return "the fit was stopped"; }
};

inline void stop_if_asked(const std::stop_token& stop) {
  if (stop.stop_requested()) throw Stopped();
}

}  // namespace armukf
