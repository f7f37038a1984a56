#pragma once

#include "device/DeviceUri.h"
#include "engine-bridge/hands/osc/OscReceiver.h"
#include "haptics/base/InputError.h"

namespace osgMidair
{

/// Takes address= and port= of "osc:?..": what a source listens at, and where a sender sends to.
inline midair::bridge::OscOptions takeOscOptions(midair::device::DeviceUri& uri)
{
    uri.rejectPath();
    midair::bridge::OscOptions options;
    options.address = uri.takeText("address", options.address);
    options.port = static_cast<int>(uri.takeNumber("port", options.port, 1, 65535));
    return options;
}

} // namespace osgMidair
