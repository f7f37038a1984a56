#pragma once

#include "device/autd3/BankWriter.h"

#include <string>
#include <vector>

namespace midair::device::autd3
{

/// The masks of all units, which silence them at once. Masked, they are given a silent field; when
/// that plays on all, fail-safes are released and the masks are lifted, which nobody hears.
class UnitMasks
{
public:
    /// \a fault gets the last thing that went wrong, as a sentence.
    UnitMasks(UnitGroup& group, const Autd3Options& options, std::string& fault);

    void cover(); ///< all units, at once
    /// The fail-safe of \a unit has tripped, and is to be released before the masks are lifted.
    void noteTripped(int unit) { _isTripped[static_cast<std::size_t>(unit)] = true; }
    bool areOn() const { return _state != State::OFF; }
    /// Returns true if all units that are there have acknowledged the mask.
    bool areSilent() const { return areOn() && _open.none(); }

    /// Does what is due while nothing is on its way to the banks; returns true if the silent field
    /// is to be played now.
    bool step(double now_s);
    double due_s() const; ///< when step() has something to do without an outcome
    void noteSilentField(bool isPlayed, double now_s);
    void take(const UnitGroup::Outcome& outcome);
    void forgetLost();

private:
    enum class State
    {
        OFF,
        ON,
        RELEASING, ///< a silent field plays; fail-safes are released
        LIFTING
    };

    void push(int unit);
    void pushAll();

    UnitGroup& _group;
    const Autd3Options& _options;
    std::string& _fault;
    OpenCommands _open;
    State _state = State::OFF;
    std::vector<bool> _isTripped;
    double _again_s = 0; ///< not before: a silent field, or a release, was refused
};

} // namespace midair::device::autd3
