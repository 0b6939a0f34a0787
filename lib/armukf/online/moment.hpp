#pragma once

namespace armukf {

/// When something happens to a filter.
struct Moment {
  double t = 0.0;  // s, since the first sample
  // s, of that without gaps and standstill: how long the filter has had to learn.
  double watched = 0.0;
  bool at_rest = false;  // the sensor shows the same number all the while
};

}  // namespace armukf
