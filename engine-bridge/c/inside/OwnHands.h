#pragma once

#include "engine-bridge/c/midair.h"
#include "engine-bridge/hands/HandSource.h"

#include <cstddef>
#include <memory>
#include <string>

namespace midair::capi
{

/// Opens "recorded:FILE", "recorded:FILE?loop", "openxr:" or "NAME:options" of one that the
/// application registered; null for "" and "none". Fails with the known ones.
std::unique_ptr<bridge::HandSource> openHands(const std::string& uri);

/// Returns a hand of the application's; fails, with the number \a index, for one that can't be.
bridge::Hand handOf(const midair_hand& given, std::size_t index);

} // namespace midair::capi
