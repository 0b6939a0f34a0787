#pragma once

/// All that a user of the library needs. These headers need nothing but the standard library; what
/// else is installed beside them is detail, may change with any version, and may want Eigen and
/// Boost.
///
///     armukf::Session session(armukf::published_arm(), {});
///     while (...) {
///       const armukf::Estimate belief = session.step({.t = t, .u = torque, .y = speed});
///       ... belief.values, belief.deviations: states, then unknown parameters
///     }
///
/// SI units and radians throughout. What the caller gets wrong is an InputError; in the loop
/// nothing is thrown and nothing allocated.

#include "armukf/batch/evaluate.hpp"     // a model against records
#include "armukf/batch/experiment.hpp"   // simulated records
#include "armukf/batch/identify.hpp"     // the batch estimate
#include "armukf/batch/law_ranges.hpp"   // how far learnt laws are free
#include "armukf/core/build.hpp"         // which build of the library runs
#include "armukf/core/error.hpp"         // InputError
#include "armukf/core/record.hpp"        // samples
#include "armukf/diagnosis/trace.hpp"    // what a model lacks
#include "armukf/io/csv_reader.hpp"      // records from files
#include "armukf/model/learnt_laws.hpp"  // their curves
#include "armukf/model/model.hpp"        // the arm, its parameters and effects
#include "armukf/online/recursion.hpp"   // the recursive estimate of a whole record
#include "armukf/online/session.hpp"     // the recursive estimate, sample by sample
#include "armukf/online/smoother.hpp"    // states and parameters given the whole record
#include "armukf/online/track.hpp"       // the same of a stream as it comes, late and twice
#include "armukf/online/watch.hpp"       // what changes while it runs
#include "armukf/report/model_file.hpp"  // models from and to TOML files
