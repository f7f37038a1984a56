#pragma once

#include "samples/experiments/jnd/TrialFile.h"

#include <string>

namespace midair::samples
{

/// \{ `midair-jnd rehearse` and `midair-jnd plot`, which need no array. Both return the exit
/// status; \a argv begins with the command's own name.
int rehearseCommand(int argc, char** argv);
int plotCommand(int argc, char** argv);
/// \}

/// Returns a session's result next to the paper's, as lines of text.
std::string summaryOf(const TrialFile& session);

/// Draws a session into a PNG file. Throws base::InputError.
void drawSession(const TrialFile& session, const std::string& path);

} // namespace midair::samples
