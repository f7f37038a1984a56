#pragma once

#include <string>

namespace midair::bench
{

/// Prints how far predicted hands are off: a coordinate that reaches to and fro, a hand of 26
/// joints, a finger that crosses a plate in the octagon, and what it costs. \a ahead_ms: the
/// horizon of the first two.
void printPredictions(double ahead_ms);

/// Prints the same for the hands of the recording \a file, played 90 times a second: a prediction
/// is compared with where the recording goes. \a noise_mm is added to each joint. Throws
/// base::InputError if it can't be read.
void printRecording(const std::string& file, double ahead_ms, double noise_mm);

} // namespace midair::bench
