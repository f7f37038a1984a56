#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

struct ftdi_context;

namespace midair::device
{

class SilenceOnCrash;

/// Where a board takes its bytes: a serial port or an FTDI chip. One thread at a time.
class ByteSink
{
public:
    ByteSink();
    virtual ~ByteSink();
    ByteSink(const ByteSink&) = delete;
    ByteSink& operator=(const ByteSink&) = delete;

    /// All of \a bytes, or false with error() set.
    virtual bool write(const std::vector<std::uint8_t>& bytes) = 0;
    /// Forgets what was written and hasn't left the computer, where that can be done.
    virtual void discard() {}
    /// Whether the way is still there, as far as that can be told without writing; false with
    /// error() set.
    virtual bool present() { return true; }
    /// Whether \a answer is among the bytes that came back since this was asked last.
    virtual bool hears(std::uint8_t /*answer*/) { return false; }
    /// How long a board that starts when it is opened takes nothing; 0: no such board.
    virtual double settle_s() const { return 0; }
    /// When that ends (steadySeconds()).
    virtual double settled_s() const { return 0; }
    /// How long it takes nothing after it was sent something in that time: a Mega's bootloader
    /// some 6.5 s, where settling takes 1 s.
    double held_s() const { return 4 * settle_s(); }
    /// A sign of life for whoever silences the board when this program hangs, to be given every 100
    /// ms. \a held: the board takes nothing, for held_s() from now.
    void beat(bool held = false);
    /// Gives up writing: whoever else holds the board writes its last will. Whether it could.
    bool bequeath();
    const std::string& error() const { return _error; }

protected:
    std::string _error;
    std::unique_ptr<SilenceOnCrash> _lastWill;
};

/// A serial port, raw, 8N1, for this program alone: also programs of root are told, by a lock.
///
/// When this process ends without closing, or hangs, the board on it gets \a lastWill, the bytes
/// that silence it. Opening raises DTR, which resets an Arduino; closing leaves it high, so that
/// the next opening doesn't.
class SerialPort : public ByteSink
{
public:
    /// The board on it takes nothing in the first \a settle_s. Throws DeviceError.
    SerialPort(const std::string& device,
               int baud,
               const std::vector<std::uint8_t>& lastWill,
               double settle_s = 0);
    ~SerialPort() override;
    static bool knows(int baud);

    SerialPort(const SerialPort&) = delete;
    SerialPort& operator=(const SerialPort&) = delete;

    bool write(const std::vector<std::uint8_t>& bytes) override;
    void discard() override;

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
/// When this process ends without closing, or hangs, the board behind it gets \a lastWill, the
/// bytes that silence it.
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
