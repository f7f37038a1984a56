#pragma once

#include "samples/tools/solve/Solution.h"

#include <string>

namespace midair::samples
{

/// Draws the field of \a solution into field.png in \a folder, with the module midair-picture.so,
/// which is searched next to the program, in ../lib and where it is installed; and what its probes
/// have heard and what tolerances cost, if any, into probe.png and tolerance.png. Returns what went
/// wrong, or an empty text.
std::string
drawPictures(const Solution& solution, const std::string& title, const std::string& folder);

} // namespace midair::samples

/// Function that the module exports, and nothing else.
extern "C" void midairDrawPicture(const midair::samples::Solution& solution,
                                  const std::string& title,
                                  const std::string& path,
                                  std::string& problem);
