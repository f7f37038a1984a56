#pragma once

#include "samples/tools/solve/Solution.h"

#include <string>

namespace midair::samples
{

/// Draws the field of \a solution into field.png in \a folder, with the module midair-picture.so,
/// which is searched next to the program, in ../lib and where it is installed. Draws probes into
/// probe.png and tolerances into tolerance.png, if there are any. Returns an error message, or an
/// empty text.
std::string
drawPictures(const Solution& solution, const std::string& title, const std::string& folder);

} // namespace midair::samples

/// The only function that the module exports.
extern "C" void midairDrawPicture(const midair::samples::Solution& solution,
                                  const std::string& title,
                                  const std::string& path,
                                  std::string& problem);
