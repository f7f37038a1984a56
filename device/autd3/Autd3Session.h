#pragma once

#include "device/autd3/Autd3Account.h"
#include "device/autd3/Autd3Options.h"
#include "device/autd3/BankPlayer.h"
#include "device/autd3/DatagramLink.h"
#include "device/autd3/UnitGroup.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace midair::device::autd3
{

/// Monitors open units: requests their states, reports heat and unsynchronised clocks, finds lost
/// units, and checks whether they are back.
class UnitWatch
{
public:
    /// \a name: of the device, for the log.
    UnitWatch(UnitGroup& group, const std::string& name, Refusals& refusals);

    /// Requests the states that are due; \a all: immediately.
    void askStates(double now_s, bool all);
    /// Processes a unit's state; returns true if its fail-safe has tripped.
    bool takeState(const UnitGroup::Outcome& outcome);
    void watchClocks(double now_s);
    /// Returns newly lost units with the reason; empty: none.
    std::string losses(double now_s);
    /// Returns the reason to reopen all units, because a lost one is back; empty: none.
    std::string returns(double now_s);
    std::vector<bool> lost() const; ///< for each unit, by losses()
    /// Returns the problem of units, as a sentence; empty: none.
    std::string complaint() const;

private:
    /// Reports already made about a unit.
    struct Told
    {
        bool isHot = false;
        bool isOutOfStep = false;
        bool isLost = false;
    };
    /// Round-robin state requests.
    struct Asking
    {
        double last_s = 0;
        int next = 0;
    };
    /// Search for lost units.
    struct Looking
    {
        double opened_s = 0; ///< of all units
        double last_s = 0;
        std::uint16_t number = 0; ///< of the message
        std::string found;        ///< a unit that is back; empty: none
    };

    Told& told(int unit) { return _told[static_cast<std::size_t>(unit)]; }
    void takeInfo(const Endpoint& from, const Answer& answer);

    UnitGroup& _group;
    const std::string& _name;
    Refusals& _refusals;
    std::vector<Told> _told;
    Asking _asking;
    Looking _looking;
};

/// Plays on open units until they must be reopened or the device closes. Used by the device's
/// thread.
class Autd3Session
{
public:
    /// Opens the units behind \a link; throws DeviceError. \a name: of the device, for the log.
    Autd3Session(std::shared_ptr<DatagramLink> link,
                 const Autd3Options& options,
                 const std::string& name,
                 Refusals& refusals,
                 Autd3Account& account,
                 bool isBack);

    /// Plays until units must be reopened, and returns the reason; empty: closed. All units are
    /// then masked; call end() next.
    std::string play();
    /// Gives up jobs in progress and waiting, and reports this to the account.
    void end(const std::string& why);

private:
    /// Times of the last periodic actions.
    struct Rounds
    {
        double looped_s = 0;
        double heardPromptly_s = 0;
        double published_s = 0;
        double faultLogged_s = 0;
    };

    void obey();
    void startNext();
    void settleEndings();
    void settle(const BankPlayer::Ending& ending);
    void receive(double now_s);
    void takeOutcomes(double now_s);
    void takeState(const UnitGroup::Outcome& outcome);
    std::string losses(double now_s); ///< reason to reopen all units; empty: none
    void sayFarewell();
    void publish(double now_s);

    const Autd3Options& _options;
    const std::string& _name;
    Refusals& _refusals;
    Autd3Account& _account;
    const std::shared_ptr<DatagramLink> _link;
    const std::unique_ptr<UnitGroup> _group;
    BankPlayer _player;
    UnitWatch _watch;
    std::shared_ptr<const Job> _next; ///< next job
    int _tries = 0;                   ///< of the disturbed job
    double _silence_s = 0;            ///< time of the unacknowledged request
    Rounds _rounds;
};

} // namespace midair::device::autd3
