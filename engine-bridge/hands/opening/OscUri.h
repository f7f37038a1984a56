#pragma once

#include "device/DeviceUri.h"
#include "engine-bridge/hands/osc/OscReceiver.h"
#include "haptics/base/InputError.h"

namespace midair::bridge
{

/// Takes address= and port= of "osc:?..": what a source listens at, and where a sender sends to.
inline OscOptions takeOscOptions(device::DeviceUri& uri)
{
    uri.rejectPath();
    OscOptions options;
    options.address = uri.takeText("address", options.address);
    options.port = static_cast<int>(uri.takeNumber("port", options.port, 1, 65535));
    return options;
}

} // namespace midair::bridge
