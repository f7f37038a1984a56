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

} // namespace midair::device
