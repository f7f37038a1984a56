#pragma once

#include "device/ArrayDevice.h"
#include "device/autd3/Autd3Options.h"
#include "device/autd3/BankPlayer.h"
#include "device/autd3/DatagramLink.h"
#include "device/autd3/Refusals.h"
#include "device/autd3/UnitGroup.h"

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace midair::device::autd3
{

/// `autd3:`: AUTD3 units over UDP.
///
/// One thread has the socket. send() and the others leave what they want in a slot, where a newer
/// field replaces one that waits, and wake it. When units are lost it opens them again in the
/// background; they are silent until the next field.
class Autd3Device : public ArrayDevice
{
public:
    /// Opens the way to the units; throws DeviceError, also as soon as the function returns true.
    using LinkOpener = std::function<std::unique_ptr<DatagramLink>(const std::function<bool()>&)>;

    /// Throws DeviceError as Opening does, unless \a wait. \a opener: null, as the options say.
    Autd3Device(const DeviceLayout& layout,
                const Autd3Options& options,
                bool wait = false,
                LinkOpener opener = nullptr);
    ~Autd3Device() override; ///< masks all and waits at most 0.2 s until they confirm it

    Autd3Device(const Autd3Device&) = delete;
    Autd3Device& operator=(const Autd3Device&) = delete;

    bool send(const DriveSignal& signal) override;
    bool sendSequence(const DriveSequence& sequence) override;
    void silence() override;
    double confirmed_s() const override; ///< what all units have acknowledged
    std::string status() const override;
    DeviceReport report() const override;
    DriveAbility ability() const override;
    std::vector<std::complex<float>> played() const override;

    /// Figures of the thread, for benchmarks and tests.
    struct Figures
    {
        double cpu_s = 0; ///< that it has used
        std::uint64_t repeats = 0;
        std::uint64_t takenBack = 0;
        std::uint64_t torn = 0;
        std::uint64_t refusals = 0; ///< datagrams
        double lead_s = 0;
    };
    Figures figures() const;

private:
    /// What other threads want.
    struct Orders
    {
        std::shared_ptr<const Job> job; ///< the newest that waits
        bool silence = false;
        double silence_s = 0; ///< steady clock, when that was asked for
    };
    /// What plays, for played().
    struct Playing
    {
        std::shared_ptr<const Job> job; ///< null: silence
        double offset_ns = 0;           ///< the units' time less the host's
        std::vector<bool> isLost;       ///< of each unit
    };

    bool put(std::shared_ptr<Job> job);
    bool isClosing() const { return _closing.load(); }
    bool isClosedWithin(double atMost_s);
    void run();
    void connect(bool isBack); ///< throws DeviceError
    void disconnect(const std::string& why);
    /// Plays until units have to be opened again, and returns the reason; empty: closed.
    std::string play();
    void obey();
    void startNext();
    void settleEndings();
    void settle(const BankPlayer::Ending& ending);
    void receive(double now_s);
    void takeOutcomes(double now_s);
    void watch(const UnitGroup::Outcome& outcome);
    void watchClocks(double now_s);
    void askStates(double now_s, bool all);
    /// Why all have to be opened again; empty: go on.
    std::string losses(double now_s);
    std::string returns(double now_s); ///< the same, since one that was lost is there again
    void takeInfo(const Endpoint& from, const Answer& answer);
    void drop(const std::shared_ptr<const Job>& job);
    void noteFault(const std::string& what);
    void sayFarewell();
    void publish(double now_s);
    std::string complaint() const;

    const DeviceLayout _layout;
    const Autd3Options _options;
    const LinkOpener _opener;
    const std::string _name;

    mutable std::mutex _mutex;     ///< guards what follows, down to _link
    std::condition_variable _wake; ///< when it closes
    Orders _orders;
    bool _isOrdered = false; ///< the thread has not seen them yet
    DeviceReport _report;    ///< but for pending
    double _confirmed_s = 0;
    Playing _playing;
    std::string _firmware;
    std::string _refusalText;
    Figures _figures;
    std::shared_ptr<DatagramLink> _link; ///< used by the thread without the lock
    std::atomic<bool> _closing{false};

    // Used by the thread only.
    Refusals _refusals;
    std::unique_ptr<UnitGroup> _group;
    std::unique_ptr<BankPlayer> _player;
    std::shared_ptr<const Job> _next; ///< to be started
    double _silence_s = 0;            ///< Orders::silence_s of the one that isn't acknowledged
    int _tries = 0;                   ///< of the job that was disturbed
    double _looped_s = 0;             ///< when the loop ran last
    double _asked_s = 0;              ///< when a unit's state was asked for
    int _askNext = 0;
    double _heardPromptly_s = 0;
    double _published_s = 0;
    double _faultLogged_s = 0;
    double _opened_s = 0;
    double _looked_s = 0; ///< for units that are lost
    std::uint16_t _lookNumber = 0;
    std::string _back; ///< that one is there again; empty: none is
    std::vector<bool> _isHot;
    std::vector<bool> _isOutOfStep; ///< told

    std::thread _thread; ///< last: it uses all others
};

} // namespace midair::device::autd3

namespace midair::device
{
class DeviceUri;

/// Opens `autd3:`.
std::unique_ptr<ArrayDevice> openAutd3(DeviceUri& uri, const DeviceLayout& layout);
} // namespace midair::device
