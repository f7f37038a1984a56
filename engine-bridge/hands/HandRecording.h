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
    static constexpr int kHead = HAND_JOINTS; ///< the joint of a line that is a head's

    double time_s = 0.0; ///< >= 0
    int hand = 0;        ///< of a head of no meaning
    int joint = 0;       ///< 0 .. HAND_JOINTS - 1, or kHead
    HandJoint value;
};

constexpr std::size_t kMostRecordedFrames = 200000;
/// The columns of a line.
extern const char* const kRecordedHeadings;

/// Hands each line of a recording to \a take, which returns what is wrong with it; empty: nothing.
/// \a name: of the file, for errors. Throws base::InputError, which names the line.
void readRecording(std::istream& in,
                   const std::string& name,
                   const std::function<std::string(const RecordedRow& row)>& take);

/// The text of the recording in the file \a path. Throws base::InputError.
std::string recordingIn(const std::string& path);

/// The time \a time_s in a recording that is \a duration_s long, and begins anew if it \a loops.
double recordedTime(double time_s, double duration_s, bool loops);

} // namespace midair::bridge
