#pragma once

#include "device/autd3/Refusals.h"
#include "device/autd3/UnitGroup.h"

#include <cstdint>
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

} // namespace midair::device::autd3
