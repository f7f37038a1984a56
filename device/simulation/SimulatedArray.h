#pragma once

#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"
#include "device/boards/BoardCodec.h"
#include "device/drive/DriveSignal.h"
#include "device/simulation/VirtualBoard.h"
#include "device/simulation/VirtualFirmware.h"
#include "device/usb/Protocol.h"
#include "haptics/base/threads/Mutex.h"

#include <complex>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace midair::device
{

/// A simulated open board: fields go as its codec's bytes to a VirtualBoard, and its output is
/// kept. Has no lock: the owner guards it. Times never decrease.
class SimulatedBoard
{
public:
    using Activations = std::vector<std::complex<float>>;

    /// \a scheme: one of boardKinds(). Resets the board at time 0.
    SimulatedBoard(const std::string& scheme, int transducers);

    const BoardCodec& codec() const { return *_codec; }
    void play(const DriveSignal& signal, double now_s);
    /// Starts a sequence, which the board plays by itself. Sequences that a board stores, or
    /// exchanges at its line's rate, are given to it field by field here. Returns false if the
    /// board can't play it.
    bool playSequence(const DriveSequence& sequence, double now_s);
    /// Sends the fields of the sequence that are due.
    void advance(double now_s);
    void silence(double now_s);

    Activations playing() const { return _board->playing(); }
    std::vector<std::pair<double, Activations>> playedSince(double from_s) const
    {
        return _history.since(from_s);
    }

private:
    void give(double now_s); ///< _bytes

    const int _transducers;
    const std::unique_ptr<BoardCodec> _codec;
    const std::unique_ptr<VirtualBoard> _board;
    std::vector<std::uint8_t> _bytes;
    DriveSequence _inTurn;     ///< playing sequence; no signals: none
    double _inTurnSince_s = 0; ///< time when its first signal began
    std::int64_t _inTurnStep = 0;
    PlayedHistory<Activations> _history;
};

class DeviceUri;

/// s; largest ringing time constant of a simulation, as for array files.
constexpr double kMostSimulatedRinging_s = 0.01;

/// `sim:`: a simulated array. Sends the bytes for the hardware to a VirtualFirmware or
/// VirtualBoard; played() returns its output.
///
/// The URI's parameters simulate faults: `drop` and `corrupt` (probabilities per packet, 0 .. 1),
/// `seed`, `latency` (from commit to output), `fps` (maximum fields per second), `unplug_at`,
/// `replug_at`, `hang_at` (the host stops sending, so the watchdog mutes), the last three as times
/// since opening. `board` selects the protocol of an open board instead of osgMidair's own. It
/// keeps its recent output; `ringing` (0 .. 10 ms) is for computing pressures over time from it:
/// see DriveAbility::ringing_s.
class SimulatedArray : public ArrayDevice
{
public:
    /// The parameters of the URI; times are since opening.
    struct Options
    {
        double drop = 0;
        double corrupt = 0;
        unsigned seed = 1;
        double unplugAt_s = std::numeric_limits<double>::infinity();
        double replugAt_s = std::numeric_limits<double>::infinity();
        double hangAt_s = std::numeric_limits<double>::infinity();
        double ringing_s = -1; ///< below 0: not given
        std::string board;     ///< a scheme of boardKinds(); empty: osgMidair's own protocol
        VirtualFirmware::Options firmware;
    };
    static Options takeOptions(DeviceUri& uri);

    /// Throws DeviceError if the board is unknown or has another number of transducers.
    SimulatedArray(const DeviceLayout& layout, const Options& options);
    ~SimulatedArray() override;

    SimulatedArray(const SimulatedArray&) = delete;
    SimulatedArray& operator=(const SimulatedArray&) = delete;

    bool send(const DriveSignal& signal) override;
    void silence() override;
    double confirmed_s() const override;
    std::string status() const override;
    DeviceReport report() const override;
    bool sendSequence(const DriveSequence& sequence) override;
    DriveAbility ability() const override;
    bool identify(int board, bool light) override;
    std::vector<std::complex<float>> played() const override;
    std::vector<PlayedField> playedSince(double from_s) const override;
    std::vector<std::complex<float>> wouldPlay(const DriveSignal& signal) const override;

private:
    /// Advances the simulation and the faults to the present; returns the time since opening, s.
    double advance() const MIDAIR_REQUIRES(_mutex);
    bool sendPackets(const DriveSignal& signal, double now_s) MIDAIR_REQUIRES(_mutex);
    /// Sends _bytes to the firmware, with dropped and damaged packets.
    void deliver(double now_s) MIDAIR_REQUIRES(_mutex);
    void tell(const protocol::Packet& packet, double now_s) MIDAIR_REQUIRES(_mutex);
    void noteArrival(bool arrived, double asked_s) MIDAIR_REQUIRES(_mutex);
    bool unplugged(double now_s) const
    {
        return now_s >= _options.unplugAt_s && now_s < _options.replugAt_s;
    }

    const DeviceLayout _layout;
    const Options _options;
    const std::vector<protocol::Range> _ranges;
    const double _start_s;
    /// Null: our own protocol.
    const std::unique_ptr<SimulatedBoard> _board MIDAIR_PT_GUARDED_BY(_mutex);
    mutable FieldCounters _counters;   ///< any thread
    mutable VirtualFirmware _firmware; ///< any thread; of our own protocol

    // Reading advances the simulation to the present, which changes it.
    mutable base::Mutex _mutex;
    std::vector<std::uint8_t> _bytes MIDAIR_GUARDED_BY(_mutex);
    std::uint32_t _sequence MIDAIR_GUARDED_BY(_mutex) = 0;
    std::minstd_rand _random MIDAIR_GUARDED_BY(_mutex);
    mutable bool _lost MIDAIR_GUARDED_BY(_mutex) = false;
    mutable bool _unplugged MIDAIR_GUARDED_BY(_mutex) = false; ///< unplugAt_s has passed
    /// The firmware's count, as far as counted as faults.
    mutable std::uint32_t _watchdogs MIDAIR_GUARDED_BY(_mutex) = 0;
    /// Time of the first request that did not arrive, if none arrived since; otherwise infinite.
    mutable double _confirmed_s MIDAIR_GUARDED_BY(_mutex) = std::numeric_limits<double>::infinity();
};

} // namespace midair::device
