#pragma once

#include "engine-bridge/hands/Hand.h"

#include <cstddef>
#include <functional>
#include <istream>
#include <string>

namespace midair::bridge
{

/// A line of a recording of hands and heads: a joint of a hand, or a head.
struct RecordedRow
{
    static constexpr int kHead = HAND_JOINTS; ///< joint number of a line with a head

    double time_s = 0.0; ///< >= 0
    int hand = 0;        ///< meaningless for a head
    int joint = 0;       ///< 0 .. HAND_JOINTS - 1, or kHead
    HandJoint value;
};

constexpr std::size_t kMostRecordedFrames = 200000;
/// The columns of a line.
extern const char* const kRecordedHeadings;

/// Passes each line of a recording to \a take, which returns an error or an empty text. \a name: of
/// the file, for errors. Throws base::InputError, which names the line.
void readRecording(std::istream& in,
                   const std::string& name,
                   const std::function<std::string(const RecordedRow& row)>& take);

/// Returns the text of the recording in the file \a path. Throws base::InputError.
std::string recordingIn(const std::string& path);

/// Converts \a time_s to the time in a recording of \a duration_s, which repeats if it \a loops.
double recordedTime(double time_s, double duration_s, bool loops);

} // namespace midair::bridge
