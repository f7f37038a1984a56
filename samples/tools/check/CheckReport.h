#pragma once

#include "samples/tools/check/SceneCheck.h"

#include <string>

namespace midair::samples
{

/// Returns the result for people, with a line for each thing.
std::string checkText(const CheckResult& result);

/// Returns the same as JSON.
std::string checkJson(const CheckResult& result);

/// "notice", "warning" or "fault".
const char* severityName(osgMidair::HapticMessage::Severity severity);

} // namespace midair::samples
