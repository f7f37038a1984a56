#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

struct ftdi_context;

namespace midair::device
{

class LastWill;

/// Where a board takes its bytes: a serial port or an FTDI chip. One thread at a time.
class ByteSink
{
public:
    virtual ~ByteSink() = default;

    /// All of \a bytes, or false with error() set.
    virtual bool write(const std::vector<std::uint8_t>& bytes) = 0;
    /// Forgets what was written and hasn't left the computer, where that can be done.
    virtual void discard() {}
    const std::string& error() const { return _error; }

protected:
    std::string _error;
};

/// A serial port, raw, 8N1, for this program alone.
///
/// When this process ends without closing, the board on it gets \a lastWill, the bytes that silence it.
class SerialPort : public ByteSink
{
public:
    /// Throws DeviceError.
    SerialPort(const std::string& device, int baud, const std::vector<std::uint8_t>& lastWill);
    ~SerialPort() override;
    static bool knows(int baud);

    SerialPort(const SerialPort&) = delete;
    SerialPort& operator=(const SerialPort&) = delete;

    bool write(const std::vector<std::uint8_t>& bytes) override;
    void discard() override;

private:
    int _port = -1;
    std::unique_ptr<LastWill> _lastWill;
};

/// An FT232H in asynchronous FIFO mode, opened by its serial number.
///
/// When this process ends without closing, the board behind it gets \a lastWill, the bytes that silence it.
class FtdiFifo : public ByteSink
{
public:
    /// Throws DeviceError.
    FtdiFifo(const std::string& serial, const std::vector<std::uint8_t>& lastWill);
    ~FtdiFifo() override;

    FtdiFifo(const FtdiFifo&) = delete;
    FtdiFifo& operator=(const FtdiFifo&) = delete;

    bool write(const std::vector<std::uint8_t>& bytes) override;

private:
    ftdi_context* _ftdi = nullptr;
    std::unique_ptr<LastWill> _lastWill;
};

} // namespace midair::device
