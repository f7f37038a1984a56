#pragma once

namespace midair::samples
{

enum class MuteSignal
{
    NONE,
    MUTE,
    PLAY
};

/// From now on SIGUSR1 asks to mute the array and SIGUSR2 to let it play: for a switch on the wall,
/// a script, `systemctl kill --signal=USR1`.
void catchMuteSignals();

/// Returns the newest that came since the last call.
MuteSignal takeMuteSignal();

} // namespace midair::samples
