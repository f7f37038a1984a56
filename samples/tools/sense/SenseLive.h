#pragma once

#include "samples/tools/sense/SenseFiles.h"
#include "samples/tools/sense/SensePlayback.h"

#include <cstdint>
#include <string>
#include <vector>

namespace midair::samples
{

/// What is played, and when it ends.
struct SensePlayOptions
{
    std::string name;              ///< path of a file, or a classic
    std::vector<SetParameter> set; ///< by their times since the start
    double seconds = 0.0;          ///< 0: until the pattern stops
};

/// Plays a sensation until it stops, its time is over or the user ends it (isStopAsked()). Returns
/// an exit code of ToolOptions.h. Throws InputError.
int playSensation(const SensePlayOptions& options, const SensePlaybackOptions& on);

/// Plays what AdapTics Designers send to a port of this machine until the user ends it. \a origins:
/// pages that may connect besides those of this machine. Returns an exit code; throws InputError.
int serveDesigner(int port,
                  const std::vector<std::string>& origins,
                  const SensePlaybackOptions& on);

} // namespace midair::samples
