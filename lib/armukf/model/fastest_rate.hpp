#pragma once

#include "armukf/model/model.hpp"

namespace armukf {

/// 1/s, the magnitude of the fastest eigenvalue of the model's motion about rest: of it and of the
/// step hangs how exactly a Runge-Kutta method follows, and whether it does. Infinite of an effect
/// that is faster in motion, or where there is none.
double fastest_rate(const Model& model);

}  // namespace armukf
