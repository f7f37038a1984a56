#pragma once

#include "device/ArrayDevice.h"
#include "device/boards/BoardCodec.h"

#include <memory>

namespace midair::device
{

class DeviceUri;

/// Defaults of a board's serial port, for a URI without `baud` or `settle`.
struct SerialDefaults
{
    int baud = 115200;
    double settle_s = 0; ///< nothing is written for this time after opening
};

/// Opens a board at the serial port that \a uri names. Throws DeviceError.
std::unique_ptr<ArrayDevice> openOnSerialPort(DeviceUri& uri,
                                              const DeviceLayout& layout,
                                              std::unique_ptr<BoardCodec> codec,
                                              const SerialDefaults& defaults);

/// Opens a board behind the FT232H whose serial number \a uri names. Throws DeviceError.
std::unique_ptr<ArrayDevice>
openOnFifo(DeviceUri& uri, const DeviceLayout& layout, std::unique_ptr<BoardCodec> codec);

} // namespace midair::device
