#include "device/boards/ByteSink.h"

#include "device/ArrayDevice.h"
#include "device/DeviceLog.h"
#include "device/SilenceOnCrash.h"
#include "device/usb/UsbTransferPool.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <cerrno>
#include <map>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <ftdi.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

namespace midair::device
{

namespace
{

constexpr int kWriteTimeout_ms = 500;
/// Shorter than SilenceOnCrash's half a second, because beat() isn't called meanwhile.
constexpr int kFifoTimeout_ms = 300;
constexpr int kBeat_ms = 100;

/// B0: unsupported.
speed_t speedOf(int baud)
{
    static const std::map<int, speed_t> kSpeeds = {{9600, B9600},
                                                   {57600, B57600},
                                                   {115200, B115200},
                                                   {230400, B230400},
                                                   {460800, B460800},
                                                   {921600, B921600}};
    const auto found = kSpeeds.find(baud);
    return found == kSpeeds.end() ? B0 : found->second;
}

} // namespace

ByteSink::ByteSink() = default;
ByteSink::~ByteSink() = default;

void ByteSink::beat(bool held)
{
    if (_lastWill != nullptr) _lastWill->beat(held);
}

bool ByteSink::bequeath()
{
    return _lastWill != nullptr && _lastWill->execute();
}

SerialPort::SerialPort(const std::string& device,
                       int baud,
                       const std::vector<std::uint8_t>& lastWill,
                       double settle_s) :
    _settle_s(settle_s)
{
    const auto fail = [&](const std::string& what)
    {
        const bool taken = errno == EBUSY || errno == EWOULDBLOCK;
        const bool denied = errno == EACCES;
        const std::string reason =
            taken ? "another program has it" : what + std::generic_category().message(errno);
        if (_port >= 0) ::close(_port);
        throw DeviceError("serial port \"" + device + "\": " + reason +
                          (denied ? "; does your user belong to the group dialout?" : ""));
    };
    _port = ::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (_port < 0) fail("can't be opened: ");
    // In addition to TIOCEXCL, which doesn't stop root; before any setting changes, because another
    // program may be writing.
    if (::flock(_port, LOCK_EX | LOCK_NB) != 0) fail("can't be locked: ");
    termios settings{};
    if (::tcgetattr(_port, &settings) != 0) fail("isn't a serial port: ");
    ::cfmakeraw(&settings);
    settings.c_cflag =
        (settings.c_cflag & ~(CSTOPB | PARENB | CRTSCTS | CSIZE | HUPCL)) | CS8 | CLOCAL | CREAD;
    ::cfsetspeed(&settings, speedOf(baud));
    if (::tcsetattr(_port, TCSANOW, &settings) != 0)
        fail(fmt::format("doesn't support {} baud: ", baud));
    if (::ioctl(_port, TIOCEXCL) != 0) fail("can't be opened exclusively: ");
    _settled_s = base::steadySeconds() + settle_s;
    _lastWill = std::make_unique<SilenceOnCrash>(
        SilenceOnCrash::Way{_port, 0}, lastWill, _settled_s, held_s());
}

bool SerialPort::knows(int baud)
{
    return speedOf(baud) != B0;
}

SerialPort::~SerialPort()
{
    _lastWill.reset();
    ::close(_port);
}

bool SerialPort::present()
{
    pollfd port{_port, 0, 0};
    if (::poll(&port, 1, 0) <= 0 || (port.revents & (POLLERR | POLLHUP | POLLNVAL)) == 0)
        return true;
    _error = "unplugged";
    return false;
}

bool SerialPort::hears(std::uint8_t answer)
{
    std::uint8_t bytes[512];
    bool heard = false;
    for (ssize_t count = 0; (count = ::read(_port, bytes, sizeof bytes)) > 0;)
        heard = heard || std::find(bytes, bytes + count, answer) != bytes + count;
    return heard;
}

bool SerialPort::write(const std::vector<std::uint8_t>& bytes)
{
    std::size_t done = 0;
    int waited_ms = 0;
    while (done < bytes.size())
    {
        if (!present()) return false;
        const ssize_t count = ::write(_port, bytes.data() + done, bytes.size() - done);
        if (count > 0)
        {
            done += static_cast<std::size_t>(count);
            waited_ms = 0;
            continue;
        }
        if (count < 0 && errno == EINTR) continue;
        if (count < 0 && errno != EAGAIN)
        {
            _error = std::generic_category().message(errno);
            return false;
        }
        beat(); // so that waiting for the line doesn't count as hanging
        pollfd wait{_port, POLLOUT, 0};
        if (::poll(&wait, 1, kBeat_ms) == 0) waited_ms += kBeat_ms;
        if (waited_ms >= kWriteTimeout_ms)
        {
            _error = "takes no more bytes";
            return false;
        }
    }
    return true;
}

void SerialPort::discard()
{
    ::tcflush(_port, TCOFLUSH);
}

std::size_t SerialPort::unsent() const
{
    int bytes = 0;
    return ::ioctl(_port, TIOCOUTQ, &bytes) == 0 ? static_cast<std::size_t>(std::max(0, bytes)) : 0;
}

FtdiFifo::FtdiFifo(const std::string& serial, const std::vector<std::uint8_t>& lastWill) :
    _ftdi(ftdi_new())
{
    const auto fail = [&](const std::string& what)
    {
        const std::string reason = ftdi_get_error_string(_ftdi);
        ftdi_free(_ftdi);
        throw DeviceError("FT232H" + (serial.empty() ? std::string() : " \"" + serial + "\"") +
                          ": " + what + reason);
    };
    if (_ftdi == nullptr) throw DeviceError("FT232H: libftdi doesn't start");
    const int error = ftdi_usb_open_desc(_ftdi,
                                         kFifoAddress.vendor,
                                         kFifoAddress.product,
                                         nullptr,
                                         serial.empty() ? nullptr : serial.c_str());
    if (error == -3) // libftdi: no device matches
        fail("none is plugged in: ");
    if (error == -4 || error == -8)
        fail("permission denied; copy 70-osgmidair.rules, which osgMidair installs in "
             "lib/udev/rules.d, to "
             "/etc/udev/rules.d, run \"udevadm control --reload\" and plug the board in again: ");
    if (error == -5) fail("another program or the kernel's serial driver uses it: ");
    if (error < 0) fail("can't be opened: ");
    _ftdi->usb_write_timeout = kFifoTimeout_ms;
    if (ftdi_set_bitmode(_ftdi, 0xFF, BITMODE_RESET) < 0 ||
        ftdi_setflowctrl(_ftdi, SIO_DISABLE_FLOW_CTRL) < 0)
        fail("doesn't accept its settings: ");
    const int descriptor = descriptorOf(_ftdi->usb_dev, static_cast<unsigned>(_ftdi->interface));
    if (descriptor < 0)
        deviceLog().warn("FT232H: the board is not silenced if this program crashes: libusb's "
                         "descriptor isn't found");
    else // libftdi's in_ep is into the chip: an OUT endpoint
        _lastWill = std::make_unique<SilenceOnCrash>(
            SilenceOnCrash::Way{descriptor, static_cast<unsigned>(_ftdi->in_ep)}, lastWill);
}

FtdiFifo::~FtdiFifo()
{
    _lastWill.reset(); // first, because its child holds the device, so no other program could open
                       // it
    ftdi_usb_close(_ftdi);
    ftdi_free(_ftdi);
}

bool FtdiFifo::write(const std::vector<std::uint8_t>& bytes)
{
    const int count = ftdi_write_data(_ftdi, bytes.data(), static_cast<int>(bytes.size()));
    if (count == static_cast<int>(bytes.size())) return true;
    _error = count < 0 ? ftdi_get_error_string(_ftdi) : "takes no more bytes";
    return false;
}

} // namespace midair::device
