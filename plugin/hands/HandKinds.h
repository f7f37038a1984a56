#pragma once

#include <string>

namespace osgMidair
{

/// Returns what is wrong with \a uri if it names no kind of hand source that this program has;
/// empty if it does, or is "" or "none". Opens nothing.
std::string unknownHands(const std::string& uri);

} // namespace osgMidair
