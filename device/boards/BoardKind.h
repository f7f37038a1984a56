#pragma once

#include "device/ArrayDevice.h"
#include "device/boards/BoardCodec.h"

#include <memory>
#include <string>
#include <vector>

namespace midair::device
{

class DeviceUri;

/// One kind of open board: everything that the rest of the library knows of it. A kind is defined
/// beside its codec, in a file of its own, and listed in BoardKind.cpp; nothing else names it.
struct BoardKind
{
    const char* scheme; ///< of its URIs, without the colon
    const char* help;   ///< one line: "SCHEME:PATH" in 24 columns, then what it is
    std::unique_ptr<BoardCodec> (*makeCodec)();
    /// Takes its parameters out of the URI; throws DeviceError.
    std::unique_ptr<ArrayDevice> (*open)(DeviceUri& uri, const DeviceLayout& layout);
};

/// All there are, in the order of the help text.
const std::vector<BoardKind>& boardKinds();

/// The codec of the kind of that scheme; null for any other name.
std::unique_ptr<BoardCodec> makeBoardCodec(const std::string& scheme);

} // namespace midair::device
