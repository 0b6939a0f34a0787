#pragma once

namespace armukf {

/// Spread of the scaled unscented transform. Source: R. van der Merwe, "Sigma-point Kalman filters
/// for probabilistic inference in dynamic state-space models", 2004, eq. 3.12-3.15. With twelve
/// states and unknowns points lie about one deviation away: at an alpha of 1 it is three and a
/// half, by which the resonances of start values that are hardly known differ by a factor of two,
/// and the slopes between them lead away from where the record pulls.
struct UnscentedSpread {
  double alpha = 0.3;  // distance of the points, in root-n deviations
  double beta = 2.0;   // 2 is best for a normal distribution
  double kappa = 0.0;
};

/// The spread of the cubature filter: points of equal weight, and none for the centre.
/// Source: I. Arasaratnam, S. Haykin, "Cubature Kalman filters", IEEE TAC 54 (2009), eq. 33.
inline constexpr UnscentedSpread kCubatureSpread{1.0, 0.0, 0.0};

}  // namespace armukf
