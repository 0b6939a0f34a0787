#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace armukf {

/// The four experiments of the published study, told apart by what the motor speed has to follow.
enum class ExperimentKind {
  kEstimation,   // multisine on a filtered square wave
  kValidation1,  // the same with other phases
  kValidation2,  // multisine alone
  kValidation3,  // three slow sines
};

/// The experiment of that name (estimation, validation1, ...); throws InputError listing them.
ExperimentKind find_experiment(std::string_view name);
std::string_view name_of(ExperimentKind kind);
std::vector<std::string_view> experiment_names();

/// Amplitudes and frequencies of the references; as in the published study unless told otherwise.
struct ReferenceShape {
  double multisine_peak = 16.0;  // rad/s, greatest absolute value
  double lowest_line_hz = 1.0;   // of the multisine's flat spectrum
  double highest_line_hz = 40.0;
  double square_amplitude = 20.0;  // rad/s, about zero
  double square_cutoff_hz = 1.0;   // of the first-order low-pass that the square wave goes through
  double slow_sines_peak = 40.0;   // rad/s, greatest absolute value of their sum
};

/// One period of a speed reference (rad/s), a value per sample.
///
/// The period of the first three kinds is the record, of `samples` samples: the multisine has a
/// line at every multiple of 1 / (samples sample_time_s) between its bounds, all of one amplitude;
/// the square wave is +1 for the first half and -1 for the second. The slow sines, 0.1, 0.3 and 0.5
/// Hz with equal amplitudes, repeat after 10 s whatever the record. Phases are drawn by the seed,
/// differently for each kind.
///
/// Throws InputError where the record holds no line of the multisine, or no two samples per period
/// of its highest line.
std::vector<double> speed_reference(ExperimentKind kind, const ReferenceShape& shape, int samples,
                                    double sample_time_s, std::uint64_t seed);

}  // namespace armukf
