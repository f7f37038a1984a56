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

/// Keeps an eye on units that are open: asks for their states, tells of heat and of clocks that are
/// out of step, finds those that are lost, and looks whether they are there again.
class UnitWatch
{
public:
    /// \a name: of the device, for the log.
    UnitWatch(UnitGroup& group, const std::string& name, Refusals& refusals);

    /// Asks for states that are due; \a all: at once.
    void askStates(double now_s, bool all);
    /// Takes what a unit says of its state; returns true if its fail-safe has tripped.
    bool takeState(const UnitGroup::Outcome& outcome);
    void watchClocks(double now_s);
    /// Which units are lost since the last call, and why; empty: none.
    std::string losses(double now_s);
    /// Why all should be opened again, since one that was lost is there; empty: go on.
    std::string returns(double now_s);
    std::vector<bool> lost() const; ///< of each unit, as losses() said
    /// What is wrong with units, as a sentence; empty: nothing.
    std::string complaint() const;

private:
    /// What was told of a unit.
    struct Told
    {
        bool isHot = false;
        bool isOutOfStep = false;
        bool isLost = false;
    };
    /// One unit after the other is asked for its state.
    struct Asking
    {
        double last_s = 0;
        int next = 0;
    };
    /// Looking for units that are lost.
    struct Looking
    {
        double opened_s = 0; ///< all units
        double last_s = 0;
        std::uint16_t number = 0; ///< of the message
        std::string found;        ///< that one is there again; empty: none is
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

/// Plays on units that are open, from their opening until they have to be opened again or the
/// device is closed. Used by the device's thread.
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

    /// Plays until units have to be opened again, and returns the reason; empty: closed. Then all
    /// are masked, and what is left is to be ended.
    std::string play();
    /// Gives up what is on its way and what waits, and tells the account.
    void end(const std::string& why);

private:
    /// When the thread last did what it does every so often.
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
    std::string losses(double now_s); ///< why all have to be opened again; empty: go on
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
    std::shared_ptr<const Job> _next; ///< to be started
    int _tries = 0;                   ///< of the job that was disturbed
    double _silence_s = 0;            ///< when that was asked for which isn't acknowledged
    Rounds _rounds;
};

} // namespace midair::device::autd3
