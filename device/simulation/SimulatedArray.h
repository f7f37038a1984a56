#pragma once

#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"
#include "device/boards/BoardCodec.h"
#include "device/simulation/VirtualBoard.h"
#include "device/simulation/VirtualFirmware.h"
#include "device/usb/Protocol.h"

#include <limits>
#include <mutex>
#include <random>

namespace midair::device
{

class DeviceUri;

/// s; longest time constant that a simulation is asked to ring with, as that of arrays' files.
constexpr double kMostSimulatedRinging_s = 0.01;

/// `sim:`: a simulated array. Sends the bytes that hardware would get to a VirtualFirmware or
/// VirtualBoard; played() returns what that plays of them.
///
/// The URI's parameters simulate faults: `drop` and `corrupt` (probabilities per packet, 0 .. 1),
/// `seed`, `latency` (from commit to sound), `fps` (the most fields per second), `unplug_at`,
/// `replug_at`, `hang_at` (the host sends nothing more, so the watchdog mutes), the last three as
/// times since opening. `board` chooses the protocol of an open board instead of osgMidair's own.
/// It keeps what it has played in the last moments; `ringing` (0 .. 10 ms) is for whoever makes
/// pressures over time of that: see DriveAbility::ringing_s.
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
        double ringing_s = -1; ///< below 0: not said
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
    /// Brings the firmware and the faults to the present; returns the time since opening, s. With
    /// _mutex held.
    double advance() const;
    bool sendPackets(const DriveSignal& signal, double now_s);
    void deliver(double now_s); ///< sends _bytes to the firmware, with dropped and damaged packets
    void silenceLocked(double now_s);
    void noteArrival(bool arrived, double asked_s);
    void giveBoard(double now_s) const; ///< _bytes, to _board
    /// Gives the board the field of \a inTurn that is due at \a now_s, and those since the last
    /// call to the history.
    void playInTurn(double now_s) const;
    bool unplugged(double now_s) const
    {
        return now_s >= _options.unplugAt_s && now_s < _options.replugAt_s;
    }

    const DeviceLayout _layout;
    const Options _options;
    const std::vector<protocol::Range> _ranges;
    const double _start_s;
    const std::unique_ptr<BoardCodec> _codec;
    mutable std::mutex _mutex;
    mutable VirtualFirmware _firmware;
    const std::unique_ptr<VirtualBoard> _board;
    mutable PlayedHistory<std::vector<std::complex<float>>> _history; ///< of _board
    mutable std::vector<std::uint8_t> _bytes;
    DriveSequence _inTurn;     ///< that _board plays by itself; no signals: none
    double _inTurnSince_s = 0; ///< when its first signal began
    mutable std::int64_t _inTurnStep = 0;
    mutable FieldCounters _counters;
    mutable bool _lost = false;
    mutable bool _unplugged = false;      ///< unplugAt_s has passed
    mutable std::uint32_t _watchdogs = 0; ///< the firmware's, as far as counted as faults
    std::uint32_t _sequence = 0;
    /// When something was asked for that didn't arrive, if nothing has since; else infinite.
    mutable double _confirmed_s = std::numeric_limits<double>::infinity();
    std::minstd_rand _random;
};

} // namespace midair::device
