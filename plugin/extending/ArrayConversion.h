#pragma once

#include "haptics/array/TransducerArray.h"

#include <osgMidair/ArrayDescription>

#include <stdexcept>
#include <string>

namespace osgMidair
{

/// Converts \a description for the solver. Throws midair::base::InputError, which names the array,
/// if it is invalid.
midair::haptics::TransducerArray arrayOf(const ArrayDescription& description);

/// Calls \a call. Returns false, with the message in \a error, if it throws an InputError or
/// DeviceError.
template<typename Call>
bool succeeds(const Call& call, std::string& error)
{
    try
    {
        call();
        return true;
    }
    catch (const std::runtime_error& wrong)
    {
        error = wrong.what();
        return false;
    }
}

/// Returns the description of a valid array.
ArrayDescription describe(const midair::haptics::TransducerArray& array);

} // namespace osgMidair
