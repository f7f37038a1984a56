#pragma once

#include "samples/solve/Solution.h"

#include <string>

namespace midair::samples
{

/// Draws the field of \a solution into a PNG file at \a path, with the module midair-picture.so,
/// which is searched next to the program and in ../lib. Returns what went wrong, or an empty text.
std::string
drawPicture(const Solution& solution, const std::string& title, const std::string& path);

} // namespace midair::samples

/// Function that the module exports.
extern "C" void midairDrawPicture(const midair::samples::Solution& solution,
                                  const std::string& title,
                                  const std::string& path,
                                  std::string& problem);
