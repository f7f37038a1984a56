#pragma once

#include "device/simulation/VirtualBoard.h"

#include <atomic>
#include <complex>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

/// An open board at the other end of a pseudo-terminal: its firmware (VirtualBoard), the line's
/// rate, and where the board is an Arduino Mega, the reset by DTR and the bootloader before the
/// firmware.
///
/// A pseudo-terminal has no DTR. As a driver does, the first opening raises it, and the last
/// closing drops it unless HUPCL is off. The bootloader (arduino/ArduinoCore-avr,
/// stk500v2/stk500boot.c) listens for a second and then starts the sketch; once a byte came, it
/// waits for so long after the last one instead, some 6.5 s (8 million turns of a loop of 13
/// cycles), and what it is sent is lost. Both times are shorter here.
class BoardEmulator
{
public:
    struct Options
    {
        int baud = 230400;
        bool mega = false;
        double boot_s = 0.05; ///< until the sketch starts, if nothing is sent
        double held_s = 0.3;  ///< after the last byte, once something was
        bool answers = true;  ///< what the firmware sends back arrives
    };

    BoardEmulator(const std::string& board, int transducers, const Options& options);
    BoardEmulator(const std::string& board, int transducers);
    ~BoardEmulator();

    BoardEmulator(const BoardEmulator&) = delete;
    BoardEmulator& operator=(const BoardEmulator&) = delete;

    void start();                   ///< begins to take bytes
    void unplug();                  ///< from the computer; the board goes on by itself
    void plug();                    ///< under the same name
    void powerCycle();              ///< of the board, with the line left as it is
    void inject(std::uint8_t byte); ///< a byte that nobody sent, or that arrived as another one
    void damage(std::size_t nth);   ///< the nth byte from now arrives with its bits turned over

    const std::string& name() const { return _name; } ///< of the port
    std::vector<std::complex<float>> playing();
    bool silent(); ///< what sounds; boards in their bootloader are silent
    /// Whether it is silent and stays so when a swap comes that nobody asked for; false while bytes
    /// are on their way, too.
    bool silentInBothBuffers();
    int resets();    ///< by DTR
    bool isOpened(); ///< by a program, as far as it has seen
    bool starting();
    std::uint64_t swaps();
    std::uint64_t received(); ///< bytes
    std::uint64_t eaten();    ///< bytes of them, by the bootloader

private:
    void open();
    void run();
    bool pump();
    void watchLine();
    void consume(double now_s);
    void startUp(double now_s);
    void take(std::uint8_t byte, double now_s);

    bool silentLocked() const;

    const Options _options;
    const std::uint8_t _swap;
    const std::string _folder;
    const std::string _name;
    std::unique_ptr<midair::device::VirtualBoard> _board;
    std::mutex _mutex;
    std::deque<std::uint8_t> _buffer; ///< of the USB chip: bytes that the line hasn't carried yet
    int _master = -1;
    bool _opened = false; ///< by a program
    bool _dtr = false;
    bool _booting = false;
    double _sketchAt_s = 0;
    double _consumed_s = 0; ///< when the last byte had come over the line
    double _idle_s = 0;     ///< when nothing was on the line for the last time that is known
    std::size_t _damage = 0;
    int _resets = 0;
    int _emptyReads = 0; ///< in a row
    std::uint64_t _received = 0;
    std::uint64_t _eaten = 0;
    bool _held = false; ///< the bootloader, by a byte
    std::atomic<bool> _stop{false};
    std::thread _thread;
};

/// Whether two fields are the same to single precision.
inline bool near(const std::vector<std::complex<float>>& a,
                 const std::vector<std::complex<float>>& b)
{
    bool same = a.size() == b.size();
    for (std::size_t i = 0; same && i < a.size(); ++i)
        same = std::abs(a[i] - b[i]) < 1e-6F;
    return same;
}
