#include "haptics/base/text/MessageCode.h"

namespace midair::base
{

// One line for each code.
// NOLINTNEXTLINE(readability-function-size)
const std::vector<MessageKind>& messageKinds()
{
    using C = MessageCode;
    using S = Severity;
    static const std::vector<MessageKind> all = {
        {C::AIR_TEMPERATURE, "air.temperature", S::WARNING, false},
        {C::ARRAY_DEAD, "array.dead", S::FAULT, true},
        {C::ARRAY_INVALID, "array.invalid", S::FAULT, false},
        {C::ARRAY_READ_AGAIN, "array.reread", S::NOTICE, true},
        {C::ARRAY_REFUSED, "array.refused", S::FAULT, true},
        {C::CALLBACK_THREW, "callback.threw", S::WARNING, false},
        {C::CAP_EARS, "cap.ears", S::NOTICE, true},
        {C::CAP_PRESSURE, "cap.pressure", S::NOTICE, true},
        {C::DEVICE_CAP, "device.cap", S::FAULT, true},
        {C::DEVICE_FAULT, "device.fault", S::FAULT, true},
        {C::DEVICE_HANGS, "device.hangs", S::FAULT, true},
        {C::DEVICE_LOST, "device.lost", S::FAULT, true},
        {C::DEVICE_MUTED, "device.muted", S::NOTICE, true},
        {C::DEVICE_OPEN, "device.open", S::FAULT, true},
        {C::DEVICE_OPENED, "device.opened", S::NOTICE, true},
        {C::DEVICE_REFUSED, "device.refused", S::FAULT, true},
        {C::DEVICE_SLOW, "device.slow", S::NOTICE, true},
        {C::FIELD_FAILED, "field.failed", S::FAULT, false},
        {C::FIELD_REST, "field.rest", S::WARNING, false},
        {C::FIELD_SILENCED, "field.silenced", S::FAULT, true},
        {C::FIELD_UNEVEN, "field.uneven", S::NOTICE, true},
        {C::GRANTS_FILE, "grants.file", S::WARNING, false},
        {C::GRANTS_REFUSED, "grants.refused", S::WARNING, false},
        {C::GRANTS_TRUST, "grants.trust", S::NOTICE, false},
        {C::HANDS_OPEN, "hands.open", S::WARNING, false},
        {C::HANDS_PREDICTION, "hands.prediction", S::WARNING, false},
        {C::HANDS_SOURCE, "hands.source", S::WARNING, false},
        {C::HANDS_THREW, "hands.threw", S::WARNING, false},
        {C::MODULATION_FREQUENCY, "modulation.frequency", S::WARNING, true},
        {C::MODULATION_OVERRIDDEN, "modulation.overridden", S::WARNING, true},
        {C::MODULATION_SUBSETS, "modulation.subsets", S::WARNING, true},
        {C::MONITOR_FAILED, "monitor.failed", S::WARNING, false},
        {C::OBJECT_CAMERA, "object.camera", S::WARNING, true},
        {C::OBJECT_GEOMETRY, "object.geometry", S::WARNING, false},
        {C::OBJECT_HIDDEN, "object.hidden", S::NOTICE, true},
        {C::OBJECT_INVALID, "object.invalid", S::WARNING, false},
        {C::OBJECT_LARGE, "object.large", S::WARNING, true},
        {C::OBJECT_SIDE, "object.side", S::NOTICE, true},
        {C::OBJECT_SMALL, "object.small", S::WARNING, true},
        {C::OBJECT_UNFELT, "object.unfelt", S::WARNING, true},
        {C::OBJECT_UNITS, "object.units", S::WARNING, true},
        {C::OBJECT_UNREACHABLE, "object.unreachable", S::WARNING, true},
        {C::OBJECT_UNTURNED, "object.unturned", S::NOTICE, true},
        {C::OBSTACLE_IDLE, "obstacle.idle", S::NOTICE, true},
        {C::OBSTACLE_INVALID, "obstacle.invalid", S::WARNING, false},
        {C::POINTS_BUDGET, "points.budget", S::WARNING, true},
        {C::POINTS_INVALID, "points.invalid", S::WARNING, false},
        {C::PROPERTY_INVALID, "property.invalid", S::WARNING, false},
        {C::PROPERTY_SILENCED, "property.silenced", S::FAULT, false},
        {C::SCENE_CLOSED, "scene.closed", S::FAULT, true},
        {C::SCENE_EMPTY, "scene.empty", S::WARNING, true},
        {C::SCENE_INCOMPLETE, "scene.incomplete", S::WARNING, true},
        {C::SCENE_INSIDE, "scene.inside", S::NOTICE, false},
        {C::SCENE_LIMIT, "scene.limit", S::FAULT, false},
        {C::SCENE_UNMARKED, "scene.unmarked", S::NOTICE, true},
        {C::SETTINGS_CALIBRATION, "settings.calibration", S::FAULT, true},
        {C::SETTINGS_INVALID, "settings.invalid", S::WARNING, false},
        {C::SETTINGS_LIMITED, "settings.limited", S::WARNING, false},
        {C::SETTINGS_SILENCED, "settings.silenced", S::FAULT, false},
        {C::SOLVER_REFUSED, "solver.refused", S::FAULT, false},
        {C::SOLVER_REPORT, "solver.report", S::NOTICE, false},
        {C::SOLVER_SLOW, "solver.slow", S::WARNING, true},
        {C::VIEWER_SILENT, "viewer.silent", S::FAULT, true},
    };
    return all;
}

// The rows stand in the order of the codes, which a test checks.
const MessageKind& kindOf(MessageCode code)
{
    return messageKinds().at(static_cast<std::size_t>(code));
}

std::string severityName(Severity severity)
{
    return severity == Severity::NOTICE    ? "notice"
           : severity == Severity::WARNING ? "warning"
                                           : "fault";
}

} // namespace midair::base
