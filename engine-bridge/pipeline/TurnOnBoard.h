#pragma once

#include "engine-bridge/sensations/SteadyTurn.h"

#include <optional>
#include <utility>

namespace midair::bridge
{

/// Decides when a device should play sensations by itself: when its line is too slow for them, it
/// can store their fields, and they have repeated themselves for kRest_s.
class TurnOnBoard
{
public:
    /// Something that changes is played field by field for this time afterwards, as an upload may
    /// take longer than a field.
    static constexpr double kRest_s = 0.1;

    /// Takes what repeats itself at \a now_s, none if anything changes. Returns the fields that \a
    /// store should repeat; null: it gets them one by one.
    const haptics::StoredTurn*
    wanted(std::optional<SteadyTurn> steady, const haptics::TurnStore& store, double now_s)
    {
        if (!steady || !_steady || !_steady->isSame(*steady))
        {
            _stored = steady ? steady->storedIn(store) : std::nullopt;
            _steady = std::move(steady);
            _since_s = now_s;
            _isPlayed = false;
        }
        return _stored && now_s - _since_s >= kRest_s ? &*_stored : nullptr;
    }
    /// The sensations of these fields.
    const SteadyTurn& steady() const { return *_steady; }

    bool isPlayed() const { return _isPlayed; } ///< the device has them
    void notePlayed() { _isPlayed = true; }
    /// The device has something else, or the fields must be others.
    void forget() { *this = TurnOnBoard(); }

private:
    std::optional<SteadyTurn> _steady;
    std::optional<haptics::StoredTurn> _stored;
    double _since_s = 0.0;
    bool _isPlayed = false;
};

} // namespace midair::bridge
