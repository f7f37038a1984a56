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

/// One kind of open board: all that the rest of the library knows about it. Each kind is defined
/// with its codec in a file of its own, and listed in BoardKind.cpp. Only the firmware that `sim:`
/// imitates (VirtualBoard) and hints of the tool name kinds elsewhere.
struct BoardKind
{
    const char* scheme; ///< of its URIs, without the colon
    const char* help;   ///< one line: "SCHEME:PATH" in 24 columns, then what it is
    Owned owned;        ///< what the path of its URIs names
    std::unique_ptr<BoardCodec> (*makeCodec)();
    /// Takes its parameters from the URI and opens the board; throws DeviceError.
    std::unique_ptr<ArrayDevice> (*open)(DeviceUri& uri, const DeviceLayout& layout);
};

/// All kinds, in the order of the help text.
const std::vector<BoardKind>& boardKinds();

/// The codec of the kind with that scheme; null if there is none.
std::unique_ptr<BoardCodec> makeBoardCodec(const std::string& scheme);

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
