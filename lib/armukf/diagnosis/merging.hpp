#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "armukf/diagnosis/candidates.hpp"
#include "armukf/diagnosis/completion.hpp"
#include "armukf/diagnosis/diagnosis.hpp"
#include "armukf/diagnosis/noise_check.hpp"
#include "armukf/diagnosis/removal.hpp"

/// Effects that were found, and are one.
namespace armukf {

/// Of each effect that was found the families that explained much in its round, its own among them.
using Alike = std::map<std::string, std::set<std::string>>;

/// Those of a round.
std::set<std::string> alike(const Refit& chosen, const std::vector<Refit>& refits);

/// An effect that does what two do that were found.
struct OneForTwo {
  Refit refit;                      // fitted without those
  std::array<std::size_t, 2> both;  // their places among the effects, in order
};

/// One effect in the stead of two, where the model with it foretells and simulates nearly as well
/// and the records are as likely, with a price for each value that is fitted (NoiseCheck::instead);
/// or where that cannot be told, it does so as well: a search that adds what helps most, one after
/// the other, may put together from two names what is one thing, as a torque constant that is too
/// small from a payload and more friction. Tried are all laws of the names of either, of what they
/// may be confused with, and of what explained much when either was found; nothing where many were
/// found. noise: of nearly the model as it is now.
std::optional<OneForTwo> one_for_two(const Completing& completing, const Alike& alike,
                                     const Diagnosis& diagnosis, const Explained& now,
                                     const Held& held, const KnownNoise& noise);

}  // namespace armukf
