#pragma once

#include <cstdint>
#include <string>

namespace midair::samples
{

/// Somebody whose threshold is known, to try the procedure: feels a difference x with probability
///     lapse/2 + (1 - lapse) Phi((x - threshold)/spread),
/// Phi the normal distribution, so that x = threshold is felt in half of all trials.
struct SimulatedParticipant
{
    double threshold = 0.0;
    double spread = 1.0; ///< > 0, standard deviation of Phi; its slope is 1/(spread sqrt(2 pi))
    double lapse = 0.02; ///< 0 .. 1: share of trials that are answered by a coin
    std::uint64_t seed = 1;

    double chance(double value) const;

    /// Returns the answer in trial \a trial, from 1. It depends on what is given here alone, so a
    /// run that goes on after it was killed has the answers of one that wasn't.
    bool feels(int trial, double value) const;
};

/// Returns what is wrong with it, as a sentence; empty: nothing.
std::string problemOf(const SimulatedParticipant& participant);

} // namespace midair::samples
