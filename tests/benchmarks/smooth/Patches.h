#pragma once

namespace midair::bench
{

/// Flat patches: one stationary field for ever denser points, the same evened out
/// (LevenbergMarquardt), and fields in turn.
void runPatches(bool quick);

} // namespace midair::bench
