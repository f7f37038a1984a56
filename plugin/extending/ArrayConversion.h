#pragma once

#include "haptics/array/TransducerArray.h"

#include <osgMidair/ArrayDescription>

#include <stdexcept>
#include <string>

namespace osgMidair
{

/// Returns \a description as the solver takes it. Throws midair::base::InputError, which names the
/// array, if it is not valid.
midair::haptics::TransducerArray arrayOf(const ArrayDescription& description);

/// Calls \a call. Returns false, with what is wrong in \a error, if it throws that (InputError,
/// DeviceError).
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
