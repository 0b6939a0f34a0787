#pragma once

#include "armukf/core/sealed.hpp"

/// What checkpoints are sealed with. A version goes up whenever what is archived, or the order of
/// it, changes: an older checkpoint is then refused instead of being misread.
namespace armukf {

inline constexpr Seal kSessionSeal{"armukf_s", 13};
inline constexpr Seal kTrackSeal{"armukf_t", 16};

}  // namespace armukf
