#include "device/boards/BoardKind.h"

#include "device/DeviceUri.h"
#include "device/boards/BoardDevice.h"
#include "device/usb/UsbTransferPool.h"

#include <vector>

#include <fmt/format.h>

namespace midair::device
{

namespace
{

// For the message that asks for a serial number: any FT232H may be another device, so only named
// ones are opened.
std::string pluggedInFifos(const std::string& scheme)
{
    std::vector<std::string> fifos;
    for (const UsbListing& one : listUsbDevices(kFifoAddress))
        fifos.push_back(fmt::format("{} ({})",
                                    one.serial.empty() ? "one without serial number"
                                                       : scheme + ":" + one.serial,
                                    one.condition));
    if (fifos.empty()) return "no FT232H is plugged in";
    return fmt::format("plugged in: {}", fmt::join(fifos, ", "));
}

} // namespace

extern const BoardKind kSonicSurface;
extern const BoardKind kUltraino;
extern const BoardKind kOpenMpd;

// A list, because linkers drop objects of a static library that nothing refers to, so
// self-registering files would be missing.
const std::vector<BoardKind>& boardKinds()
{
    static const std::vector<BoardKind> kKinds = {kSonicSurface, kUltraino, kOpenMpd};
    return kKinds;
}

std::unique_ptr<BoardCodec> makeBoardCodec(const std::string& scheme)
{
    for (const BoardKind& kind : boardKinds())
        if (scheme == kind.scheme) return kind.makeCodec();
    return nullptr;
}

std::unique_ptr<ArrayDevice> openOnSerialPort(DeviceUri& uri,
                                              const DeviceLayout& layout,
                                              std::unique_ptr<BoardCodec> codec,
                                              const SerialDefaults& defaults)
{
    uri.requirePath("a serial port");
    const int baud = static_cast<int>(uri.takeNumber("baud", defaults.baud, 0, 1e7));
    if (!SerialPort::knows(baud))
        throw uri.error(
            fmt::format("baud={} should be 9600, 57600, 115200, 230400, 460800 or 921600", baud));
    const double settle_s = uri.takeSeconds("settle", defaults.settle_s);
    uri.rejectUnknown();
    const std::string port = uri.path();
    return std::make_unique<BoardDevice>(
        uri.text(),
        std::move(codec),
        layout.transducers,
        [port, baud, settle_s](const std::vector<std::uint8_t>& lastWill)
        { return std::make_unique<SerialPort>(port, baud, lastWill, settle_s); });
}

std::unique_ptr<ArrayDevice>
openOnFifo(DeviceUri& uri, const DeviceLayout& layout, std::unique_ptr<BoardCodec> codec)
{
    uri.rejectUnknown();
    const std::string& serial = uri.path();
    if (serial.empty())
        throw uri.error("give its serial number, because an FT232H may be another device; " +
                        pluggedInFifos(uri.scheme()));
    return std::make_unique<BoardDevice>(uri.text(),
                                         std::move(codec),
                                         layout.transducers,
                                         [serial](const std::vector<std::uint8_t>& lastWill)
                                         { return std::make_unique<FtdiFifo>(serial, lastWill); });
}

} // namespace midair::device
