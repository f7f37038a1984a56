#pragma once

namespace midair::bench
{

/// Prints what touch costs the update thread with a surface of 65,536 vertices, still and deforming
/// in each frame, with two open hands over, at and in it.
void printTouching();

} // namespace midair::bench
