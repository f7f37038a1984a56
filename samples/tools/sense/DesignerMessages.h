#pragma once

#include "haptics/base/text/JsonValue.h"
#include "haptics/sensation/Sensation.h"
#include "samples/tools/sense/SenseOutput.h"

#include <Eigen/Core>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace midair::samples
{

/// Messages of the AdapTics Designer and their answers: JSON objects {"cmd", "data"}, as in
/// AdapticsEngine's playback.rs and websocket.rs.

/// Parameters of a pattern by their names.
using DesignerParameters = std::map<std::string, double>;

/// Most parameters of a message.
constexpr std::size_t kMostDesignerParameters = haptics::Sensation::kMostParameters;

/// Reads an object of numbers. Throws InputError.
DesignerParameters parametersIn(const base::JsonValue& value);

/// Reads a 4 x 4 matrix in rows, mm. Returns it with its translation in m. Throws InputError if it
/// isn't a rotation and a translation.
Eigen::Matrix4d transformIn(const base::JsonValue& value);

/// Returns the JSON text of the pattern \a json with all its times earlier by \a begin_ms, so that
/// it begins there. \a json must be a pattern that readSensation() accepts.
std::string patternFrom(const std::string& json, double begin_ms);
/// The same for a pattern that was read.
haptics::Sensation patternFrom(haptics::Sensation sensation, double begin_ms);

/// A sample as the Designer is told it.
struct DesignerSample
{
    Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
    double intensity = 0.0;  ///< 0 .. 1
    double pattern_ms = 0.0; ///< time in the pattern
    double offset_ms = 0.0;  ///< that time minus the time since the start
    bool isStopped = false;
};

/// Returns the message playback_update. Numbers that aren't finite become 0.
std::string playbackUpdate(const std::vector<DesignerSample>& samples);

/// Returns the message tracking_data, as in AdapticsEngine's tracking/mod.rs: a hand's palm and
/// four bones of each digit, mm, in the pattern's frame; none: there is no hand. The thumb has
/// three bones and one of length 0, as with Leap Motion.
std::string trackingData(const std::optional<SenseHand>& hand);

/// Returns a message with what is wrong: {"cmd": "error", "data": {"message": ..}}. AdapTics has no
/// such message; the Designer writes to its console that it doesn't know it.
std::string errorMessage(const std::string& what);

} // namespace midair::samples
