#pragma once

#include <string>

namespace midair::haptics
{

/// How a field is played on the skin.
enum class PlayedAs
{
    HELD,      ///< the field rests; a moving hand feels it as it passes
    VIBRATING, ///< the pressure goes up and down, 20 to 1000 times a second
    CIRCLING   ///< foci circle on the skin, as `contact` plays
};

/// How strong most people feel a force to be.
enum class Strength
{
    TOO_WEAK,
    FAINT,
    CLEAR,
    STRONG
};

/// Returns how strong most people feel a force of \a force_N on a fingertip to be: the mean force
/// of a field that is held or circles, the amplitude of a vibrating force. The steps (mN) to FAINT,
/// CLEAR and STRONG, each right to a factor of 2 (CONCEPTS.md, "How many pascals?", has the
/// sources):
///
///   held, a moving hand   4, 15, 40   a pass is a pulse of 30 to 90 ms; Dalecki et al. 1995
///   vibrating           0.4,  2, 10   finger, 200 Hz; Dalecki et al. 1995, 10.1121/1.411877
///   circling              1,  5, 15   20 mN feel like 0.24 N; Morisaki et al., arXiv 2301.11572
///
/// \a threshold_N: the least force that is felt, in place of the first step; the others change in
/// proportion. 0: the published one.
Strength strengthOf(double force_N, PlayedAs how, double threshold_N = 0.0);

/// "too weak to feel", "faint", "clear", "strong".
const char* strengthName(Strength strength);

/// "12 mN", "3.4 mN", "under 0.1 mN".
std::string forceText(double force_N);

} // namespace midair::haptics
