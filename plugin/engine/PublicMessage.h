#pragma once

#include "haptics/base/text/MessageLog.h"

#include <osgMidair/HapticMessage>

namespace osgMidair
{

/// The form of \a message that programs get.
inline HapticMessage toPublic(const midair::base::Message& message)
{
    return {static_cast<HapticMessage::Severity>(message.severity()),
            midair::base::kindOf(message.code).name,
            message.path,
            message.text,
            message.count};
}

} // namespace osgMidair
