#pragma once

#include "device/ArrayDevice.h"
#include "device/boards/BoardCodec.h"
#include "device/limits/DeviceClaim.h"

#include <memory>
#include <string>
#include <vector>

namespace midair::device
{

class DeviceUri;

/// A kind of open board. Each kind is defined with its codec in its own file and listed in
/// BoardKind.cpp. Only the firmware imitated by `sim:` (VirtualBoard) and hints of the tool name
/// kinds elsewhere.
struct BoardKind
{
    const char* scheme; ///< of its URIs, without the colon
    const char* help;   ///< one line: "SCHEME:PATH" in 24 columns, then the description
    Owned owned;        ///< kind of the path of its URIs
    std::unique_ptr<BoardCodec> (*makeCodec)();
    /// Takes its parameters from the URI and opens the board; throws DeviceError.
    std::unique_ptr<ArrayDevice> (*open)(DeviceUri& uri, const DeviceLayout& layout);
};

/// All kinds, in the order of the help text.
const std::vector<BoardKind>& boardKinds();

/// Returns the codec for that scheme; null if there is none.
std::unique_ptr<BoardCodec> makeBoardCodec(const std::string& scheme);

/// Defaults for a serial port URI without `baud` or `settle`.
struct SerialDefaults
{
    int baud = 115200;
    double settle_s = 0; ///< nothing is written for this time after opening
};

/// Opens a board at the serial port in \a uri. Throws DeviceError.
std::unique_ptr<ArrayDevice> openOnSerialPort(DeviceUri& uri,
                                              const DeviceLayout& layout,
                                              std::unique_ptr<BoardCodec> codec,
                                              const SerialDefaults& defaults);

/// Opens a board behind the FT232H with the serial number in \a uri. Throws DeviceError.
std::unique_ptr<ArrayDevice>
openOnFifo(DeviceUri& uri, const DeviceLayout& layout, std::unique_ptr<BoardCodec> codec);

} // namespace midair::device
