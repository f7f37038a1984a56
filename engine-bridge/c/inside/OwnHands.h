#pragma once

#include "engine-bridge/c/midair.h"
#include "engine-bridge/hands/Hand.h"

#include <cstddef>

namespace midair::capi
{

/// Returns a hand of the application's; fails, with the number \a index, for one that can't be.
bridge::Hand handOf(const midair_hand& given, std::size_t index);

} // namespace midair::capi
