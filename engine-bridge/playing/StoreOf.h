#pragma once

#include "device/ArrayDevice.h"
#include "haptics/sensation/StoredTurn.h"

#include <algorithm>

namespace midair::bridge
{

/// Returns how a device of \a ability takes fields, one by one at most \a fieldRate_Hz.
inline haptics::TurnStore storeOf(const device::DriveAbility& ability, double fieldRate_Hz)
{
    haptics::TurnStore store;
    store.carried_Hz = ability.fieldsPerSecond > 0.0
                           ? std::min(fieldRate_Hz, ability.fieldsPerSecond)
                           : fieldRate_Hz;
    store.fields = ability.sequenceFields;
    store.clock_Hz = ability.sequenceClock_Hz;
    if (ability.amplitudes.size() == 2) store.leastOfPeriod = haptics::TurnStore::kLeastOnOff;
    return store;
}

} // namespace midair::bridge
