#pragma once

#include "samples/experiments/jnd/TrialFile.h"

#include <string>

namespace midair::samples
{

/// \{ `midair-jnd rehearse` and `midair-jnd plot`: what needs no array. Both return the program's
/// exit status; \a argv begins with the command's own name.
int rehearseCommand(int argc, char** argv);
int plotCommand(int argc, char** argv);
/// \}

/// Returns what a session found beside what the paper did, lines of text.
std::string summaryOf(const TrialFile& session);

/// Draws the plot of a session into a PNG file. Throws base::InputError.
void drawSession(const TrialFile& session, const std::string& path);

} // namespace midair::samples
