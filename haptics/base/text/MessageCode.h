#pragma once

#include "haptics/base/InputError.h"

#include <string>
#include <vector>

namespace midair::base
{

enum class Severity
{
    NOTICE,  ///< something is done otherwise than one may think
    WARNING, ///< something is left out, or not done as it was asked for
    FAULT    ///< nothing is played
};

/// What a message is about. There is no message without; plugin/MESSAGES.md has a line for each.
enum class MessageCode
{
    AIR_TEMPERATURE,
    ARRAY_DEAD,
    ARRAY_INVALID,
    ARRAY_READ_AGAIN,
    ARRAY_REFUSED,
    CALLBACK_THREW,
    CAP_EARS,
    CAP_PRESSURE,
    DEVICE_CAP,
    DEVICE_FAULT,
    DEVICE_HANGS,
    DEVICE_LOST,
    DEVICE_MUTED,
    DEVICE_OPEN,
    DEVICE_OPENED,
    DEVICE_REFUSED,
    DEVICE_SLOW,
    FIELD_FAILED,
    FIELD_REST,
    FIELD_SILENCED,
    FIELD_UNEVEN,
    GRANTS_FILE,
    GRANTS_REFUSED,
    GRANTS_TRUST,
    HANDS_OPEN,
    HANDS_PREDICTION,
    HANDS_SOURCE,
    HANDS_THREW,
    MODULATION_FREQUENCY,
    MODULATION_OVERRIDDEN,
    MODULATION_SUBSETS,
    MONITOR_FAILED,
    OBJECT_CAMERA,
    OBJECT_GEOMETRY,
    OBJECT_HIDDEN,
    OBJECT_INVALID,
    OBJECT_LARGE,
    OBJECT_SIDE,
    OBJECT_SMALL,
    OBJECT_UNFELT,
    OBJECT_UNITS,
    OBJECT_UNREACHABLE,
    OBJECT_UNTURNED,
    OBSTACLE_IDLE,
    OBSTACLE_INVALID,
    POINTS_BUDGET,
    POINTS_INVALID,
    PROPERTY_INVALID,
    PROPERTY_SILENCED,
    SCENE_CLOSED,
    SCENE_EMPTY,
    SCENE_INCOMPLETE,
    SCENE_INSIDE,
    SCENE_LIMIT,
    SCENE_UNMARKED,
    SETTINGS_CALIBRATION,
    SETTINGS_INVALID,
    SETTINGS_LIMITED,
    SETTINGS_SILENCED,
    SOLVER_REFUSED,
    SOLVER_REPORT,
    SOLVER_SLOW,
    VIEWER_SILENT
};

/// A row of the table of codes.
struct MessageKind
{
    MessageCode code;
    const char* name; ///< for programs, "device.lost"; it stays from version to version
    Severity severity;
    /// True: all messages with this code and path are one, whatever their texts; else those that
    /// differ in numbers alone.
    bool isOne;
};

/// All codes, one row each.
const std::vector<MessageKind>& messageKinds();
const MessageKind& kindOf(MessageCode code);

/// "notice", "warning" or "fault".
std::string severityName(Severity severity);

/// Input error that becomes a message of the code \a code.
class CodedError : public InputError
{
public:
    CodedError(MessageCode itsCode, const std::string& what) : InputError(what), code(itsCode) {}

    const MessageCode code;
};

} // namespace midair::base
