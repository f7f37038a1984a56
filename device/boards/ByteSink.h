#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

struct ftdi_context;

namespace midair::device
{

class SilenceOnCrash;

/// Byte connection to a board: a serial port or an FTDI chip. Only one thread at a time may use it.
class ByteSink
{
public:
    ByteSink();
    virtual ~ByteSink();
    ByteSink(const ByteSink&) = delete;
    ByteSink& operator=(const ByteSink&) = delete;

    /// Writes all of \a bytes; on failure returns false and sets error().
    virtual bool write(const std::vector<std::uint8_t>& bytes) = 0;
    /// Drops written bytes that have not left the computer, if possible.
    virtual void discard() {}
    /// Returns the written bytes that have not left the computer, if known, otherwise 0. Any
    /// thread.
    virtual std::size_t unsent() const { return 0; }
    /// Returns false and sets error() if the connection is gone, as far as visible without writing.
    virtual bool present() { return true; }
    /// Returns true if \a answer is among the bytes received since the last call.
    virtual bool hears(std::uint8_t /*answer*/) { return false; }
    /// Time after opening during which the starting board takes no bytes, s; 0: none.
    virtual double settle_s() const { return 0; }
    /// When that time ends (steadySeconds()).
    virtual double settled_s() const { return 0; }
    /// Time during which a board takes nothing if it receives bytes while starting, s: a Mega's
    /// bootloader stays about 6.5 s, with 1 s of settling.
    double held_s() const { return 4 * settle_s(); }
    /// Tells the guard process, which silences the board if this program hangs, that it is alive;
    /// call it every 100 ms. \a held: the board takes nothing for held_s() from now.
    void beat(bool held = false);
    /// Stops writing and makes the guard process write the bytes that silence the board; returns
    /// true if it could.
    bool bequeath();
    const std::string& error() const { return _error; }

protected:
    std::string _error;
    std::unique_ptr<SilenceOnCrash> _lastWill;
};

/// A serial port, raw, 8N1, opened exclusively. An advisory lock also stops root's programs that
/// check it.
///
/// If this process ends without closing the port, or hangs, a guard process writes \a lastWill, the
/// bytes that silence the board. Opening raises DTR, which resets an Arduino; closing leaves it
/// high, so that the next opening doesn't reset it.
class SerialPort : public ByteSink
{
public:
    /// The board takes no bytes within \a settle_s after opening. Throws DeviceError.
    SerialPort(const std::string& device,
               int baud,
               const std::vector<std::uint8_t>& lastWill,
               double settle_s = 0);
    ~SerialPort() override;
    static bool knows(int baud); ///< true if the baud rate is supported

    SerialPort(const SerialPort&) = delete;
    SerialPort& operator=(const SerialPort&) = delete;

    bool write(const std::vector<std::uint8_t>& bytes) override;
    void discard() override;
    std::size_t unsent() const override;

    bool present() override;
    bool hears(std::uint8_t answer) override;
    double settle_s() const override { return _settle_s; }
    double settled_s() const override { return _settled_s; }

private:
    int _port = -1;
    const double _settle_s;
    double _settled_s = 0;
};

/// An FT232H in asynchronous FIFO mode, opened by its serial number.
///
/// If this process ends without closing it, or hangs, a guard process writes \a lastWill, the bytes
/// that silence the board.
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
};

} // namespace midair::device
