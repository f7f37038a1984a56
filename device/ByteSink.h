#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <sys/types.h>

struct ftdi_context;

namespace midair::device
{

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
/// The boards on it have no watchdog. So a child process keeps the port open too, and when this process ends without
/// closing, be it by SIGKILL, it writes \a lastWill (the bytes that silence the board).
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
    void startGuard(const std::vector<std::uint8_t>& lastWill);

    int _port = -1;
    int _alive = -1; ///< one end of a socket: closed without a word means that this process died
    pid_t _guard = -1;
};

/// An FT232H in asynchronous FIFO mode, opened by its serial number.
class FtdiFifo : public ByteSink
{
public:
    explicit FtdiFifo(const std::string& serial); ///< throws DeviceError
    ~FtdiFifo() override;

    FtdiFifo(const FtdiFifo&) = delete;
    FtdiFifo& operator=(const FtdiFifo&) = delete;

    bool write(const std::vector<std::uint8_t>& bytes) override;

private:
    ftdi_context* _ftdi = nullptr;
};

} // namespace midair::device
