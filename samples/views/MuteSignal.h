#pragma once

#include <osgMidair/HapticScene>

namespace midair::samples
{

/// From now on SIGUSR1 asks to mute the array and SIGUSR2 to let it play: for a switch on the wall,
/// a script, `systemctl kill --signal=USR1`.
void catchMuteSignals();

/// Mutes \a scene or lets it play, as the newest signal since the last call asks. To be called in
/// each frame.
void followMuteSignals(osgMidair::HapticScene& scene);

} // namespace midair::samples
