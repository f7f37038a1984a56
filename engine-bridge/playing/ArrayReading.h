#pragma once

#include <osgMidair/ArrayState>

#include <string>

namespace midair::bridge
{

/// What an array does, and what became of its fields: all by one report of its device.
struct ArrayReading
{
    ArrayState state = ArrayState::CLOSED;
    ArrayFields fields; ///< none while no device is open
    std::string status; ///< of the device, for people
};

} // namespace midair::bridge
