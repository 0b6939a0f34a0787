#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// Languages that a model's equations are written in.
enum class Language { kC, kMatlab };

/// The language of that name (c, matlab); throws InputError listing them.
Language find_language(std::string_view name);

struct SourceFile {
  std::string name;
  std::string text;
};

/// A model's equations of motion, parameters and all, as source for others; `name` is that of the
/// model there, a word of letters, digits and _ (InputError where it cannot be one).
std::vector<SourceFile> source_files(const Model& model, std::string_view name, Language language,
                                     const Propagation& propagation);

/// In C, for a controller: NAME.h and NAME.c, C99 without a heap, with a Runge-Kutta step of at
/// most propagation.max_step_s (s).
std::vector<SourceFile> c_files(const Model& model, std::string_view name,
                                const Propagation& propagation);

/// For MATLAB and Octave: NAME.m, as idnlgrey calls it, [dx, y] = NAME(t, x, u, parameters...,
/// varargin), and NAME_parameters.m, which makes the idnlgrey model.
std::vector<SourceFile> matlab_files(const Model& model, std::string_view name);

}  // namespace armukf
