#pragma once

namespace midair::bench
{

/// Prints how old a finger's joints are when the drive signal that follows from them is handed to
/// the device: an OpenXR runtime's finger that moves on a surface in the array \a array, and frames
/// 90 times a second.
void printJointToDrive(const char* array, double seconds);

} // namespace midair::bench
